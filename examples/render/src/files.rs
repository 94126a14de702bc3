//! Files that the program writes and reads: pictures, sums of passes, and what passes need of earlier ones.

mod exr_format;
pub mod maps;
pub mod output;
pub mod prepared;
pub mod preview;
pub mod shard;
pub mod stored;
