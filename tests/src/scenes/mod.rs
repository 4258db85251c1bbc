//! Scenes by their size: what the benchmarks and the allocation test draw.

pub mod clouds;
pub mod display_pipeline;
pub mod many_solids;
pub mod rendering;
pub mod solids;
