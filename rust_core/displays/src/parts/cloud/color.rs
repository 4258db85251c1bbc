//! rviz's colour transformers of points.
//!
//! Comparisons follow rviz's order of arguments, which matters for NaN; colours are packed as in Ogre (times 255,
//! truncated).

use nalgebra::Isometry3;
use rayon::prelude::*;
use rcs_rviz_config::{AxisColorSettings, CloudSettings, ColorTransformer, IntensitySettings};
use rcs_scene::{rainbow, AxisRainbow, PackedColors, PointBytes, Rgba, POINTS_PER_SHARE};

use super::fields::{CloudChannel, CloudLayout};

pub(crate) enum PointColor {
    Uniform([u8; 4]),
    PerPoint(Vec<[u8; 4]>),
}

#[derive(Debug)]
pub(crate) struct Coloring<'a> {
    settings: &'a CloudSettings,
    transformer: ColorTransformer,
    fixed_from_cloud: &'a Isometry3<f64>,
}

const WHITE: [u8; 4] = [255; 4];

impl<'a> Coloring<'a> {
    /// `transformer` fits the cloud, see [`CloudLayout::colored`].
    pub(crate) fn new(
        settings: &'a CloudSettings,
        transformer: ColorTransformer,
        fixed_from_cloud: &'a Isometry3<f64>,
    ) -> Self {
        Self { settings, transformer, fixed_from_cloud }
    }

    /// The rule by which a renderer can colour points; `None` if all values must be known first, or if it has no such
    /// rule.
    pub(crate) fn packed_colors(&self, layout: &CloudLayout) -> Option<PackedColors> {
        match self.transformer {
            ColorTransformer::FlatColor => Some(PackedColors::Uniform(self.flat_color())),
            ColorTransformer::AxisColor => {
                (!self.settings.axis_color.auto_bounds).then(|| PackedColors::Axis(self.axis_rainbow()))
            }
            ColorTransformer::Rgb8 => match layout.packed_color()? {
                (channel, false) => Some(PackedColors::Rgb { offset: channel.offset }),
                (_, true) => None,
            },
            ColorTransformer::Intensity | ColorTransformer::Mono8 | ColorTransformer::Rgbf32 => None,
        }
    }

    fn flat_color(&self) -> [u8; 4] {
        Rgba::from_rgb8(self.settings.flat_color, 1.0).to_rgba8()
    }

    /// The rainbow along the chosen axis, between the bounds of the settings.
    fn axis_rainbow(&self) -> AxisRainbow {
        let settings = &self.settings.axis_color;
        let fixed_from_object = settings.use_fixed_frame.then(|| self.fixed_from_cloud.cast::<f32>());
        AxisRainbow::new(settings.axis as usize, fixed_from_object).between(settings.min, settings.max)
    }

    /// Colours points by their bytes and by their positions in the cloud's frame.
    pub(crate) fn prepare(&self, layout: &CloudLayout, points: &PointBytes<'_>, positions: &[[f32; 3]]) -> PointColor {
        match self.transformer {
            ColorTransformer::FlatColor => PointColor::Uniform(self.flat_color()),
            ColorTransformer::AxisColor => {
                PointColor::PerPoint(by_axis(&self.settings.axis_color, self.axis_rainbow(), positions))
            }
            ColorTransformer::Intensity => by_intensity(&self.settings.intensity, layout, points),
            // rviz's way over floats ends at the same bytes.
            ColorTransformer::Rgb8 => packed(layout, points, |rgb| rgb),
            ColorTransformer::Mono8 => packed(layout, points, |rgb| {
                let [r, g, b] = rgb;
                let share = |byte: u8| f64::from(f32::from(byte) / 255.0);
                let grey = (0.2989 * share(r) + 0.5870 * share(g) + 0.1140 * share(b)) as f32;
                let [level, ..] = Rgba::new(grey, grey, grey, 1.0).to_rgba8();
                [level; 3]
            }),
            ColorTransformer::Rgbf32 => {
                let channels = ["r", "g", "b"].map(|name| layout.channel(name));
                let [Some(r), Some(g), Some(b)] = channels else { return PointColor::Uniform(WHITE) };
                let float = |channel: &CloudChannel, point: &[u8]| f32::from_bits(channel.bits(point));
                let color = |point: &[u8]| Rgba::new(float(r, point), float(g, point), float(b, point), 1.0);
                PointColor::PerPoint(points.map(|point| color(point).to_rgba8()))
            }
        }
    }
}

/// Colours of a packed channel, with a function of red, green and blue.
fn packed(layout: &CloudLayout, points: &PointBytes<'_>, map: impl Fn([u8; 3]) -> [u8; 3] + Sync + Send) -> PointColor {
    let Some((channel, has_alpha)) = layout.packed_color() else { return PointColor::Uniform(WHITE) };
    PointColor::PerPoint(points.map(|point| {
        let [a, r, g, b] = channel.bits(point).to_be_bytes();
        let [r, g, b] = map([r, g, b]);
        [r, g, b, if has_alpha { a } else { 255 }]
    }))
}

/// Minimum and maximum as rviz computes them, one value after the other, from bounds that an ordinary value replaces. A
/// NaN replaces both bounds, and the next value replaces the NaN; so only the values after the last NaN count.
fn bounds(values: &[f32], outermost: f32) -> (f32, f32) {
    let start = (outermost, -outermost);
    let add = |(min, max): (f32, f32), (low, high): (f32, f32)| {
        (if min < low { min } else { low }, if high < max { max } else { high })
    };
    let of_share = |share: &[f32]| {
        let bounds = share.iter().fold(start, |bounds, &value| add(bounds, (value, value)));
        (bounds, share.iter().any(|value| value.is_nan()))
    };
    let join = |before: ((f32, f32), bool), after: ((f32, f32), bool)| {
        if after.1 {
            after
        } else {
            (add(before.0, after.0), before.1)
        }
    };
    values.par_chunks(POINTS_PER_SHARE).map(of_share).reduce(|| (start, false), join).0
}

fn by_intensity(settings: &IntensitySettings, layout: &CloudLayout, points: &PointBytes<'_>) -> PointColor {
    let Some(channel) = layout.intensity(&settings.channel_name) else { return PointColor::Uniform(WHITE) };
    let values = points.map(|point| channel.value(point));
    let (min, max) = if settings.auto_bounds {
        let outermost = 999_999.0;
        let (min, max) = bounds(&values, outermost);
        (if -outermost < min { min } else { -outermost }, if max < outermost { max } else { outermost })
    } else {
        (settings.min, settings.max)
    };
    let range = if max == min { 1e20 } else { max - min };
    let values = values.par_iter().with_min_len(POINTS_PER_SHARE);
    let colors = if settings.use_rainbow {
        let color = |value: &f32| {
            let share = (1.0 - f64::from((value - min) / range)) as f32;
            rainbow(if settings.invert_rainbow { (1.0 - f64::from(share)) as f32 } else { share }).to_rgba8()
        };
        values.map(color).collect()
    } else {
        let [low, high] = [settings.min_color, settings.max_color].map(|rgb| Rgba::from_rgb8(rgb, 1.0));
        let color = |value: &f32| {
            let share = (value - min) / range;
            // Written so that a NaN takes the colour of the smallest value, as in rviz.
            let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
            let mix = |low: f32, high: f32| high * share + low * (1.0 - share);
            Rgba::new(mix(low.r, high.r), mix(low.g, high.g), mix(low.b, high.b), 1.0).to_rgba8()
        };
        values.map(color).collect()
    };
    PointColor::PerPoint(colors)
}

fn by_axis(settings: &AxisColorSettings, mut rainbow: AxisRainbow, positions: &[[f32; 3]]) -> Vec<[u8; 4]> {
    if settings.auto_bounds {
        let outermost = 9999.0;
        // Unlike among intensities, a NaN is ignored.
        let (start, join) = (|| (outermost, -outermost), |a: (f32, f32), b: (f32, f32)| (a.0.min(b.0), a.1.max(b.1)));
        let values = positions.par_iter().with_min_len(POINTS_PER_SHARE).map(|position| rainbow.coordinate_m(position));
        let (min, max) = values.fold(start, |bounds, value| join(bounds, (value, value))).reduce(start, join);
        rainbow = rainbow.between(min, max);
    }
    let shares = positions.par_iter().with_min_len(POINTS_PER_SHARE);
    shares.map(|position| rainbow.color(position)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_those_of_one_value_after_the_other() {
        let mut values: Vec<f32> = (0..3 * POINTS_PER_SHARE).map(|i| (i * 7919 % 10_007) as f32 - 5000.0).collect();
        assert_eq!(bounds(&values, 9999.0), (-5000.0, 5006.0));
        values[0] = f32::NAN;
        let last = 2 * POINTS_PER_SHARE + 17;
        values[last] = f32::NAN;
        values[last + 1..].iter_mut().for_each(|value| *value = value.abs() + 1.0);
        values[3 * POINTS_PER_SHARE - 1] = 9000.0;
        let rest = &values[last + 1..];
        let smallest = rest.iter().copied().fold(f32::INFINITY, f32::min);
        assert_eq!(bounds(&values, 9999.0), (smallest, 9000.0));
        values[3 * POINTS_PER_SHARE - 1] = f32::NAN;
        let (min, max) = bounds(&values, 9999.0);
        assert!(min.is_nan() && max.is_nan());
    }
}
