//! `rviz/PointCloud2`: points of a cloud in one of five styles, coloured in one of six ways.
//!
//! rviz keeps the settings of every colour transformer at all times, because a cloud that does not fit the chosen
//! one is coloured by another; so they stand side by side here. The only position transformer that rviz has is
//! `XYZ`, which every cloud that can be drawn fits, so there is nothing to keep of that choice.

use crate::section::{at_least, Section, ANY};

/// How one point is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointStyle {
    /// A square of a size in pixels.
    Points,
    /// A square of a size in metres that faces the camera.
    Squares,
    /// As `Squares`, without its shading.
    FlatSquares,
    /// A disc shaded as a sphere, with a size in metres.
    Spheres,
    /// A cube along the axes of the cloud's frame, with a size in metres.
    Boxes,
}

const STYLES: [(&str, PointStyle); 5] = [
    ("Points", PointStyle::Points),
    ("Squares", PointStyle::Squares),
    ("Flat Squares", PointStyle::FlatSquares),
    ("Spheres", PointStyle::Spheres),
    ("Boxes", PointStyle::Boxes),
];

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
    /// One colour, [`PointCloud2Settings::flat_color`].
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
    fn read(section: &mut Section<'_>) -> Self {
        let mut settings = IntensitySettings::default();
        section.text("Channel Name", &mut settings.channel_name);
        section.bool("Use rainbow", &mut settings.use_rainbow);
        section.bool("Invert Rainbow", &mut settings.invert_rainbow);
        section.color("Min Color", &mut settings.min_color);
        section.color("Max Color", &mut settings.max_color);
        section.bool("Autocompute Intensity Bounds", &mut settings.auto_bounds);
        section.float("Min Intensity", ANY, &mut settings.min);
        section.float("Max Intensity", ANY, &mut settings.max);
        settings
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
    fn read(section: &mut Section<'_>) -> Self {
        let mut settings = AxisColorSettings::default();
        section.choice("Axis", &AXES, &mut settings.axis);
        let mut bounds = section.child("Autocompute Value Bounds");
        bounds.bool("Value", &mut settings.auto_bounds);
        bounds.float("Min Value", ANY, &mut settings.min);
        bounds.float("Max Value", ANY, &mut settings.max);
        bounds.finish();
        section.bool("Use Fixed Frame", &mut settings.use_fixed_frame);
        settings
    }
}

/// The properties of a PointCloud2 display.
#[derive(Debug, Clone, PartialEq)]
pub struct PointCloud2Settings {
    /// Topic of `sensor_msgs/PointCloud2`; empty when none is chosen.
    pub topic: String,
    /// Whether UDP is preferred.
    pub unreliable: bool,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// Whether points can be picked with the mouse; no effect on the picture.
    pub selectable: bool,
    /// How a point is drawn.
    pub style: PointStyle,
    /// Edge of a point of style [`PointStyle::Points`] in pixels; at least 1.
    pub size_px: f32,
    /// Edge or diameter of a point of any other style in metres; at least 0.0001.
    pub size_m: f32,
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

impl Default for PointCloud2Settings {
    fn default() -> Self {
        PointCloud2Settings {
            topic: String::new(),
            unreliable: false,
            queue_size: 10,
            selectable: true,
            style: PointStyle::FlatSquares,
            size_px: 3.0,
            size_m: 0.01,
            alpha: 1.0,
            decay_time_secs: 0.0,
            color_transformer: None,
            intensity: IntensitySettings::default(),
            flat_color: [255, 255, 255],
            axis_color: AxisColorSettings::default(),
        }
    }
}

impl PointCloud2Settings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = PointCloud2Settings {
            intensity: IntensitySettings::read(section),
            axis_color: AxisColorSettings::read(section),
            ..PointCloud2Settings::default()
        };
        section.text("Topic", &mut settings.topic);
        section.bool("Unreliable", &mut settings.unreliable);
        section.count("Queue Size", 0, &mut settings.queue_size);
        section.bool("Selectable", &mut settings.selectable);
        section.choice("Style", &STYLES, &mut settings.style);
        section.float("Size (Pixels)", at_least(1.0), &mut settings.size_px);
        section.float("Size (m)", at_least(0.0001), &mut settings.size_m);
        section.float("Alpha", 0.0..=1.0, &mut settings.alpha);
        section.float("Decay Time", at_least(0.0), &mut settings.decay_time_secs);
        section.choice_or_automatic("Position Transformer", &POSITION_TRANSFORMERS, &mut None);
        section.choice_or_automatic("Color Transformer", &COLOR_TRANSFORMERS, &mut settings.color_transformer);
        section.color("Color", &mut settings.flat_color);
        settings
    }
}
