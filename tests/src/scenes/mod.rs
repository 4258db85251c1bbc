//! Scenes by their size: what the benchmarks and the allocation test draw.

pub mod clouds;
pub mod played;
pub mod shot;
pub mod solids;
