//! Geometry and whole pictures: what the renderer shows, against closed forms and by estimators that share nothing.

mod cameras;
mod closed_forms;
mod coincident;
mod edges;
mod edges_mesh;
mod fleet;
mod geometry;
mod glow;
mod guided;
mod heterogeneous;
mod lamps;
mod lobes;
mod march;
mod mesh;
mod placed;
mod planned;
mod render;
mod shapes;
mod shown;
mod skies;
mod snapped;
mod sun;
