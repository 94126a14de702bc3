//! The house's own rules: what sources, headers and documents must keep to.

mod circles;
mod debts;
mod figures;
mod guards;
mod header;
mod imports;
mod packages;
mod processors;
mod rooms;
mod sizes;
