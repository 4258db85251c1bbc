//! Depth images as in REP 118: `32FC1` in metres, NaN where nothing is, or `16UC1` in millimetres, 0 where nothing is.
//! Depth is along the optical axis.

use std::sync::Arc;

use rcs_messages::std_msgs::Header;
use rcs_messages::Image;
use rcs_render::Orientation;
use rcs_scene::{resize_block, DepthImage};

/// Encoding of a depth image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum DepthEncoding {
    /// 32-bit floating point numbers, metres
    #[default]
    #[value(name = "32FC1")]
    Metres,
    /// 16-bit whole numbers, millimetres
    #[value(name = "16UC1")]
    Millimetres,
}

/// An encoded depth image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct EncodedDepths {
    size_px: [u32; 2],
    encoding: DepthEncoding,
    bytes: Arc<Vec<u8>>,
}

impl EncodedDepths {
    /// Encodes depths, with the orientation of the image.
    pub(crate) fn new(depths: &DepthImage, encoding: DepthEncoding, orientation: Orientation) -> Self {
        let mut bytes = Vec::new();
        resize_block(&mut bytes, depths.depths_m.len() * encoding.bytes_per_pixel(), 0);
        match encoding {
            DepthEncoding::Metres => write_cells(depths, &mut bytes, f32::to_le_bytes),
            DepthEncoding::Millimetres => write_cells(depths, &mut bytes, |depth| millimetres(depth).to_le_bytes()),
        }
        let size_px = [depths.width_px, depths.height_px];
        if orientation != Orientation::default() {
            let mut turned = Vec::new();
            orientation.turn_cells(size_px, encoding.bytes_per_pixel(), &bytes, &mut turned);
            bytes = turned;
        }
        Self { size_px: orientation.size_px(size_px), encoding, bytes: Arc::new(bytes) }
    }

    /// The message. Its pixels are shared.
    pub(crate) fn message(&self, header: Header) -> Image {
        let name = match self.encoding {
            DepthEncoding::Metres => "32FC1",
            DepthEncoding::Millimetres => "16UC1",
        };
        let step = self.size_px[0] * self.encoding.bytes_per_pixel() as u32;
        Image::sharing(header, self.size_px, name, step, Arc::<Vec<u8>>::clone(&self.bytes))
    }
}

impl DepthEncoding {
    fn bytes_per_pixel(self) -> usize {
        match self {
            Self::Metres => 4,
            Self::Millimetres => 2,
        }
    }
}

/// Writes each depth as these bytes.
fn write_cells<const N: usize>(depths: &DepthImage, bytes: &mut [u8], cell: impl Fn(f32) -> [u8; N]) {
    for (to, depth) in bytes.as_chunks_mut::<N>().0.iter_mut().zip(&depths.depths_m) {
        *to = cell(*depth);
    }
}

/// 0 for NaN, and for depths above 65.5 m.
fn millimetres(depth_m: f32) -> u16 {
    let depth = (depth_m * 1000.0).round();
    if depth >= 1.0 && depth <= f32::from(u16::MAX) {
        depth as u16
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(encoding: &str, orientation: &str) -> Image {
        let depths = DepthImage { width_px: 3, height_px: 1, depths_m: vec![1.5, f32::NAN, 70.0] };
        let encoding = clap::ValueEnum::from_str(encoding, true).unwrap();
        EncodedDepths::new(&depths, encoding, orientation.parse().unwrap()).message(Header::default())
    }

    #[test]
    fn depths_are_metres_or_millimetres_and_what_is_nowhere_has_none() {
        let metres = image("32FC1", "0");
        assert_eq!((metres.encoding.as_str(), metres.step, metres.width, metres.height), ("32FC1", 12, 3, 1));
        let values: Vec<f32> = metres.data().as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        assert!(values[0] == 1.5 && values[1].is_nan() && values[2] == 70.0, "{values:?}");
        let millimetres = image("16UC1", "mirrored-90");
        assert_eq!(
            (millimetres.encoding.as_str(), millimetres.step, millimetres.width, millimetres.height),
            ("16UC1", 2, 1, 3)
        );
        let values: Vec<u16> =
            millimetres.data().as_chunks().0.iter().map(|bytes| u16::from_le_bytes(*bytes)).collect();
        assert_eq!(values, [0, 0, 1500], "70 m are more than 16 bits of millimetres");
    }
}
