//! Grey levels of what a monitor shows.

use x11rb::protocol::xproto::{ConnectionExt as _, ImageFormat};

use super::X11Session;
use crate::error::WindowError;
use crate::monitor::{MonitorChoice, MonitorInfo};

/// Bytes of a pixel.
const PIXEL_BYTES: usize = 4;

/// Reads what a monitor of an X server shows.
pub struct ScreenGrabber {
    session: X11Session,
    monitor: MonitorInfo,
}

impl ScreenGrabber {
    /// Opens a monitor by its name or number, or `auto` as [`MonitorChoice`] takes it.
    ///
    /// # Errors
    /// No X server, an unknown monitor.
    pub fn open(monitor: &str) -> Result<Self, WindowError> {
        let session = X11Session::open()?;
        let monitors = session.monitors();
        let Ok(choice) = monitor.parse::<MonitorChoice>();
        let monitor = monitors[choice.resolve(&monitors)?].clone();
        Ok(Self { session, monitor })
    }

    /// Green levels of the monitor's top left corner, row by row. Width and height in pixels.
    ///
    /// # Errors
    /// The monitor is smaller, the screen has other than 32 bits a pixel, or the X server is gone.
    pub fn grey(&self, [width, height]: [u32; 2]) -> Result<Vec<u8>, WindowError> {
        let refused = |reason: String| WindowError::Open { monitor: self.monitor.clone(), reason };
        if self.monitor.size_px.0 < width || self.monitor.size_px.1 < height {
            return Err(refused(format!("it is smaller than {width}x{height} pixels")));
        }
        let (x, y) = self.monitor.position_px;
        let edges = [x.try_into(), y.try_into()];
        let sides = [width.try_into(), height.try_into()];
        let ([Ok(x), Ok(y)], [Ok(width), Ok(height)]) = (edges, sides) else {
            return Err(refused("it lies outside the X screen".to_owned()));
        };
        let (format, root) = (ImageFormat::Z_PIXMAP, self.session.root());
        let request = self.session.connection.get_image(format, root, x, y, width, height, !0);
        let image = request.map_err(X11Session::lost)?.reply().map_err(X11Session::lost)?;
        if image.data.len() != usize::from(width) * usize::from(height) * PIXEL_BYTES {
            return Err(refused("the X screen has other than 32 bits a pixel".to_owned()));
        }
        Ok(image.data.chunks_exact(PIXEL_BYTES).map(|pixel| pixel[1]).collect())
    }
}
