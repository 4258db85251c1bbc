//! Double-buffered pixels in memory that the display server reads.
//!
//! The memory is an anonymous file (`memfd_create`), whose descriptor is sent to the server. The server maps it; this
//! side writes with `pwrite`, which needs no mapping and no `unsafe`.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicU64, Ordering};

use rustix::fs::{ftruncate, memfd_create, MemfdFlags};
use rustix::io::pwrite;

/// Bytes of a pixel, `0x00RRGGBB` in the machine's byte order.
pub(crate) const PIXEL_BYTES: u32 = 4;
/// Number of images.
const SLOTS: usize = 2;

/// An image in one memory. The server may release it after that memory was replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SharedSlot {
    memory: u64,
    slot: usize,
}

/// Memory for two images of one size.
#[derive(Debug)]
pub(crate) struct SharedPixels {
    /// Unique in this process.
    id: u64,
    file: OwnedFd,
    size_px: (u32, u32),
    is_read: [bool; SLOTS],
}

impl SharedPixels {
    /// Memory for images of this size.
    pub(crate) fn new(size_px: (u32, u32)) -> io::Result<Self> {
        static NEXT_ID: AtomicU64 = AtomicU64::new(0);
        let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
        let file = memfd_create("projector window", MemfdFlags::CLOEXEC)?;
        let pixels = Self { id, file, size_px, is_read: [false; SLOTS] };
        ftruncate(&pixels.file, pixels.slot_bytes() * SLOTS as u64)?;
        Ok(pixels)
    }

    /// The file's descriptor.
    pub(crate) fn fd(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }

    /// Width and height of an image, pixels.
    pub(crate) fn size_px(&self) -> (u32, u32) {
        self.size_px
    }

    /// Bytes of one image.
    pub(crate) fn slot_bytes(&self) -> u64 {
        u64::from(self.size_px.0) * u64::from(self.size_px.1) * u64::from(PIXEL_BYTES)
    }

    /// Offset of an image in the file, bytes.
    pub(crate) fn offset(&self, slot: usize) -> u64 {
        self.slot_bytes() * slot as u64
    }

    /// A slot that the server does not read.
    pub(crate) fn free_slot(&self) -> Option<usize> {
        self.is_read.iter().position(|is_read| !is_read)
    }

    /// The handle of a slot.
    pub(crate) fn shared_slot(&self, slot: usize) -> SharedSlot {
        SharedSlot { memory: self.id, slot }
    }

    /// Records that the server reads an image.
    pub(crate) fn begin_reading(&mut self, slot: usize) {
        self.set(slot, true);
    }

    /// Records that the server has released an image, unless it was in other memory.
    pub(crate) fn end_reading(&mut self, slot: SharedSlot) {
        if slot.memory == self.id {
            self.set(slot.slot, false);
        }
    }

    fn set(&mut self, slot: usize, is_read: bool) {
        if let Some(known) = self.is_read.get_mut(slot) {
            *known = is_read;
        }
    }

    /// Writes an image, `0x00RRGGBB` a pixel. Pixels beyond its size are left out.
    pub(crate) fn write(&self, slot: usize, pixels: &[u32]) -> io::Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(pixels);
        let size = usize::try_from(self.slot_bytes()).unwrap_or(usize::MAX);
        let mut rest = bytes.get(..size).unwrap_or(bytes);
        let mut offset = self.offset(slot);
        while !rest.is_empty() {
            let written = pwrite(&self.file, rest, offset)?;
            if written == 0 {
                return Err(io::ErrorKind::WriteZero.into());
            }
            offset += written as u64;
            rest = rest.get(written..).unwrap_or_default();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::io::pread;

    #[test]
    fn two_images_lie_one_after_the_other_and_are_written_in_turn() {
        let mut pixels = SharedPixels::new((2, 1)).unwrap();
        assert_eq!(pixels.free_slot(), Some(0));
        pixels.write(0, &[1, 2]).unwrap();
        pixels.begin_reading(0);
        assert_eq!(pixels.free_slot(), Some(1));
        pixels.write(1, &[3, 4, 5]).unwrap();
        pixels.begin_reading(1);
        assert_eq!(pixels.free_slot(), None);
        pixels.end_reading(pixels.shared_slot(0));
        assert_eq!(pixels.free_slot(), Some(0));
        let mut bytes = [0; 16];
        pread(pixels.fd(), &mut bytes, 0).unwrap();
        assert_eq!(bytemuck::cast_slice::<u8, u32>(&bytes), [1, 2, 3, 4]);
    }

    #[test]
    fn a_late_release_of_replaced_memory_frees_nothing() {
        let old = SharedPixels::new((2, 1)).unwrap();
        let late = old.shared_slot(0);
        drop(old);
        let mut pixels = SharedPixels::new((2, 1)).unwrap();
        pixels.begin_reading(0);
        pixels.end_reading(late);
        assert_eq!(pixels.free_slot(), Some(1));
        pixels.end_reading(pixels.shared_slot(0));
        assert_eq!(pixels.free_slot(), Some(0));
    }
}
