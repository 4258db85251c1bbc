//! The files that the programs read and write, each format in one place: a projector's geometry ([`projector`]), point
//! clouds ([`pcd`]) and pictures ([`picture_file`]).

#![forbid(unsafe_code)]

pub mod atomic_file;
pub mod pcd;
pub mod picture_file;
pub mod projector;
