//! Pairs of an eye ray and a beam, for hosts with a hierarchy of their own.

pub(crate) mod cross;
mod filter;
mod gather;
#[cfg(test)]
mod tests;
