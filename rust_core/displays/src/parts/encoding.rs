//! Pixel formats of the names of `sensor_msgs/image_encodings.h`.

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PixelFormat {
    pub(crate) bits: u32,
    pub(crate) channels: u32,
}

impl PixelFormat {
    /// Format of an encoding; `None` for an unknown one.
    pub(crate) fn of(encoding: &str) -> Option<Self> {
        let pixel = |bits, channels| Some(Self { bits, channels });
        match encoding {
            "mono8" => pixel(8, 1),
            "mono16" => pixel(16, 1),
            "rgb8" | "bgr8" => pixel(8, 3),
            "rgba8" | "bgra8" => pixel(8, 4),
            "rgb16" | "bgr16" => pixel(16, 3),
            "rgba16" | "bgra16" => pixel(16, 4),
            "yuv422" | "yuv422_yuy2" => pixel(8, 2),
            bayer if bayer.starts_with("bayer_") => match bayer.get(10..)? {
                "8" => pixel(8, 1),
                "16" => pixel(16, 1),
                _ => None,
            },
            opencv => Self::of_opencv(opencv),
        }
    }

    /// Names such as `32FC1` and `8UC`, which has one channel.
    fn of_opencv(name: &str) -> Option<Self> {
        let (depth, channels) = name.split_once('C')?;
        let bits = match depth {
            "8U" | "8S" => 8,
            "16U" | "16S" => 16,
            "32S" | "32F" => 32,
            "64F" => 64,
            _ => return None,
        };
        let channels = if channels.is_empty() { 1 } else { channels.parse().ok()? };
        (1..=512).contains(&channels).then_some(Self { bits, channels })
    }

    pub(crate) fn bytes(self) -> usize {
        (self.bits / 8 * self.channels) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_are_known_by_their_names() {
        let of = |name| PixelFormat::of(name).map(|pixel| (pixel.bits, pixel.channels, pixel.bytes()));
        assert_eq!(of("16UC1"), Some((16, 1, 2)));
        assert_eq!(of("32FC1"), Some((32, 1, 4)));
        assert_eq!(of("8UC3"), Some((8, 3, 3)));
        assert_eq!(of("64FC"), Some((64, 1, 8)));
        assert_eq!(of("bgra16"), Some((16, 4, 8)));
        assert_eq!(of("bayer_grbg16"), Some((16, 1, 2)));
        for unknown in ["", "depth", "bayer_", "8UC-1", "12UC1", "8UC0", "8UC4000000000"] {
            assert_eq!(of(unknown), None, "{unknown}");
        }
    }
}
