//! The settings of compressed images, with the names, defaults and bounds that image_transport's plugin `compressed`
//! has for dynamic_reconfigure: `format`, `jpeg_quality`, `png_level`.
//!
//! As there, values that the parameter server holds at the start are taken over, so that a launch file can set them.
//! Values out of bounds become the nearest ones.

use rcs_files::picture_file::Coding;
use rcs_messages::dynamic_reconfigure::{
    Config as Values, ConfigDescription, Group, GroupState, IntParameter, StrParameter,
};
use rcs_scene::Encoding;

use crate::outputs::parameter_description::{choice_of, parameter};

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
        let number = |name: &str| {
            let text = parameter(name)?;
            match text.parse() {
                Ok(value) => Some(IntParameter { name: name.to_owned(), value }),
                Err(_) => {
                    log::warn!("{name}: \"{text}\" is no whole number; the default is used");
                    None
                }
            }
        };
        let format = parameter(FORMAT).map(|value| StrParameter { name: FORMAT.to_owned(), value });
        let mut settings = Self::default();
        settings.set(&Values {
            ints: [QUALITY, LEVEL].into_iter().filter_map(number).collect(),
            strs: format.into_iter().collect(),
            ..Values::default()
        });
        settings
    }

    pub(super) fn set(&mut self, request: &Values) {
        for StrParameter { name, value } in request.strs.iter().filter(|param| param.name == FORMAT) {
            match value.as_str() {
                JPEG => self.is_png = false,
                PNG => self.is_png = true,
                _ => log::warn!("{name}: compressed pictures are {JPEG} or {PNG}, not \"{value}\""),
            }
        }
        for IntParameter { name, value } in &request.ints {
            match name.as_str() {
                QUALITY => self.jpeg_quality = (*value).clamp(1, 100) as u8,
                LEVEL => self.png_level = (*value).clamp(1, 9) as u8,
                _ => {}
            }
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

    pub(super) fn values(&self) -> Values {
        let int = |name: &str, value: u8| IntParameter { name: name.to_owned(), value: value.into() };
        let format = if self.is_png { PNG } else { JPEG };
        Values {
            ints: vec![int(QUALITY, self.jpeg_quality), int(LEVEL, self.png_level)],
            strs: vec![StrParameter { name: FORMAT.to_owned(), value: format.to_owned() }],
            groups: vec![GroupState { name: "Default".to_owned(), state: true, ..GroupState::default() }],
            ..Values::default()
        }
    }

    /// The parameters with their bounds.
    pub(super) fn description() -> ConfigDescription {
        let parameters = vec![
            parameter(FORMAT, "str", "Compression format", choice_of("Compression format", [JPEG, PNG])),
            parameter(QUALITY, "int", "JPEG quality percentile", String::new()),
            parameter(LEVEL, "int", "PNG compression level", String::new()),
        ];
        let bound = |jpeg_quality, png_level| {
            let mut values = Self { jpeg_quality, png_level, ..Self::default() }.values();
            values.strs.iter_mut().for_each(|param| param.value.clear());
            values
        };
        ConfigDescription {
            groups: vec![Group { name: "Default".to_owned(), parameters, ..Group::default() }],
            max: bound(100, 9),
            min: bound(1, 1),
            dflt: Self::default().values(),
        }
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
