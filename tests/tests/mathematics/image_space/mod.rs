//! Image space: the picture's spectrum, its filters, which pixels get rays, regions, and the picture from the rays.

mod contacts;
mod filter;
mod hostile;
mod lattice;
mod mask;
mod reconstruction;
mod regions;
mod spectrum;
mod structure;
mod verify;
