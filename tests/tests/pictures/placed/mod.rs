//! Placed geometry: what rays are inside of, what eye and light paths do there, and that pictures know no bounds within fog.

mod insides;
mod panes;
mod paths;
mod pictures;
mod rays;
mod scenes;
