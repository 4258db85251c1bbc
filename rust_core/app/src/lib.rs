//! What the programs need besides the other crates: the files that they read.

mod lzf;
pub mod pcd;
mod pcd_header;
pub mod projector_file;
