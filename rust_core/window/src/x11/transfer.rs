//! Sends pixels to a window: in memory shared with the server, or else through the connection.

use std::os::fd::AsFd;
use std::sync::Arc;

use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::shm::{self, CompletionEvent, ConnectionExt as _, Seg};
use x11rb::protocol::xproto::{ConnectionExt as _, Gcontext, ImageFormat, ImageOrder, Window};

use super::pixel_format::PixelFormat;
use super::session::X11Session;
use crate::error::WindowError;
use crate::on_screen::OnScreen;
use crate::shared_pixels::{SharedPixels, PIXEL_BYTES};

/// The version of MIT-SHM that takes a descriptor.
const SHM_WITH_DESCRIPTORS: (u16, u16) = (1, 2);
/// Bytes of a PutImage request without its pixels.
const PUT_IMAGE_BYTES: usize = 64;

/// Sends pixels to one window.
pub(super) struct Transfer {
    window: Window,
    context: Gcontext,
    format: PixelFormat,
    /// Scratch buffer for pixels in the screen's format, if that is not the format of drawn pixels.
    converted: Vec<u32>,
    can_share: bool,
    shared: Option<SharedSegment>,
}

struct SharedSegment {
    segment: Seg,
    pixels: SharedPixels,
    /// The listeners of the images that the server reads, with their slots.
    listeners: Vec<(usize, Arc<dyn OnScreen>)>,
}

impl Transfer {
    /// A transfer to a window of this session's screen.
    ///
    /// # Errors
    /// The server does not accept pixels of 32 bits in this machine's byte order with fixed colours, or the connection
    /// broke.
    pub(super) fn new(session: &X11Session, window: Window) -> Result<Self, WindowError> {
        let setup = session.connection.setup();
        let depth = session.screen.root_depth;
        let storage = setup.pixmap_formats.iter().find(|format| format.depth == depth);
        let own_order = if cfg!(target_endian = "big") { ImageOrder::MSB_FIRST } else { ImageOrder::LSB_FIRST };
        let is_known = storage.is_some_and(|format| u32::from(format.bits_per_pixel) == 8 * PIXEL_BYTES);
        if !is_known || depth < 24 || setup.image_byte_order != own_order {
            let reason = format!("the X server's screen has depth {depth}; use one of depth 24 or 30");
            return Err(WindowError::NoDisplay(reason));
        }
        let format = PixelFormat::of(&session.screen)?;
        let context = session.connection.generate_id().map_err(X11Session::lost)?;
        session.connection.create_gc(context, window, &Default::default()).map_err(X11Session::lost)?;
        Ok(Self { window, context, format, converted: Vec::new(), can_share: takes_descriptors(session), shared: None })
    }

    /// `true` if an image can be sent now; otherwise an event follows when the server has read one.
    pub(super) fn is_ready(&self) -> bool {
        self.shared.as_ref().is_none_or(|shared| shared.pixels.free_slot().is_some())
    }

    /// Sends pixels of the window's size, `0x00RRGGBB`. `on_screen` hears when the server has read them.
    ///
    /// # Errors
    /// The connection broke.
    pub(super) fn send(
        &mut self,
        session: &X11Session,
        pixels: &[u32],
        size_px: (u32, u32),
        mut on_screen: Option<Arc<dyn OnScreen>>,
    ) -> Result<(), WindowError> {
        if self.can_share && self.shared.as_ref().is_none_or(|shared| shared.pixels.size_px() != size_px) {
            self.share(session, size_px);
        }
        let mut converted = std::mem::take(&mut self.converted);
        let pixels = if self.format.is_drawn() {
            pixels
        } else {
            converted.clear();
            converted.extend(pixels.iter().map(|pixel| self.format.pixel(*pixel)));
            &converted
        };
        let is_sent = match &mut self.shared {
            Some(shared) => shared.send(session, self.window, self.context, pixels, &mut on_screen)?,
            None => false,
        };
        if !is_sent {
            self.put(session, pixels, size_px)?;
        }
        self.converted = converted;
        session.connection.flush().map_err(X11Session::lost)?;
        // Without shared memory the server does not report it.
        on_screen.iter().for_each(|listener| listener.shown());
        Ok(())
    }

    /// Records that the server has read an image.
    pub(super) fn complete(&mut self, event: &CompletionEvent) {
        let Some(shared) = self.shared.as_mut().filter(|shared| shared.segment == event.shmseg) else { return };
        let slot = u64::from(event.offset).checked_div(shared.pixels.slot_bytes()).unwrap_or(0);
        let slot = usize::try_from(slot).unwrap_or(0);
        shared.pixels.end_reading(shared.pixels.shared_slot(slot));
        shared.listeners.extract_if(.., |(of, _)| *of == slot).for_each(|(_, listener)| listener.shown());
    }

    /// Shares memory for images of this size with the server, or disables sharing.
    fn share(&mut self, session: &X11Session, size_px: (u32, u32)) {
        if let Some(old) = self.shared.take() {
            // On failure it is freed with the connection.
            let _ = session.connection.shm_detach(old.segment);
        }
        self.shared = SharedSegment::with(session, size_px);
        self.can_share = self.shared.is_some();
        if !self.can_share {
            log::info!("the X server does not share memory; pictures are sent through the connection, which is slower");
        }
    }

    /// Sends pixels through the connection, in bands that fit a request.
    fn put(&self, session: &X11Session, pixels: &[u32], (width, height): (u32, u32)) -> Result<(), WindowError> {
        let row_bytes = width as usize * PIXEL_BYTES as usize;
        let most_bytes = session.connection.maximum_request_bytes().saturating_sub(PUT_IMAGE_BYTES);
        let most_rows = (most_bytes / row_bytes.max(1)).max(1);
        let side = |pixels: usize| u16::try_from(pixels).unwrap_or(u16::MAX);
        for (band, rows) in pixels.chunks(most_rows * width as usize).enumerate() {
            let first = band * most_rows;
            let count = (rows.len() / (width as usize).max(1)).min(height as usize - first.min(height as usize));
            session
                .connection
                .put_image(
                    ImageFormat::Z_PIXMAP,
                    self.window,
                    self.context,
                    side(width as usize),
                    side(count),
                    0,
                    i16::try_from(first).unwrap_or(i16::MAX),
                    0,
                    session.screen.root_depth,
                    bytemuck::cast_slice(rows),
                )
                .map_err(X11Session::lost)?;
        }
        Ok(())
    }
}

impl SharedSegment {
    /// Memory for images of this size; `None` if the server rejects it.
    fn with(session: &X11Session, size_px: (u32, u32)) -> Option<Self> {
        let pixels = SharedPixels::new(size_px).ok()?;
        let segment = session.connection.generate_id().ok()?;
        let descriptor = pixels.fd().as_fd().try_clone_to_owned().ok()?;
        session.connection.shm_attach_fd(segment, descriptor, true).ok()?.check().ok()?;
        Some(Self { segment, pixels, listeners: Vec::new() })
    }

    /// Sends an image, and takes its listener; `false` if the memory cannot be written.
    fn send(
        &mut self,
        session: &X11Session,
        window: Window,
        context: Gcontext,
        pixels: &[u32],
        on_screen: &mut Option<Arc<dyn OnScreen>>,
    ) -> Result<bool, WindowError> {
        let Some(slot) = self.pixels.free_slot() else { return Ok(false) };
        let (Ok(()), Ok(offset)) = (self.pixels.write(slot, pixels), u32::try_from(self.pixels.offset(slot))) else {
            return Ok(false);
        };
        let side = |pixels: u32| u16::try_from(pixels).unwrap_or(u16::MAX);
        let (width, height) = (side(self.pixels.size_px().0), side(self.pixels.size_px().1));
        let (depth, format) = (session.screen.root_depth, ImageFormat::Z_PIXMAP.into());
        let put = session.connection.shm_put_image(
            window,
            context,
            width,
            height,
            0,
            0,
            width,
            height,
            0,
            0,
            depth,
            format,
            true,
            self.segment,
            offset,
        );
        put.map_err(X11Session::lost)?;
        self.pixels.begin_reading(slot);
        self.listeners.extend(on_screen.take().map(|listener| (slot, listener)));
        Ok(true)
    }
}

/// `true` if the server supports shared memory by descriptors.
fn takes_descriptors(session: &X11Session) -> bool {
    let version = || {
        session.connection.extension_information(shm::X11_EXTENSION_NAME).ok()??;
        let version = session.connection.shm_query_version().ok()?.reply().ok()?;
        Some((version.major_version, version.minor_version))
    };
    version().is_some_and(|version| version >= SHM_WITH_DESCRIPTORS)
}
