//! Scenes that hosts describe, and sessions that render them.

mod builds;
mod curvature;
mod edges;
mod fogs;
mod goals;
mod hosts;
mod instances;
mod own;
mod scenes;
mod sessions;
mod shapes;
mod shapes_described;
mod sums;
mod visibility;
