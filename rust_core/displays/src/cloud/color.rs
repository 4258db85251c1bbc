//! rviz's colour transformers: from a point's bytes or place to its colour.
//!
//! Comparisons follow rviz's order of arguments, so that NaN values colour as they do there; colours are packed the way
//! Ogre packs them (times 255, cut off).

use nalgebra::{Isometry3, Point3};
use rcs_rviz_config::{AxisColorSettings, CloudSettings, ColorTransformer, IntensitySettings};
use rcs_scene::Rgba;

use super::fields::{Channel, Layout};

/// The colours of a cloud's points.
pub(crate) enum PointColor {
    /// One for all.
    Uniform([u8; 4]),
    /// One each.
    PerPoint(Vec<[u8; 4]>),
}

/// A chosen transformer with its settings.
#[derive(Debug)]
pub(crate) struct Coloring<'a> {
    settings: &'a CloudSettings,
    transformer: ColorTransformer,
    fixed_from_cloud: &'a Isometry3<f64>,
}

const WHITE: [u8; 4] = [255; 4];

impl<'a> Coloring<'a> {
    /// A transformer that fits the cloud, see [`Layout::fitting_transformer`].
    pub(crate) fn new(
        settings: &'a CloudSettings,
        transformer: ColorTransformer,
        fixed_from_cloud: &'a Isometry3<f64>,
    ) -> Self {
        Self { settings, transformer, fixed_from_cloud }
    }

    /// Whether colours depend on more than positions.
    pub(crate) fn needs_bytes(&self) -> bool {
        !matches!(self.transformer, ColorTransformer::FlatColor | ColorTransformer::AxisColor)
    }

    /// Colours points, given by their bytes and by their positions in the cloud's frame.
    pub(crate) fn prepare(
        &self,
        layout: &Layout,
        big_endian: bool,
        points: &[&[u8]],
        positions: &[[f32; 3]],
    ) -> PointColor {
        match self.transformer {
            ColorTransformer::FlatColor => {
                PointColor::Uniform(Rgba::from_rgb8(self.settings.flat_color, 1.0).to_rgba8())
            }
            ColorTransformer::AxisColor => {
                PointColor::PerPoint(by_axis(&self.settings.axis_color, self.fixed_from_cloud, positions))
            }
            ColorTransformer::Intensity => by_intensity(&self.settings.intensity, layout, big_endian, points),
            ColorTransformer::Rgb8 => packed(layout, big_endian, points, |rgb| rgb),
            ColorTransformer::Mono8 => packed(layout, big_endian, points, |[r, g, b]| {
                let grey = (0.2989 * f64::from(r) + 0.5870 * f64::from(g) + 0.1140 * f64::from(b)) as f32;
                [grey; 3]
            }),
            ColorTransformer::Rgbf32 => {
                let channels = ["r", "g", "b"].map(|name| layout.channel(name));
                let [Some(r), Some(g), Some(b)] = channels else { return PointColor::Uniform(WHITE) };
                let float = |channel: &Channel, point: &[u8]| f32::from_bits(channel.bits(point, big_endian));
                let color = |point: &&[u8]| Rgba::new(float(r, point), float(g, point), float(b, point), 1.0);
                PointColor::PerPoint(points.iter().map(|point| color(point).to_rgba8()).collect())
            }
        }
    }
}

/// Colours of a packed channel, each mapped from red, green and blue of 0 to 1.
fn packed(layout: &Layout, big_endian: bool, points: &[&[u8]], map: impl Fn([f32; 3]) -> [f32; 3]) -> PointColor {
    let Some((channel, has_alpha)) = layout.packed_color() else { return PointColor::Uniform(WHITE) };
    let mut levels = [0.0; 256];
    for (i, level) in levels.iter_mut().enumerate() {
        *level = i as f32 / 255.0;
    }
    let color = |point: &&[u8]| {
        let [a, r, g, b] = channel.bits(point, big_endian).to_be_bytes().map(|byte| levels[usize::from(byte)]);
        let [r, g, b] = map([r, g, b]);
        Rgba::new(r, g, b, if has_alpha { a } else { 1.0 }).to_rgba8()
    };
    PointColor::PerPoint(points.iter().map(color).collect())
}

/// The smallest and largest of the values as rviz finds them, from bounds that an ordinary value replaces.
fn bounds(values: impl Iterator<Item = f32>, outermost: f32) -> (f32, f32) {
    let (mut min, mut max) = (outermost, -outermost);
    for value in values {
        // A NaN replaces both bounds, and the next value replaces the NaN.
        min = if min < value { min } else { value };
        max = if value < max { max } else { value };
    }
    (min, max)
}

fn by_intensity(settings: &IntensitySettings, layout: &Layout, big_endian: bool, points: &[&[u8]]) -> PointColor {
    let named = layout.channel(&settings.channel_name);
    let other_name = if settings.channel_name == "intensity" { layout.channel("intensities") } else { None };
    let Some(channel) = named.or(other_name) else { return PointColor::Uniform(WHITE) };
    let values: Vec<f32> = points.iter().map(|point| channel.value(point, big_endian)).collect();
    let (min, max) = if settings.auto_bounds {
        let outermost = 999_999.0;
        let (min, max) = bounds(values.iter().copied(), outermost);
        (if -outermost < min { min } else { -outermost }, if max < outermost { max } else { outermost })
    } else {
        (settings.min, settings.max)
    };
    let range = if max == min { 1e20 } else { max - min };
    let colors = if settings.use_rainbow {
        let color = |value: &f32| {
            let share = (1.0 - f64::from((value - min) / range)) as f32;
            rainbow(if settings.invert_rainbow { (1.0 - f64::from(share)) as f32 } else { share })
        };
        values.iter().map(color).collect()
    } else {
        let [low, high] = [settings.min_color, settings.max_color].map(|rgb| Rgba::from_rgb8(rgb, 1.0));
        let color = |value: &f32| {
            let share = (value - min) / range;
            // Written so that a NaN takes the colour of the smallest value, as in rviz.
            let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
            let mix = |low: f32, high: f32| high * share + low * (1.0 - share);
            Rgba::new(mix(low.r, high.r), mix(low.g, high.g), mix(low.b, high.b), 1.0).to_rgba8()
        };
        values.iter().map(color).collect()
    };
    PointColor::PerPoint(colors)
}

fn by_axis(settings: &AxisColorSettings, fixed_from_cloud: &Isometry3<f64>, positions: &[[f32; 3]]) -> Vec<[u8; 4]> {
    let axis = settings.axis as usize;
    let fixed_from_cloud = fixed_from_cloud.cast::<f32>();
    let value = |position: &[f32; 3]| {
        if settings.use_fixed_frame {
            (fixed_from_cloud * Point3::from(*position))[axis]
        } else {
            position[axis]
        }
    };
    let (min, max) = if settings.auto_bounds {
        let outermost = 9999.0;
        // Unlike among intensities, a NaN is passed over.
        positions.iter().map(value).fold((outermost, -outermost), |(min, max), value| (value.min(min), value.max(max)))
    } else {
        (settings.min, settings.max)
    };
    let range = if max == min { 0.001 } else { max - min };
    positions.iter().map(|position| rainbow((1.0 - f64::from((value(position) - min) / range)) as f32)).collect()
}

/// rviz's rainbow: magenta at 0 over blue, cyan, green and yellow to red at 1.
fn rainbow(share: f32) -> [u8; 4] {
    let hue = if share.is_nan() { share } else { share.clamp(0.0, 1.0) } * 5.0 + 1.0;
    let sector = hue.floor() as i32;
    let fraction = hue - sector as f32;
    let n = 1.0 - if sector & 1 == 0 { 1.0 - fraction } else { fraction };
    let (r, g, b) = match sector {
        ..=1 => (n, 0.0, 1.0),
        2 => (0.0, n, 1.0),
        3 => (0.0, 1.0, n),
        4 => (n, 1.0, 0.0),
        _ => (1.0, n, 0.0),
    };
    Rgba::new(r, g, b, 1.0).to_rgba8()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rainbow_runs_from_magenta_to_red() {
        assert_eq!(rainbow(0.0), [255, 0, 255, 255]);
        assert_eq!(rainbow(0.2), [0, 0, 255, 255]);
        assert_eq!(rainbow(0.4), [0, 255, 255, 255]);
        assert_eq!(rainbow(1.0), [255, 0, 0, 255]);
        assert_eq!(rainbow(-7.0), rainbow(0.0));
        assert_eq!(rainbow(7.0), rainbow(1.0));
    }

    #[test]
    fn a_nan_replaces_the_bounds_until_the_next_value() {
        let (min, max) = bounds([1.0, 5.0, f32::NAN, 3.0].into_iter(), 9999.0);
        assert_eq!((min, max), (3.0, 3.0));
    }
}
