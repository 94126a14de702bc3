//! The program as a user meets it: what it writes, says and returns.

mod cli;
mod common;
mod hostile;
mod pieces;
mod report;
mod spectrum;
