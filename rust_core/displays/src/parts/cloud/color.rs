//! rviz's colour transformers of points.
//!
//! Comparisons follow rviz's order of arguments, which matters for NaN; colours are packed as in Ogre (times 255,
//! truncated).

use nalgebra::{Isometry3, Point3};
use rayon::prelude::*;
use rcs_rviz_config::{AxisColorSettings, CloudSettings, ColorTransformer, IntensitySettings};
use rcs_scene::Rgba;

use super::buffer_pool::CloudPool;
use super::fields::{CloudChannel, CloudLayout};
use super::point_bytes::{PointBytes, SHARE};

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
    /// `transformer` fits the cloud, see [`CloudLayout::fitting_transformer`].
    pub(crate) fn new(
        settings: &'a CloudSettings,
        transformer: ColorTransformer,
        fixed_from_cloud: &'a Isometry3<f64>,
    ) -> Self {
        Self { settings, transformer, fixed_from_cloud }
    }

    /// Colours points by their bytes and by their positions in the cloud's frame.
    pub(crate) fn prepare(
        &self,
        layout: &CloudLayout,
        big_endian: bool,
        points: &PointBytes<'_>,
        positions: &[[f32; 3]],
        pool: &mut CloudPool,
    ) -> PointColor {
        let CloudPool { colors, values, .. } = pool;
        let mut memory = || colors.take_filled(points.len());
        match self.transformer {
            ColorTransformer::FlatColor => {
                PointColor::Uniform(Rgba::from_rgb8(self.settings.flat_color, 1.0).to_rgba8())
            }
            ColorTransformer::AxisColor => {
                PointColor::PerPoint(by_axis(&self.settings.axis_color, self.fixed_from_cloud, positions, memory()))
            }
            ColorTransformer::Intensity => {
                by_intensity(&self.settings.intensity, layout, big_endian, points, (values, memory()))
            }
            ColorTransformer::Rgb8 => packed(layout, big_endian, points, memory(), |[r, g, b]| {
                [packed_level(r), packed_level(g), packed_level(b)]
            }),
            ColorTransformer::Mono8 => packed(layout, big_endian, points, memory(), |rgb| {
                let [r, g, b] = rgb;
                let share = |byte: u8| f64::from(f32::from(byte) / 255.0);
                let grey = (0.2989 * share(r) + 0.5870 * share(g) + 0.1140 * share(b)) as f32;
                let [level, ..] = Rgba::new(grey, grey, grey, 1.0).to_rgba8();
                [level; 3]
            }),
            ColorTransformer::Rgbf32 => {
                let channels = ["r", "g", "b"].map(|name| layout.channel(name));
                let [Some(r), Some(g), Some(b)] = channels else { return PointColor::Uniform(WHITE) };
                let float = |channel: &CloudChannel, point: &[u8]| f32::from_bits(channel.bits(point, big_endian));
                let color = |point: &[u8]| Rgba::new(float(r, point), float(g, point), float(b, point), 1.0);
                let mut colors = memory();
                points.map(&mut colors, |point| color(point).to_rgba8());
                PointColor::PerPoint(colors)
            }
        }
    }
}

/// A byte after rviz's conversion to a float of 0 to 1 and, truncated, back. Some lose one.
#[inline(always)]
fn packed_level(byte: u8) -> u8 {
    const LEVELS: [u8; 256] = {
        let mut levels = [0; 256];
        let mut i = 0;
        while i < 256 {
            levels[i] = (i as f32 / 255.0 * 255.0) as u8;
            i += 1;
        }
        levels
    };
    LEVELS[usize::from(byte)]
}

/// Colours of a packed channel, with a function of red, green and blue.
fn packed(
    layout: &CloudLayout,
    big_endian: bool,
    points: &PointBytes<'_>,
    mut colors: Vec<[u8; 4]>,
    map: impl Fn([u8; 3]) -> [u8; 3] + Sync + Send,
) -> PointColor {
    let Some((channel, has_alpha)) = layout.packed_color() else { return PointColor::Uniform(WHITE) };
    points.map(&mut colors, |point| {
        let [a, r, g, b] = channel.bits(point, big_endian).to_be_bytes();
        let [r, g, b] = map([r, g, b]);
        [r, g, b, if has_alpha { packed_level(a) } else { 255 }]
    });
    PointColor::PerPoint(colors)
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
    values.par_chunks(SHARE).map(of_share).reduce(|| (start, false), join).0
}

fn by_intensity(
    settings: &IntensitySettings,
    layout: &CloudLayout,
    big_endian: bool,
    points: &PointBytes<'_>,
    (values, mut colors): (&mut Vec<f32>, Vec<[u8; 4]>),
) -> PointColor {
    let named = layout.channel(&settings.channel_name);
    let other_name = if settings.channel_name == "intensity" { layout.channel("intensities") } else { None };
    let Some(channel) = named.or(other_name) else { return PointColor::Uniform(WHITE) };
    values.resize(points.len(), 0.0);
    points.map(values, |point| channel.value(point, big_endian));
    let (min, max) = if settings.auto_bounds {
        let outermost = 999_999.0;
        let (min, max) = bounds(values, outermost);
        (if -outermost < min { min } else { -outermost }, if max < outermost { max } else { outermost })
    } else {
        (settings.min, settings.max)
    };
    let range = if max == min { 1e20 } else { max - min };
    if settings.use_rainbow {
        let color = |value: &f32| {
            let share = (1.0 - f64::from((value - min) / range)) as f32;
            rainbow(if settings.invert_rainbow { (1.0 - f64::from(share)) as f32 } else { share }).to_rgba8()
        };
        values.par_iter().with_min_len(SHARE).map(color).collect_into_vec(&mut colors);
    } else {
        let [low, high] = [settings.min_color, settings.max_color].map(|rgb| Rgba::from_rgb8(rgb, 1.0));
        let color = |value: &f32| {
            let share = (value - min) / range;
            // Written so that a NaN takes the colour of the smallest value, as in rviz.
            let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
            let mix = |low: f32, high: f32| high * share + low * (1.0 - share);
            Rgba::new(mix(low.r, high.r), mix(low.g, high.g), mix(low.b, high.b), 1.0).to_rgba8()
        };
        values.par_iter().with_min_len(SHARE).map(color).collect_into_vec(&mut colors);
    }
    PointColor::PerPoint(colors)
}

fn by_axis(
    settings: &AxisColorSettings,
    fixed_from_cloud: &Isometry3<f64>,
    positions: &[[f32; 3]],
    mut colors: Vec<[u8; 4]>,
) -> Vec<[u8; 4]> {
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
        // Unlike among intensities, a NaN is ignored.
        let (start, join) = (|| (outermost, -outermost), |a: (f32, f32), b: (f32, f32)| (a.0.min(b.0), a.1.max(b.1)));
        let values = positions.par_iter().with_min_len(SHARE).map(value);
        values.fold(start, |bounds, value| join(bounds, (value, value))).reduce(start, join)
    } else {
        (settings.min, settings.max)
    };
    let range = if max == min { 0.001 } else { max - min };
    let color = |position: &[f32; 3]| rainbow((1.0 - f64::from((value(position) - min) / range)) as f32).to_rgba8();
    positions.par_iter().with_min_len(SHARE).map(color).collect_into_vec(&mut colors);
    colors
}

/// Colours of rviz's rainbow at equal distances from 0 to 1; each differs from the next in one channel.
const RAINBOW: [[f32; 3]; 6] =
    [[1.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]];

/// rviz's rainbow: magenta at 0 over blue, cyan, green and yellow to red at 1.
pub(crate) fn rainbow(share: f32) -> Rgba {
    let share = if share.is_nan() { share } else { share.clamp(0.0, 1.0) };
    // rviz counts the colours from one, in single precision, and the last level shows how that rounds.
    let place = share * (RAINBOW.len() - 1) as f32 + 1.0;
    // A NaN becomes 0.
    let number = (place as usize).max(1);
    let (from, to) = (RAINBOW[number - 1], RAINBOW[number.min(RAINBOW.len() - 1)]);
    let falling = 1.0 - (place - place.trunc());
    let rising = 1.0 - falling;
    let channel = |i: usize| match to[i] - from[i] {
        change if change < 0.0 => falling,
        change if change > 0.0 => rising,
        _ => to[i],
    };
    Rgba::new(channel(0), channel(1), channel(2), 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rainbow_runs_from_magenta_to_red() {
        assert_eq!(rainbow(0.0).to_rgba8(), [255, 0, 255, 255]);
        assert_eq!(rainbow(0.2).to_rgba8(), [0, 0, 255, 255]);
        assert_eq!(rainbow(0.4).to_rgba8(), [0, 255, 255, 255]);
        assert_eq!(rainbow(0.6).to_rgba8(), [0, 255, 0, 255]);
        assert_eq!(rainbow(0.75).to_rgba8(), [191, 255, 0, 255]);
        assert_eq!(rainbow(0.8).to_rgba8(), [255, 255, 0, 255]);
        assert_eq!(rainbow(1.0).to_rgba8(), [255, 0, 0, 255]);
        assert_eq!(rainbow(f32::NAN).to_rgba8(), [0, 0, 255, 255]);
        assert_eq!(rainbow(-7.0), rainbow(0.0));
        assert_eq!(rainbow(7.0), rainbow(1.0));
    }

    #[test]
    fn bytes_go_the_way_of_floats() {
        for byte in 0..=255 {
            let level = f32::from(byte) / 255.0;
            assert_eq!([packed_level(byte); 4], Rgba::new(level, level, level, level).to_rgba8());
        }
    }

    #[test]
    fn a_nan_replaces_the_bounds_until_the_next_value() {
        let (min, max) = bounds(&[1.0, 5.0, f32::NAN, 3.0], 9999.0);
        assert_eq!((min, max), (3.0, 3.0));
    }

    #[test]
    fn bounds_are_those_of_one_value_after_the_other() {
        let mut values: Vec<f32> = (0..3 * SHARE).map(|i| (i * 7919 % 10_007) as f32 - 5000.0).collect();
        assert_eq!(bounds(&values, 9999.0), (-5000.0, 5006.0));
        values[0] = f32::NAN;
        let last = 2 * SHARE + 17;
        values[last] = f32::NAN;
        values[last + 1..].iter_mut().for_each(|value| *value = value.abs() + 1.0);
        values[3 * SHARE - 1] = 9000.0;
        let rest = &values[last + 1..];
        let smallest = rest.iter().copied().fold(f32::INFINITY, f32::min);
        assert_eq!(bounds(&values, 9999.0), (smallest, 9000.0));
        values[3 * SHARE - 1] = f32::NAN;
        let (min, max) = bounds(&values, 9999.0);
        assert!(min.is_nan() && max.is_nan());
    }
}
