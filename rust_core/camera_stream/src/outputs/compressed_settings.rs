//! The settings of compressed images, with the names, defaults and bounds that image_transport's plugin `compressed`
//! has for dynamic_reconfigure: `format`, `jpeg_quality`, `png_level`.
//!
//! As there, values that the parameter server holds at the start are taken over, so that a launch file can set them.
//! Values out of bounds become the nearest ones.

use rcs_files::image_file::Coding;
use rcs_ros::settings::{settings, Setting, SettingGroup};
use rcs_ros::ParameterValue;
use rcs_scene::Encoding;

const FORMAT: &str = "format";
const QUALITY: &str = "jpeg_quality";
const LEVEL: &str = "png_level";
pub(super) const NAMES: [&str; 3] = [FORMAT, QUALITY, LEVEL];

const JPEG: &str = "jpeg";
const PNG: &str = "png";

/// Format and quality of compressed images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CompressionSettings {
    is_png: bool,
    /// 1 to 100.
    jpeg_quality: u8,
    /// 1 to 9.
    png_level: u8,
}

impl Default for CompressionSettings {
    fn default() -> Self {
        Self { is_png: false, jpeg_quality: 80, png_level: 9 }
    }
}

impl CompressionSettings {
    /// The defaults, with the values that `parameter` has for each name.
    pub(super) fn start(parameter: impl Fn(&str) -> Option<String>) -> Self {
        let mut own = Self::default();
        for setting in settings(&Self::default().groups()) {
            let Some(text) = parameter(&setting.name) else { continue };
            let value = match setting.value {
                ParameterValue::Int(_) => text.parse().ok().map(ParameterValue::Int),
                _ => Some(text.as_str().into()),
            };
            match value.and_then(|value| setting.accept(value)) {
                Some(value) => own.take(&setting.name, &value),
                None => log::warn!("{}: \"{text}\" is no whole number; the default is used", setting.name),
            }
        }
        own
    }

    /// Takes a value that the table below has accepted.
    pub(super) fn take(&mut self, name: &str, value: &ParameterValue) {
        match (name, value) {
            (FORMAT, ParameterValue::String(format)) => match format.as_str() {
                JPEG => self.is_png = false,
                PNG => self.is_png = true,
                _ => log::warn!("{name}: compressed pictures are {JPEG} or {PNG}, not \"{format}\""),
            },
            (QUALITY, ParameterValue::Int(quality)) => self.jpeg_quality = *quality as u8,
            (LEVEL, ParameterValue::Int(level)) => self.png_level = *level as u8,
            _ => {}
        }
    }

    pub(super) fn coding(&self) -> Coding {
        match self.is_png {
            true => Coding::Png { level: self.png_level },
            false => Coding::Jpeg { quality: self.jpeg_quality },
        }
    }

    /// The message's `format`: the encoding of the image before, and of the data. The plugin's colours are bgr8, in
    /// which order OpenCV reads any file; a JPEG file has no 16 bits.
    pub(super) fn format(&self, encoding: Encoding) -> String {
        let (encoding, order) = match encoding {
            Encoding::Mono16 if !self.is_png => (Encoding::Mono8, ""),
            Encoding::Mono8 | Encoding::Mono16 => (encoding, ""),
            // Alpha is dropped: there is none in JPEG, and every pixel is opaque.
            Encoding::Rgba8 => (Encoding::Rgb8, "bgr8"),
            Encoding::Bgra8 => (Encoding::Bgr8, "bgr8"),
            Encoding::Rgb8 | Encoding::Bgr8 => (encoding, "bgr8"),
        };
        format!("{}; {} compressed {order}", encoding.name(), if self.is_png { PNG } else { JPEG })
    }

    /// The table of the settings.
    pub(super) fn groups(&self) -> Vec<SettingGroup> {
        let values = [*self, Self::default()];
        let formats = values.map(|of| if of.is_png { PNG } else { JPEG });
        let (qualities, levels) = (values.map(|of| of.jpeg_quality), values.map(|of| of.png_level));
        let settings = vec![
            Setting::choice(FORMAT, "Compression format", formats, vec![JPEG, PNG]).labelled("Format", ""),
            Setting::new(QUALITY, "JPEG quality percentile", qualities.map(i32::from), [1, 100])
                .labelled("JPEG quality", "%"),
            Setting::new(LEVEL, "PNG compression level", levels.map(i32::from), [1, 9]).labelled("PNG compression", ""),
        ];
        vec![("Default", settings)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_launch_files_parameters_are_taken_over_within_their_bounds() {
        let set = |values: &[(&'static str, &'static str)]| {
            let values = values.to_vec();
            let find = move |name: &str| Some(values.iter().find(|(known, _)| *known == name)?.1.to_owned());
            CompressionSettings::start(find).coding()
        };
        assert_eq!(set(&[]), Coding::Jpeg { quality: 80 });
        assert_eq!(set(&[(QUALITY, "95"), (LEVEL, "2")]), Coding::Jpeg { quality: 95 });
        assert_eq!(set(&[(FORMAT, "png")]), Coding::Png { level: 9 });
        assert_eq!(set(&[(FORMAT, "png"), (LEVEL, "0")]), Coding::Png { level: 1 });
        assert_eq!(set(&[(FORMAT, "gif"), (QUALITY, "1000")]), Coding::Jpeg { quality: 100 });
        assert_eq!(set(&[(QUALITY, "best")]), Coding::Jpeg { quality: 80 });
    }

    #[test]
    fn the_format_says_what_image_transports_plugin_says() {
        let jpeg = CompressionSettings::default();
        let png = CompressionSettings { is_png: true, ..jpeg };
        assert_eq!(jpeg.format(Encoding::Rgb8), "rgb8; jpeg compressed bgr8");
        assert_eq!(png.format(Encoding::Bgra8), "bgr8; png compressed bgr8");
        assert_eq!(jpeg.format(Encoding::Mono16), "mono8; jpeg compressed ");
        assert_eq!(png.format(Encoding::Mono16), "mono16; png compressed ");
    }
}
