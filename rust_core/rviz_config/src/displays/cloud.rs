//! Displays that draw their messages as clouds of points: PointCloud2, PointCloud, LaserScan, and those of single
//! values (FluidPressure, Illuminance, RelativeHumidity, Temperature), which have other defaults. Points are drawn in
//! one of five styles and coloured in one of six ways.
//!
//! A cloud that does not fit the chosen colour transformer is coloured by another, so the settings of all of them are
//! read. The only position transformer of rviz is `XYZ`, which every cloud that can be drawn fits.

use rcs_scene::PointStyle;

use crate::section::{at_least, Section, ANY};

/// Default sizes: of points in pixels, of all other styles in metres.
const DEFAULT_SIZES: (f32, f32) = (3.0, 0.01);

/// The styles by their names in a config, in these sizes.
fn styles(diameter_px: f32, side_m: f32) -> [(&'static str, PointStyle); 5] {
    [
        ("Points", PointStyle::Points { diameter_px }),
        ("Squares", PointStyle::Squares { size_m: [side_m; 2] }),
        ("Flat Squares", PointStyle::FlatSquares { side_m }),
        ("Spheres", PointStyle::Spheres { size_m: [side_m; 2] }),
        ("Boxes", PointStyle::Boxes { size_m: [side_m; 3] }),
    ]
}

/// Source of a point's colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColorTransformer {
    /// A channel's value, by [`IntensitySettings`].
    Intensity,
    /// The field `rgb` or `rgba`.
    Rgb8,
    /// The grey of the field `rgb` or `rgba`.
    Mono8,
    /// The float fields `r`, `g` and `b`, each 0 to 1.
    Rgbf32,
    /// One colour, [`CloudSettings::flat_color`].
    FlatColor,
    /// The position along an axis, by [`AxisColorSettings`].
    AxisColor,
}

const COLOR_TRANSFORMERS: [(&str, ColorTransformer); 6] = [
    ("Intensity", ColorTransformer::Intensity),
    ("RGB8", ColorTransformer::Rgb8),
    ("MONO8", ColorTransformer::Mono8),
    ("RGBF32", ColorTransformer::Rgbf32),
    ("FlatColor", ColorTransformer::FlatColor),
    ("AxisColor", ColorTransformer::AxisColor),
];

impl ColorTransformer {
    /// The name in a config.
    pub fn name(self) -> &'static str {
        COLOR_TRANSFORMERS.iter().find(|(_, transformer)| *transformer == self).map_or("", |(name, _)| name)
    }
}

const POSITION_TRANSFORMERS: [(&str, ()); 1] = [("XYZ", ())];

/// An axis of the cloud's or the fixed frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Forwards, by ROS's convention.
    X,
    /// To the left, by ROS's convention.
    Y,
    /// Upwards, by ROS's convention.
    Z,
}

const AXES: [(&str, Axis); 3] = [("X", Axis::X), ("Y", Axis::Y), ("Z", Axis::Z)];

properties! {
    /// The settings of [`ColorTransformer::Intensity`].
    pub struct IntensitySettings {
        /// The field that holds the value. For `intensity` a cloud may have `intensities` instead.
        channel_name: String = "intensity".to_owned() => text("Channel Name");
        /// `true` for the colours of the rainbow, else from `min_color` to `max_color`.
        use_rainbow: bool = true => bool("Use rainbow");
        /// `true` if the rainbow is reversed.
        invert_rainbow: bool = false => bool("Invert Rainbow");
        /// Colour of the smallest value, as red, green and blue.
        min_color: [u8; 3] = [0, 0, 0] => color("Min Color");
        /// Colour of the largest value, as red, green and blue.
        max_color: [u8; 3] = [255, 255, 255] => color("Max Color");
        /// `true` for the bounds of each cloud, else `min` and `max`.
        auto_bounds: bool = true => bool("Autocompute Intensity Bounds");
        /// Smallest value.
        min: f32 = 0.0 => float("Min Intensity", ANY);
        /// Largest value.
        max: f32 = 4096.0 => float("Max Intensity", ANY);
    }
}

properties! {
    /// The settings of [`ColorTransformer::AxisColor`].
    pub struct AxisColorSettings {
        /// The axis along which colours run through the rainbow.
        axis: Axis = Axis::Z => choice("Axis", &AXES);
        /// `true` for positions in the fixed frame, else in the cloud's own frame.
        use_fixed_frame: bool = true => bool("Use Fixed Frame");
    }
    inside "Autocompute Value Bounds" {
        /// `true` for the bounds of each cloud, else `min` and `max`.
        auto_bounds: bool = true => bool("Value");
        /// Smallest position in metres.
        min: f32 = -10.0 => float("Min Value", ANY);
        /// Largest position in metres.
        max: f32 = 10.0 => float("Max Value", ANY);
    }
}

properties! {
    /// The properties of a display of clouds. Topic and queue size are not read with the others, because a DepthCloud
    /// has its own.
    pub struct CloudSettings {
        /// Topic of the class's messages; empty when none is chosen.
        topic: String = String::new();
        /// Most messages that wait for their transform.
        queue_size: u32 = 10;
        /// Style and size of a point: at least 1 pixel for [`PointStyle::Points`], at least 0.0001 m for all other
        /// styles. Never [`PointStyle::Tiles`].
        style: PointStyle = PointStyle::FlatSquares { side_m: DEFAULT_SIZES.1 };
        /// Settings of [`ColorTransformer::Intensity`].
        intensity: IntensitySettings = IntensitySettings::default() => properties();
        /// Settings of [`ColorTransformer::AxisColor`].
        axis_color: AxisColorSettings = AxisColorSettings::default() => properties();
        /// Opacity, 0 to 1.
        alpha: f32 = 1.0 => float("Alpha", 0.0..=1.0);
        /// Seconds until a cloud disappears; 0 keeps only the latest.
        decay_time_secs: f32 = 0.0 => float("Decay Time", at_least(0.0));
        /// The chosen source of colour. `None`, or a source that a cloud does not fit: `Rgb8` if the cloud fits that,
        /// else `Intensity`, and that choice then stays for later clouds.
        color_transformer: Option<ColorTransformer> = None
            => choice_or_automatic("Color Transformer", &COLOR_TRANSFORMERS);
        /// The colour of [`ColorTransformer::FlatColor`], as red, green and blue.
        flat_color: [u8; 3] = [255, 255, 255] => color("Color");
    }
    skip ["Selectable"];
    then read_style;
}

impl CloudSettings {
    /// The defaults of a display of single values, which are coloured by their channel between fixed bounds.
    fn of_values(channel_name: &str, min: f32, max: f32) -> Self {
        let channel_name = channel_name.to_owned();
        let intensity =
            IntensitySettings { channel_name, auto_bounds: false, min, max, ..IntensitySettings::default() };
        CloudSettings { intensity, ..CloudSettings::default() }
    }

    /// The defaults of FluidPressure: from low to high air pressure in pascals.
    pub fn fluid_pressure_default() -> Self {
        CloudSettings::of_values("fluid_pressure", 98_000.0, 105_000.0)
    }

    /// The defaults of Illuminance: from dark to 1000 lux.
    pub fn illuminance_default() -> Self {
        CloudSettings::of_values("illuminance", 0.0, 1000.0)
    }

    /// The defaults of RelativeHumidity: from dry to saturated, 1.
    pub fn relative_humidity_default() -> Self {
        CloudSettings::of_values("relative_humidity", 0.0, 1.0)
    }

    /// The defaults of Temperature: from 0 to 100 degrees Celsius, with the rainbow turned round.
    pub fn temperature_default() -> Self {
        let mut settings = CloudSettings::of_values("temperature", 0.0, 100.0);
        settings.intensity.invert_rainbow = true;
        settings
    }

    /// Reads the properties of PointCloud2, PointCloud and LaserScan.
    pub(crate) fn read_cloud(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::default())
    }

    /// Reads the properties of FluidPressure, as the next ones do those of their classes.
    pub(crate) fn read_fluid_pressure(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::fluid_pressure_default())
    }

    pub(crate) fn read_illuminance(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::illuminance_default())
    }

    pub(crate) fn read_relative_humidity(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::relative_humidity_default())
    }

    pub(crate) fn read_temperature(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::temperature_default())
    }

    fn read_over(section: &mut Section<'_>, mut settings: Self) -> Self {
        section.properties(&mut settings);
        section.topic("Topic", &mut settings.topic);
        section.count("Queue Size", 0, &mut settings.queue_size);
        settings
    }

    fn read_style(&mut self, section: &mut Section<'_>) {
        let (mut size_px, mut size_m) = DEFAULT_SIZES;
        section.float("Size (Pixels)", at_least(1.0), &mut size_px);
        section.float("Size (m)", at_least(0.0001), &mut size_m);
        self.style = PointStyle::FlatSquares { side_m: size_m };
        section.choice("Style", &styles(size_px, size_m), &mut self.style);
        section.choice_or_automatic("Position Transformer", &POSITION_TRANSFORMERS, &mut None);
    }
}
