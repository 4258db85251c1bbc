//! The displays that show their messages as clouds of points: PointCloud2, PointCloud, LaserScan, and those of single
//! values (FluidPressure, Illuminance, RelativeHumidity, Temperature). Points are drawn in one of five styles and
//! coloured in one of six ways.
//!
//! All of them have the same properties; those of single values begin with other bounds and name their own channel.
//!
//! rviz keeps the settings of every colour transformer at all times, because a cloud that does not fit the chosen
//! one is coloured by another; so they stand side by side here. The only position transformer that rviz has is
//! `XYZ`, which every cloud that can be drawn fits, so there is nothing to keep of that choice.

use rcs_scene::PointStyle;

use crate::section::{at_least, Section, ANY};

/// The sizes with which a display of clouds begins: of points in pixels, of all other styles in metres.
const DEFAULT_SIZES: (f32, f32) = (3.0, 0.01);

/// The names of styles in a config, each with the style in the size that belongs to it.
fn styles(diameter_px: f32, side_m: f32) -> [(&'static str, PointStyle); 5] {
    [
        ("Points", PointStyle::Points { diameter_px }),
        ("Squares", PointStyle::Squares { size_m: [side_m; 2] }),
        ("Flat Squares", PointStyle::FlatSquares { side_m }),
        ("Spheres", PointStyle::Spheres { size_m: [side_m; 2] }),
        ("Boxes", PointStyle::Boxes { size_m: [side_m; 3] }),
    ]
}

/// Where the colour of a point comes from.
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
    /// Its name in a config.
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

/// The settings of [`ColorTransformer::Intensity`].
#[derive(Debug, Clone, PartialEq)]
pub struct IntensitySettings {
    /// The field that holds the value. For `intensity` a cloud may have `intensities` instead.
    pub channel_name: String,
    /// Whether colours run through the rainbow or from `min_color` to `max_color`.
    pub use_rainbow: bool,
    /// Whether the rainbow runs the other way.
    pub invert_rainbow: bool,
    /// Colour of the smallest value, as red, green and blue.
    pub min_color: [u8; 3],
    /// Colour of the largest value, as red, green and blue.
    pub max_color: [u8; 3],
    /// Whether the bounds are those of each cloud or `min` and `max`.
    pub auto_bounds: bool,
    /// Smallest value.
    pub min: f32,
    /// Largest value.
    pub max: f32,
}

impl Default for IntensitySettings {
    fn default() -> Self {
        IntensitySettings {
            channel_name: "intensity".to_owned(),
            use_rainbow: true,
            invert_rainbow: false,
            min_color: [0, 0, 0],
            max_color: [255, 255, 255],
            auto_bounds: true,
            min: 0.0,
            max: 4096.0,
        }
    }
}

impl IntensitySettings {
    fn read(&mut self, section: &mut Section<'_>) {
        section.text("Channel Name", &mut self.channel_name);
        section.bool("Use rainbow", &mut self.use_rainbow);
        section.bool("Invert Rainbow", &mut self.invert_rainbow);
        section.color("Min Color", &mut self.min_color);
        section.color("Max Color", &mut self.max_color);
        section.bool("Autocompute Intensity Bounds", &mut self.auto_bounds);
        section.float("Min Intensity", ANY, &mut self.min);
        section.float("Max Intensity", ANY, &mut self.max);
    }
}

/// The settings of [`ColorTransformer::AxisColor`].
#[derive(Debug, Clone, PartialEq)]
pub struct AxisColorSettings {
    /// The axis along which colours run through the rainbow.
    pub axis: Axis,
    /// Whether the bounds are those of each cloud or `min` and `max`.
    pub auto_bounds: bool,
    /// Smallest position in metres.
    pub min: f32,
    /// Largest position in metres.
    pub max: f32,
    /// Whether positions are those in the fixed frame or in the cloud's own frame.
    pub use_fixed_frame: bool,
}

impl Default for AxisColorSettings {
    fn default() -> Self {
        AxisColorSettings { axis: Axis::Z, auto_bounds: true, min: -10.0, max: 10.0, use_fixed_frame: true }
    }
}

impl AxisColorSettings {
    fn read(&mut self, section: &mut Section<'_>) {
        section.choice("Axis", &AXES, &mut self.axis);
        let mut bounds = section.child("Autocompute Value Bounds");
        bounds.bool("Value", &mut self.auto_bounds);
        bounds.float("Min Value", ANY, &mut self.min);
        bounds.float("Max Value", ANY, &mut self.max);
        bounds.finish();
        section.bool("Use Fixed Frame", &mut self.use_fixed_frame);
    }
}

/// The properties of a display of clouds.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudSettings {
    /// Topic of the class's messages; empty when none is chosen.
    pub topic: String,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// How a point is drawn, and how large: at least 1 pixel for [`PointStyle::Points`], at least 0.0001 m for all
    /// other styles. Never [`PointStyle::Tiles`].
    pub style: PointStyle,
    /// Opacity, 0 to 1.
    pub alpha: f32,
    /// How long a cloud stays, in seconds; 0 keeps only the latest.
    pub decay_time_secs: f32,
    /// The chosen source of colour. `None`, or a source that a cloud does not fit: `Rgb8` if the cloud fits that, else
    /// `Intensity`, and that choice then stays for later clouds.
    pub color_transformer: Option<ColorTransformer>,
    /// Settings of [`ColorTransformer::Intensity`].
    pub intensity: IntensitySettings,
    /// The colour of [`ColorTransformer::FlatColor`], as red, green and blue.
    pub flat_color: [u8; 3],
    /// Settings of [`ColorTransformer::AxisColor`].
    pub axis_color: AxisColorSettings,
}

impl Default for CloudSettings {
    fn default() -> Self {
        CloudSettings {
            topic: String::new(),
            queue_size: 10,
            style: PointStyle::FlatSquares { side_m: DEFAULT_SIZES.1 },
            alpha: 1.0,
            decay_time_secs: 0.0,
            color_transformer: None,
            intensity: IntensitySettings::default(),
            flat_color: [255, 255, 255],
            axis_color: AxisColorSettings::default(),
        }
    }
}

impl CloudSettings {
    /// The defaults of a display of single values, which colours by their channel between fixed bounds.
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
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::default())
    }

    /// Reads the properties of FluidPressure.
    pub(crate) fn read_fluid_pressure(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::fluid_pressure_default())
    }

    /// Reads the properties of Illuminance.
    pub(crate) fn read_illuminance(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::illuminance_default())
    }

    /// Reads the properties of RelativeHumidity.
    pub(crate) fn read_relative_humidity(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::relative_humidity_default())
    }

    /// Reads the properties of Temperature.
    pub(crate) fn read_temperature(section: &mut Section<'_>) -> Self {
        Self::read_over(section, Self::temperature_default())
    }

    /// Reads the properties; what the section lacks is as in `defaults`.
    fn read_over(section: &mut Section<'_>, defaults: Self) -> Self {
        let mut settings = defaults;
        settings.read_points(section);
        section.subscription(&mut settings.topic, 0, &mut settings.queue_size);
        settings
    }

    /// Reads how points are drawn, without the topic that they come from.
    pub(crate) fn read_points(&mut self, section: &mut Section<'_>) {
        self.intensity.read(section);
        self.axis_color.read(section);
        section.skip(&["Selectable"]);
        let (mut size_px, mut size_m) = DEFAULT_SIZES;
        section.float("Size (Pixels)", at_least(1.0), &mut size_px);
        section.float("Size (m)", at_least(0.0001), &mut size_m);
        self.style = PointStyle::FlatSquares { side_m: size_m };
        section.choice("Style", &styles(size_px, size_m), &mut self.style);
        section.float("Alpha", 0.0..=1.0, &mut self.alpha);
        section.float("Decay Time", at_least(0.0), &mut self.decay_time_secs);
        section.choice_or_automatic("Position Transformer", &POSITION_TRANSFORMERS, &mut None);
        section.choice_or_automatic("Color Transformer", &COLOR_TRANSFORMERS, &mut self.color_transformer);
        section.color("Color", &mut self.flat_color);
    }
}
