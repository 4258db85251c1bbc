//! An opened adapter: which one is chosen, and how its errors are reported.
//!
//! wgpu panics where it finds an error that nobody catches. Here the first error is recorded, and [`Device::check`]
//! returns it once an image's work is done. The device is dropped then.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use rayon::prelude::*;
use wgpu::{Adapter, Backend, Backends, DeviceType};

use super::hardware::may_have_gpu;
use super::stats::GpuStats;
use crate::RenderError;

/// How long an image may take: drivers reset a GPU that hangs after some seconds.
const PATIENCE: Duration = Duration::from_secs(30);

/// A GPU that can be drawn on.
#[derive(Debug)]
pub(super) struct Device {
    pub(super) wgpu: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    /// The limits that it was opened with.
    pub(super) limits: wgpu::Limits,
    /// The adapter's name and the backend.
    pub(super) name: String,
    /// The first error.
    fault: Arc<OnceLock<String>>,
    stats: Mutex<GpuStats>,
    /// How long an image is waited for.
    pub(super) patience: Duration,
    /// True if it was waited for in vain. To drop it may then take for ever.
    pub(super) is_hung: AtomicBool,
}

impl Device {
    /// Opens the best adapter that works: hardware before software, discrete before integrated, Vulkan before GL. GL
    /// is not tried where Vulkan has hardware.
    pub(super) fn open(hardware_only: bool) -> Result<Self, RenderError> {
        if hardware_only && !may_have_gpu() {
            return Err(RenderError::NoAdapter { reason: "there is no device file of a GPU".into() });
        }
        let allowed = Backends::from_env().unwrap_or(Backends::all());
        let wanted = std::env::var("WGPU_ADAPTER_NAME").unwrap_or_default().to_lowercase();
        let mut failure = None;
        let mut software = Vec::new();
        for backends in [Backends::VULKAN, Backends::GL] {
            let mut adapters = adapters(backends & allowed);
            adapters.retain(|adapter| adapter.get_info().name.to_lowercase().contains(&wanted));
            adapters.sort_by_key(rank);
            let is_hardware = |adapter: &Adapter| kind(adapter) != DeviceType::Cpu;
            let (hardware, others): (Vec<_>, Vec<_>) = adapters.into_iter().partition(is_hardware);
            if let Some(device) = open_first(hardware, &mut failure) {
                return Ok(device);
            }
            software.extend(others);
        }
        if !hardware_only {
            if let Some(device) = open_first(software, &mut failure) {
                return Ok(device);
            }
        }
        Err(failure.unwrap_or_else(|| RenderError::NoAdapter {
            reason: match (hardware_only, wanted.is_empty()) {
                (true, true) => "there is no hardware with a Vulkan or GL driver".into(),
                (false, true) => "there is no Vulkan or GL driver".into(),
                (_, false) => format!("none is named {wanted}"),
            },
        }))
    }

    fn request(adapter: &Adapter) -> Result<Self, RenderError> {
        let info = adapter.get_info();
        let name = format!("{}, {}", info.name, info.backend);
        let mut limits = wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits());
        // A mesh, or an image that is read back, is one buffer.
        limits.max_buffer_size = adapter.limits().max_buffer_size;
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits.clone(), ..Default::default() };
        #[expect(clippy::disallowed_methods, reason = "the driver's start; a second signal ends the program")]
        let (wgpu, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| RenderError::Gpu { adapter: name.clone(), reason: error.to_string() })?;
        let fault: Arc<OnceLock<String>> = Arc::default();
        let (errors, losses) = (fault.clone(), fault.clone());
        wgpu.on_uncaptured_error(Arc::new(move |error: wgpu::Error| _ = errors.set(error.to_string())));
        wgpu.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                _ = losses.set(format!("the device was lost: {message}"));
            }
        });
        let (stats, patience, is_hung) = (Mutex::default(), PATIENCE, AtomicBool::new(false));
        Ok(Self { wgpu, queue, limits, name, fault, stats, patience, is_hung })
    }

    /// Waits until a submission is done.
    ///
    /// # Errors
    /// wgpu's, or that it has taken too long.
    pub(super) fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), RenderError> {
        let timeout = Some(self.patience);
        let polled = self.wgpu.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout });
        self.check()?;
        match polled {
            Ok(_) => Ok(()),
            Err(wgpu::PollError::Timeout) => {
                self.is_hung.store(true, Ordering::Release);
                Err(self.error(format!("it has not answered for {} s", self.patience.as_secs())))
            }
            Err(error) => Err(self.error(error.to_string())),
        }
    }

    /// An error with this reason.
    pub(super) fn error(&self, reason: impl Into<String>) -> RenderError {
        RenderError::Gpu { adapter: self.name.clone(), reason: reason.into() }
    }

    /// The first error that there was.
    pub(super) fn check(&self) -> Result<(), RenderError> {
        self.fault.get().map_or(Ok(()), |reason| Err(self.error(reason)))
    }

    /// Counts and times of the work done on it.
    pub(super) fn stats(&self) -> GpuStats {
        *self.stats.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts work done on it.
    pub(super) fn count(&self, note: impl FnOnce(&mut GpuStats)) {
        note(&mut self.stats.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// Counts an upload of a geometry or an image.
    pub(super) fn count_upload(&self, bytes: usize) {
        self.count(|stats| {
            stats.uploads += 1;
            stats.uploaded_bytes += bytes as u64;
        });
    }

    /// A texture for shaders to read.
    pub(super) fn texture(
        &self,
        label: &str,
        size: wgpu::Extent3d,
        mip_level_count: u32,
        format: wgpu::TextureFormat,
    ) -> wgpu::Texture {
        self.wgpu.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    }

    /// Uploads texels, row by row, to a part of a texture.
    pub(super) fn write_texture(&self, to: wgpu::TexelCopyTextureInfo<'_>, texels: &[u8], size: wgpu::Extent3d) {
        self.count_upload(texels.len());
        let bytes_per_row = Some(texels.len() as u32 / size.height);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
        self.queue.write_texture(to, texels, layout, size);
    }

    /// A buffer of this number of bytes.
    pub(super) fn empty_buffer(&self, label: &str, usage: wgpu::BufferUsages, bytes: usize) -> wgpu::Buffer {
        self.wgpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes as u64,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Writes an image's values to a buffer. Returns true if that was replaced, because they did not fit.
    pub(super) fn rewrite(&self, buffer: &mut wgpu::Buffer, values: &[u8]) -> bool {
        let is_too_small = values.len() as u64 > buffer.size();
        if is_too_small {
            *buffer = self.empty_buffer("values of a picture", buffer.usage(), values.len().next_power_of_two());
        }
        self.queue.write_buffer(buffer, 0, values);
        is_too_small
    }

    /// A buffer with this content, which all cores copy.
    pub(super) fn buffer(&self, label: &str, usage: wgpu::BufferUsages, content: &[u8]) -> wgpu::Buffer {
        const SHARE_BYTES: usize = 1 << 18;
        self.written_buffer(label, usage, content.len(), |memory| {
            let (shares, mut rest) = memory.into_chunks::<SHARE_BYTES>();
            let (whole, last) = content.as_chunks::<SHARE_BYTES>();
            let shares: Vec<_> = shares.into_iter().collect();
            whole.par_iter().zip(shares).for_each(|(from, to)| wgpu::WriteOnly::from(to).copy_from_slice(from));
            rest.copy_from_slice(last);
        })
    }

    /// A buffer of this size in bytes, a multiple of four, which `write` writes to where the GPU fetches them from.
    pub(super) fn written_buffer(
        &self,
        label: &str,
        usage: wgpu::BufferUsages,
        bytes: usize,
        write: impl FnOnce(wgpu::WriteOnly<'_, [u8]>),
    ) -> wgpu::Buffer {
        let buffer = self.empty_buffer(label, usage | wgpu::BufferUsages::COPY_DST, bytes);
        // Without memory to write to, there is an error to be reported.
        let size = wgpu::BufferSize::new(bytes as u64);
        if let Some(mut memory) = size.and_then(|size| self.queue.write_buffer_with(&buffer, 0, size)) {
            self.count_upload(bytes);
            write(memory.slice(..));
        }
        buffer
    }
}

#[expect(clippy::disallowed_methods, reason = "the driver's start; a second signal ends the program")]
fn adapters(backends: Backends) -> Vec<Adapter> {
    if backends.is_empty() {
        return Vec::new();
    }
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    pollster::block_on(instance.enumerate_adapters(backends))
}

fn open_first(adapters: Vec<Adapter>, failure: &mut Option<RenderError>) -> Option<Device> {
    adapters.into_iter().find_map(|adapter| match Device::request(&adapter) {
        Ok(device) => Some(device),
        Err(error) => {
            log::debug!("{error}");
            failure.get_or_insert(error);
            None
        }
    })
}

/// The kind of an adapter's hardware. GL does not report what it runs on; wgpu then recognises llvmpipe and its like by
/// their names.
fn kind(adapter: &Adapter) -> DeviceType {
    let info = adapter.get_info();
    if info.device_type != DeviceType::Other {
        return info.device_type;
    }
    let name = info.name.to_lowercase();
    let is_software = ["pipe", "software", "swrast", "swr"].iter().any(|software| name.contains(software));
    if info.backend != Backend::Gl || is_software {
        DeviceType::Cpu
    } else {
        DeviceType::Other
    }
}

fn rank(adapter: &Adapter) -> u8 {
    match adapter.get_info().device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}
