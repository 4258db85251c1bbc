//! What the GPU renderer has done, counted and timed, for those who look whether it does more than it should.

use std::time::Duration;

/// Since the device was opened: a device that is lost takes its figures with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GpuStats {
    /// Pictures that were begun.
    pub pictures: u64,
    /// Times that a geometry or an image was brought to the GPU. Large ones go in several pieces, each of which counts.
    pub uploads: u64,
    /// How many bytes that were.
    pub uploaded_bytes: u64,
    /// Pipelines that were built.
    pub pipelines: u64,
    /// Pictures' textures with their buffers for the way back that were made.
    pub targets: u64,
    /// Time that went into listing what is to be drawn and uploading what is new.
    pub prepare: Duration,
    /// Time that went into recording and submitting.
    pub submit: Duration,
    /// Time that was spent waiting for the GPU, which draws and copies the picture back.
    pub wait: Duration,
    /// Time that went into encoding pictures out of the GPU's memory.
    pub copy: Duration,
}
