//! What judges pictures and predictions: comparison, reports of error against time, spectra against measured ones.

pub mod compare;
pub mod plot;
pub mod regions;
pub mod report;
pub mod spectrum;
