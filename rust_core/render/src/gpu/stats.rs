//! Counts and times of the GPU renderer's work, to see whether it does more than it should.

use std::time::Duration;

/// Since the device was opened: a lost device loses its figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GpuStats {
    /// Images that were begun on the GPU.
    pub images: u64,
    /// Uploads of buffers, and of levels or tiles of images.
    pub uploads: u64,
    /// Bytes uploaded.
    pub uploaded_bytes: u64,
    /// Draws of drawables; neighbours that are drawn together count as one.
    pub draws: u64,
    /// Pipelines that were built.
    pub pipelines: u64,
    /// Targets that were made: an image's textures with the buffers for reading it back.
    pub targets: u64,
    /// Time spent on listing draws and uploading new geometry.
    pub prepare: Duration,
    /// Time spent on recording and submitting.
    pub submit: Duration,
    /// Time spent waiting for the GPU, which draws and copies the image back.
    pub wait: Duration,
    /// Time spent on encoding images out of the GPU's memory.
    pub copy: Duration,
}
