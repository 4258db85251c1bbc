//! From a depth image, a colour image and a CameraInfo to the points of a cloud in the camera's optical frame.
//!
//! A pixel's point lies on the ray of the CameraInfo's P, at the depth along z. With occlusion compensation each pixel
//! also remembers the last occluded point, in half its brightness: its shadow.

use nalgebra::Isometry3;
use rcs_messages::sensor_msgs::{CameraInfo, PointField};
use rcs_messages::{Image, PointCloud2};
use rcs_transforms::Time;

use crate::framework::world::all_finite;
use crate::parts::cloud::one_row;
use crate::parts::encoding::PixelFormat;

/// Bytes of a point: x, y, z and the colour.
const POINT_LEN: usize = 16;

/// Distance by which a point must be nearer than the one before it to leave a shadow.
const SHADOW_DISTANCE_M: f32 = 0.01;

/// Motion of a camera after which its shadows are forgotten.
const MOVED_M: f64 = 0.01;

/// Like [`MOVED_M`], for rotation.
const TURNED_DEG: f64 = 0.5;

/// White, where there is no colour image.
const WHITE: u32 = 0x00ff_ffff;

/// Occluded points of a camera, by pixel.
#[derive(Debug, Default)]
pub(super) struct Shadows {
    size_px: [u32; 2],
    pixels: Vec<Option<Shadow>>,
    fixed_from_camera: Option<Isometry3<f64>>,
}

#[derive(Clone, Copy, Debug)]
struct Shadow {
    point: [f32; 3],
    color: u32,
    seen: Time,
}

impl Shadows {
    pub(super) fn clear(&mut self) {
        self.pixels.clear();
    }

    /// Removes all shadows when the camera has moved.
    pub(super) fn follow(&mut self, fixed_from_camera: &Isometry3<f64>) {
        if self.fixed_from_camera.is_none_or(|before| has_moved(&before, fixed_from_camera)) {
            self.fixed_from_camera = Some(*fixed_from_camera);
            self.clear();
        }
    }

    fn fit(&mut self, size_px: [u32; 2], count: usize) {
        if self.size_px != size_px || self.pixels.len() != count {
            self.size_px = size_px;
            self.pixels.clear();
            self.pixels.resize(count, None);
        }
    }
}

fn has_moved(before: &Isometry3<f64>, now: &Isometry3<f64>) -> bool {
    (now.translation.vector - before.translation.vector).norm() > MOVED_M
        || before.rotation.angle_to(&now.rotation).to_degrees() > TURNED_DEG
}

/// Lifetime of shadows, and the time now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Occlusion {
    pub(super) now: Time,
    pub(super) timeout_secs: f32,
}

/// The cloud of a depth image.
pub(super) fn cloud(
    depth: &Image,
    color: Option<&Image>,
    info: &CameraInfo,
    shadows: Option<(&mut Shadows, Occlusion)>,
) -> Result<PointCloud2, String> {
    let rays = Rays::of(depth, info)?;
    let pixel = PixelFormat::of(&depth.encoding).ok_or_else(|| format!("Unknown encoding {}", depth.encoding))?;
    let depth_m: fn(&[u8], bool) -> Option<f32> = match pixel {
        PixelFormat { bits: 32, channels: 1 } => float_depth,
        PixelFormat { bits: 16, channels: 1 } => millimetre_depth,
        _ => return Err("Depth image has invalid format (only 16 bit and float are supported)!".to_owned()),
    };
    let rows = rows(depth, pixel, "Depth")?;
    let colors = color.map(|color| colors(color, depth)).transpose()?.unwrap_or_default();
    let count = rays.x.len() * rays.y.len();
    let mut points = PointWriter(Vec::with_capacity(count * POINT_LEN));
    let is_big_endian = depth.is_bigendian != 0;
    let pixels = rows.zip(&rays.y).flat_map(|(row, y)| {
        let depths = row.chunks_exact(pixel.bytes()).map(|bytes| depth_m(bytes, is_big_endian));
        depths.zip(&rays.x).map(move |(depth_m, x)| depth_m.map(|z| [x * z, y * z, z]))
    });
    let color = |index: usize| colors.get(index).copied().unwrap_or(WHITE);
    match shadows {
        None => {
            for (index, point) in pixels.enumerate() {
                if let Some(point) = point {
                    points.push(point, color(index));
                }
            }
        }
        Some((shadows, Occlusion { now, timeout_secs })) => {
            shadows.fit([depth.width, depth.height], count);
            for ((index, point), shadow) in pixels.enumerate().zip(&mut shadows.pixels) {
                if shadow.is_some_and(|shadow| now.secs_since(shadow.seen) > f64::from(timeout_secs)) {
                    *shadow = None;
                }
                if let Some(point) = point {
                    points.push(point, color(index));
                }
                match (point, &shadow) {
                    (Some(point), Some(hidden)) if point[2] < hidden.point[2] - SHADOW_DISTANCE_M => {
                        points.push(hidden.point, hidden.color);
                    }
                    (Some(point), _) => {
                        let darker = (color(index) >> 1) & 0x007f_7f7f;
                        *shadow = Some(Shadow { point, color: darker, seen: now });
                    }
                    (None, Some(hidden)) => points.push(hidden.point, hidden.color),
                    (None, None) => {}
                }
            }
        }
    }
    let fields = [("x", 0), ("y", 4), ("z", 8), ("rgb", 12)].map(|(name, at)| (name, at, PointField::FLOAT32));
    Ok(one_row(&depth.header, &fields, POINT_LEN as u32, points.0))
}

struct PointWriter(Vec<u8>);

impl PointWriter {
    fn push(&mut self, point: [f32; 3], color: u32) {
        let words = [point[0].to_bits(), point[1].to_bits(), point[2].to_bits(), color];
        self.0.extend(words.into_iter().flat_map(u32::to_le_bytes));
    }
}

/// Rays of the pixels of a column and of a row: x and y for each metre of z.
struct Rays {
    x: Vec<f32>,
    y: Vec<f32>,
}

impl Rays {
    fn of(depth: &Image, info: &CameraInfo) -> Result<Self, String> {
        let (bin_x, bin_y) = (info.binning_x.max(1), info.binning_y.max(1));
        let whole = |roi: u32, all: u32| if roi > 0 { roi } else { all };
        let roi_width = whole(info.roi.width, info.width);
        let roi_height = whole(info.roi.height, info.height);
        let (width, height) = (roi_width / bin_x, roi_height / bin_y);
        if (width, height) != (depth.width, depth.height) {
            return Err(format!(
                "Depth image size and camera info don't match: {} x {} vs {width} x {height}\
                 (binning: {bin_x} x {bin_y}, ROI size: {roi_width} x {roi_height})",
                depth.width, depth.height
            ));
        }
        let [fx, _, cx, _, _, fy, cy, ..] = info.P;
        if fx == 0.0 || fy == 0.0 || !all_finite(&[fx, fy, cx, cy]) {
            return Err(format!("no pixel has a ray by the CameraInfo's P, with fx {fx}, fy {fy}, cx {cx}, cy {cy}"));
        }
        // No memory for rows that the data do not have.
        let count = |side: u32| (side as usize).min(depth.data().len());
        let rays = |count: usize, center: f64, offset: u32, focal: f64, binning: u32| {
            let scale = 1.0 / f64::from(binning);
            let center = ((center - f64::from(offset)) * scale) as f32;
            let per_pixel = (1.0 / (focal * scale)) as f32;
            (0..count).map(|i| (i as f32 - center) * per_pixel).collect()
        };
        Ok(Self {
            x: rays(count(width), cx, info.roi.x_offset, fx, bin_x),
            y: rays(count(height), cy, info.roi.y_offset, fy, bin_y),
        })
    }
}

/// Rows of an image without their padding.
fn rows<'a>(image: &'a Image, pixel: PixelFormat, name: &str) -> Result<impl Iterator<Item = &'a [u8]>, String> {
    let row_len = image.width as usize * pixel.bytes();
    let step = (image.step as usize).max(row_len);
    let (height, actual) = (image.height as usize, image.data().len());
    let needed = step.checked_mul(height.saturating_sub(1)).and_then(|len| len.checked_add(row_len));
    if height > 0 && needed.is_none_or(|needed| needed > actual) {
        return Err(format!(
            "{name} image has {actual} bytes, too few for {} x {} pixels of {}",
            image.width, image.height, image.encoding
        ));
    }
    Ok(image.data().chunks(step.max(1)).take(height).map(move |row| row.get(..row_len).unwrap_or_default()))
}

fn float_depth(bytes: &[u8], is_big_endian: bool) -> Option<f32> {
    let bytes = bytes.try_into().ok()?;
    let depth_m = if is_big_endian { f32::from_be_bytes(bytes) } else { f32::from_le_bytes(bytes) };
    depth_m.is_finite().then_some(depth_m)
}

fn millimetre_depth(bytes: &[u8], is_big_endian: bool) -> Option<f32> {
    let bytes = bytes.try_into().ok()?;
    let depth_mm = if is_big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) };
    (depth_mm != 0).then(|| f32::from(depth_mm) * 0.001)
}

/// Packed colours of an image's pixels; empty where rviz finds none in the encoding.
fn colors(color: &Image, depth: &Image) -> Result<Vec<u32>, String> {
    if (color.width, color.height) != (depth.width, depth.height) {
        return Err(format!(
            "Depth image resolution ({}x{}) does not match color image resolution ({}x{})",
            depth.width, depth.height, color.width, color.height
        ));
    }
    let pixel = PixelFormat::of(&color.encoding).ok_or_else(|| format!("Unknown encoding {}", color.encoding))?;
    let is_wide = match pixel.bits {
        8 => false,
        16 => true,
        _ => return Err("Color image has invalid bit depth".to_owned()),
    };
    // Of two bytes the more significant one counts.
    let channel_len = if is_wide { 2 } else { 1 };
    let high = usize::from(is_wide && color.is_bigendian == 0);
    let places = match (pixel.channels, color.encoding.contains("rgb")) {
        (1, _) => [0, 0, 0],
        (3 | 4, true) => [0, 1, 2],
        (3 | 4, false) => [2, 1, 0],
        _ => return Ok(Vec::new()),
    };
    let pack = |bytes: &[u8]| {
        let [r, g, b] = places.map(|place| bytes.get(place * channel_len + high).copied().unwrap_or_default());
        u32::from_be_bytes([0, r, g, b])
    };
    Ok(rows(color, pixel, "Color")?.flat_map(|row| row.chunks_exact(pixel.bytes()).map(pack)).collect())
}
