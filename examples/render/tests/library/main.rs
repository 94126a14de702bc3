//! What the library reads and writes, and what it makes of pictures.

mod compare;
mod film;
mod fingerprint;
mod output;
mod scene_file;
mod truth;
mod volume;
