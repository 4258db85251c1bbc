//! Converts pixels of a graphics library to the bytes of a `sensor_msgs/Image`.

use rcs_camera::{metres_of_depth_buffer, write_depth_through, write_through, Readback, ReadbackProblem};
use rcs_scene::Encoding;

use crate::camera::{Current, RcsCamera};
use crate::fault::{Fault, RcsResult};
use crate::guard;
use crate::numbers::{EncodingNumber, Flag, PixelOrderNumber};
use crate::pointers::{self, required};

/// Order of the four bytes of a pixel in memory. The fourth is ignored.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RcsPixelOrder {
    /// Red, green, blue, alpha.
    Rgba = 0,
    /// Blue, green, red, alpha.
    Bgra,
}

/// A drawn image as it was read back, four bytes for each pixel. The caller owns it; it is not used after the call.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RcsPixels {
    /// The first pixel of the first row in memory.
    pub data: *const u8,
    /// Bytes from `data` on; bytes after the last row's last pixel are not read.
    pub length: usize,
    /// Pixels of a row: the view's `drawn_width`.
    pub width: u32,
    /// Rows: the view's `drawn_height`.
    pub height: u32,
    /// Bytes from the beginning of a row to the next one in memory, at least four for each pixel.
    pub row_bytes: usize,
    /// The order of a pixel's bytes.
    pub order: PixelOrderNumber,
    /// True if the first row in memory is the image's lowest one, as OpenGL reads back.
    pub bottom_up: Flag,
}

impl From<ReadbackProblem> for Fault {
    fn from(problem: ReadbackProblem) -> Self {
        Self::new(RcsResult::BadLength, format_args!("pixels: {problem}"))
    }
}

/// Writes a drawn image in an encoding of `sensor_msgs/Image` to `out`: rows from the top, without padding. With a
/// lens the image is bent, and pixels outside of the drawn image have the background's colour. A mirrored image
/// is flipped.
///
/// `pixels` has the view's drawn size; `out_length` is exactly the image's width · height ·
/// `rcs_encoding_bytes_per_pixel`, else `RCS_RESULT_BAD_LENGTH`. `background_rgb` points to three bytes. `out` must not
/// overlap `pixels` (`RCS_RESULT_BAD_VALUE`). `RCS_RESULT_NO_CAMERA_INFO` without a CameraInfo.
///
/// # Safety
/// What `pixels` points to is as `RcsPixels` says; three bytes are behind `background_rgb`, `out_length` behind `out`.
#[no_mangle]
pub unsafe extern "C" fn rcs_camera_encode(
    camera: Option<&mut RcsCamera>,
    pixels: Option<&RcsPixels>,
    encoding: EncodingNumber,
    background_rgb: *const u8,
    out: *mut u8,
    out_length: usize,
) -> RcsResult {
    guard::result(|| {
        let (camera, pixels) = (required(camera, "camera")?, required(pixels, "pixels")?);
        // SAFETY: as the caller promises.
        let background = unsafe { pointers::slice(background_rgb.cast::<[u8; 3]>(), 1, "background_rgb") }?;
        let encoding = encoding.checked()?;
        let current = camera.current.as_ref().ok_or_else(Fault::no_camera_info)?;
        // SAFETY: as the caller promises.
        let drawn = unsafe { readback(pixels, current) }?;
        require_length("out_length", out_length, bytes(current, encoding))?;
        pointers::apart((pixels.data, pixels.length), (out, out_length))?;
        // SAFETY: as the caller promises, and apart from what is read.
        let out = unsafe { pointers::slice_mut(out, out_length, "out") }?;
        match &current.lens {
            None => drawn.write(encoding, out),
            Some(lens) => {
                let source = &mut camera.before_lens;
                source.reset(pixels.width, pixels.height, Encoding::Rgba8);
                drawn.write(Encoding::Rgba8, &mut source.data);
                write_through(lens, source, background[0], encoding, out);
            }
        }
        current.flip.bytes(current.view.image_width, encoding.bytes_per_pixel(), out);
        Ok(())
    })
}

/// Writes a depth buffer as metres along the optical axis, as a `32FC1` image: rows from the top; NaN where nothing was
/// drawn, as on the node's depth topic. With a lens each pixel has the depth of the nearest drawn pixel. A mirrored
/// image is flipped.
///
/// `depth` has the view's drawn width · height values without padding, 0 at the view's `near_m` and 1 at its `far_m`,
/// with the lowest row first if `bottom_up`; `out_count` is the image's width · height. Other counts are
/// `RCS_RESULT_BAD_LENGTH`, buffers that overlap or are not aligned `RCS_RESULT_BAD_VALUE`.
///
/// # Safety
/// There are as many values behind `depth` and `out` as the counts say.
#[no_mangle]
pub unsafe extern "C" fn rcs_camera_encode_depth(
    camera: Option<&mut RcsCamera>,
    depth: *const f32,
    depth_count: usize,
    bottom_up: Flag,
    out: *mut f32,
    out_count: usize,
) -> RcsResult {
    guard::result(|| {
        let camera = required(camera, "camera")?;
        let current = camera.current.as_ref().ok_or_else(Fault::no_camera_info)?;
        let view = &current.view;
        require_length("depth_count", depth_count, pixels_of(view.drawn_width, view.drawn_height))?;
        require_length("out_count", out_count, pixels_of(view.image_width, view.image_height))?;
        pointers::apart((depth, depth_count), (out, out_count))?;
        // SAFETY: as the caller promises.
        let depth = unsafe { pointers::slice(depth, depth_count, "depth") }?;
        // SAFETY: as the caller promises, and apart from what is read.
        let out = unsafe { pointers::slice_mut(out, out_count, "out") }?;
        match &current.lens {
            None => write_metres(depth, current, bottom_up, out),
            Some(lens) => {
                let source = &mut camera.depth_before_lens;
                source.reset(view.drawn_width, view.drawn_height);
                write_metres(depth, current, bottom_up, &mut source.depths_m);
                write_depth_through(lens, source, out);
            }
        }
        current.flip.cells(view.image_width, out);
        Ok(())
    })
}

/// The drawn image behind the pointers.
///
/// # Safety
/// The pointers are as [`RcsPixels`] says.
unsafe fn readback<'a>(pixels: &RcsPixels, current: &Current) -> Result<Readback<'a>, Fault> {
    let (size_px, drawn) = ([pixels.width, pixels.height], [current.view.drawn_width, current.view.drawn_height]);
    if size_px != drawn {
        let ([width, height], [drawn_width, drawn_height]) = (size_px, drawn);
        let text = format!("pixels are {width}x{height}, where the view draws {drawn_width}x{drawn_height}");
        return Err(Fault::new(RcsResult::BadLength, text));
    }
    let order = pixels.order.checked()?;
    let needed = Readback::needed_bytes(size_px, pixels.row_bytes)?;
    // SAFETY: as the caller promises.
    let bytes = unsafe { pointers::slice(pixels.data, needed.min(pixels.length), "pixels.data") }?;
    Ok(Readback::new(bytes, size_px, pixels.row_bytes, order, pixels.bottom_up.is_set())?)
}

fn pixels_of(width: u32, height: u32) -> Option<usize> {
    (width as usize).checked_mul(height as usize)
}

/// Bytes of the published image.
fn bytes(current: &Current, encoding: Encoding) -> Option<usize> {
    let pixels = pixels_of(current.view.image_width, current.view.image_height)?;
    pixels.checked_mul(encoding.bytes_per_pixel())
}

fn require_length(name: &str, length: usize, needed: Option<usize>) -> Result<(), Fault> {
    match needed {
        Some(needed) if needed == length => Ok(()),
        Some(needed) => {
            Err(Fault::new(RcsResult::BadLength, format_args!("{name} is {length}, where {needed} is needed")))
        }
        None => Err(Fault::new(RcsResult::BadLength, "a picture of that size does not fit memory")),
    }
}

/// Writes the metres of a depth buffer from the top row on.
fn write_metres(depth: &[f32], current: &Current, bottom_up: Flag, to: &mut [f32]) {
    let view = &current.view;
    let width = (view.drawn_width as usize).max(1);
    let write = |(to, from): (&mut [f32], &[f32])| {
        for (to, from) in to.iter_mut().zip(from) {
            *to = metres_of_depth_buffer(*from, view.near_m, view.far_m);
        }
    };
    let rows = to.chunks_mut(width);
    match bottom_up.is_set() {
        true => rows.zip(depth.chunks(width).rev()).for_each(write),
        false => rows.zip(depth.chunks(width)).for_each(write),
    }
}
