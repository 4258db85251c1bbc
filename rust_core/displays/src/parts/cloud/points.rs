//! A cloud's bytes as positions and colours.

use rayon::prelude::*;
use rcs_messages::PointCloud2;
use rcs_scene::{has_finite_position, PointBuffer, PointBytes, PointColors, POINTS_PER_SHARE};

use super::color::{Coloring, PointColor};
use super::fields::CloudLayout;

/// Treatment of points whose position is not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NonFinite {
    /// Left out before anything else.
    LeftOut,
    /// Coloured with the others, and then moved out of sight. They still count for the cloud's bounds.
    FarAway,
}

/// rviz's place of such points, in metres along each axis.
const FAR_AWAY: [f32; 3] = [999_999.0; 3];

/// Reads the points; also returns how many have no finite position.
pub(crate) fn read(
    cloud: &PointCloud2,
    layout: &CloudLayout,
    coloring: &Coloring<'_>,
    non_finite: NonFinite,
) -> (PointBuffer, usize) {
    let (data, point_step) = (cloud.data(), layout.point_step.max(1));
    let place = layout.positions();
    let shown_in = |points: &[u8]| {
        points.chunks_exact(point_step).filter(|point| has_finite_position(&place.in_point(point))).count()
    };
    let mut shown: Vec<usize> = data.par_chunks(POINTS_PER_SHARE * point_step).map(shown_in).collect();
    let non_finite_count = layout.point_count - shown.iter().sum::<usize>();
    let is_all_shown = non_finite_count == 0 || non_finite == NonFinite::FarAway;
    if is_all_shown {
        let points_in = |share: &[u8]| share.len() / point_step;
        shown
            .iter_mut()
            .zip(data.chunks(POINTS_PER_SHARE * point_step))
            .for_each(|(shown, share)| *shown = points_in(share));
    }
    let points = PointBytes { data, point_step, positions: place, shown: &shown, is_all_shown };
    let mut positions = points.map(|point| place.in_point(point));
    let colors = match coloring.prepare(layout, &points, &positions) {
        PointColor::Uniform(color) => PointColors::Uniform(color),
        PointColor::PerPoint(colors) => PointColors::PerPoint(colors),
    };
    if non_finite_count > 0 && non_finite == NonFinite::FarAway {
        for position in positions.iter_mut().filter(|position| !has_finite_position(position)) {
            *position = FAR_AWAY;
        }
    }
    (PointBuffer { positions, colors }, non_finite_count)
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use proptest::prelude::*;
    use rcs_messages::sensor_msgs::PointField;
    use rcs_rviz_config::{CloudSettings, ColorTransformer};

    use super::super::fields::LayoutError;
    use super::*;

    fn field(name: &str, offset: u32, datatype: u8) -> PointField {
        PointField { name: name.to_owned(), offset, datatype, count: 1 }
    }

    /// An organised cloud of two rows with x, y, z and rgb behind four bytes of padding.
    fn cloud(points: &[([f32; 3], u32)]) -> PointCloud2 {
        let mut data = Vec::new();
        for (position, rgb) in points {
            data.extend([0xee; 4]);
            data.extend(position.iter().flat_map(|value| value.to_le_bytes()));
            data.extend(rgb.to_le_bytes());
        }
        let mut cloud = PointCloud2::default().with_data(data);
        (cloud.height, cloud.width) = (2, points.len() as u32 / 2);
        (cloud.point_step, cloud.row_step) = (20, points.len() as u32 * 10);
        cloud.fields = [("x", 4), ("y", 8), ("z", 12), ("rgb", 16)]
            .map(|(name, offset)| field(name, offset, PointField::FLOAT32))
            .to_vec();
        cloud
    }

    fn read_as(cloud: &PointCloud2, transformer: ColorTransformer) -> Result<PointBuffer, LayoutError> {
        let settings = CloudSettings { color_transformer: Some(transformer), ..CloudSettings::default() };
        let (layout, transformer) = CloudLayout::colored(cloud, &settings)?;
        let fixed_from_cloud = Isometry3::identity();
        let coloring = Coloring::new(&settings, transformer, &fixed_from_cloud);
        Ok(read(cloud, &layout, &coloring, NonFinite::LeftOut).0)
    }

    #[test]
    fn points_that_are_put_far_away_are_coloured_with_the_others() {
        let cloud = cloud(&[([1.0, 0.0, f32::NAN], 0), ([0.0, 0.0, 1.0], 0), ([0.0, 0.0, 2.0], 0), ([0.0; 3], 0)]);
        let layout = CloudLayout::of(&cloud).unwrap();
        let settings = CloudSettings::default();
        let turned = Isometry3::rotation(nalgebra::Vector3::new(0.0, std::f64::consts::PI, 0.0));
        for (fixed_from_cloud, low, high) in [(Isometry3::identity(), 3, 2), (turned, 2, 3)] {
            let coloring = Coloring::new(&settings, ColorTransformer::AxisColor, &fixed_from_cloud);
            let (buffer, non_finite_count) = read(&cloud, &layout, &coloring, NonFinite::FarAway);
            assert_eq!((buffer.positions[0], non_finite_count), ([999_999.0; 3], 1));
            // The bounds are those of the three others: magenta at the top, red at the bottom.
            assert_eq!((buffer.colors.get(low), buffer.colors.get(high)), ([255, 0, 0, 255], [255, 0, 255, 255]));
        }
    }

    #[test]
    fn the_flag_of_big_endian_numbers_changes_nothing() {
        let little = cloud(&[([1.5, 0.0, 0.0], 0x00_0a_14_1e), ([0.0, 2.5, -3.0], 7)]);
        let mut flagged = little.clone();
        flagged.is_bigendian = true;
        for transformer in [ColorTransformer::Rgb8, ColorTransformer::AxisColor] {
            assert_eq!(read_as(&flagged, transformer).unwrap(), read_as(&little, transformer).unwrap());
        }
    }

    #[test]
    fn only_the_fields_that_are_read_must_lie_in_a_point() {
        use ColorTransformer::{AxisColor, FlatColor, Intensity, Mono8, Rgb8, Rgbf32};
        let good = cloud(&[([0.0; 3], 0), ([1.0; 3], 0)]);
        let with = |name: &str, offset, datatype| {
            let mut cloud = good.clone();
            cloud.fields.retain(|field| field.name != name);
            cloud.fields.push(PointField { count: 0, ..field(name, offset, datatype) });
            cloud
        };
        let mut floats = with("g", 17, PointField::FLOAT32);
        floats.fields.extend(["r", "b"].map(|name| field(name, 16, PointField::FLOAT32)));
        for (cloud, name, readers) in [
            (with("_", 20, PointField::UINT8), "_", &[][..]),
            (with("ring", u32::MAX, PointField::FLOAT64), "ring", &[]),
            (with("intensity", 13, PointField::FLOAT64), "intensity", &[Intensity]),
            (with("intensity", 12, PointField::FLOAT64), "intensity", &[]),
            (with("intensities", 20, PointField::UINT8), "intensities", &[Intensity]),
            (with("rgb", 17, PointField::UINT32), "rgb", &[Rgb8, Mono8]),
            (with("rgba", 20, PointField::UINT32), "rgba", &[Rgb8, Mono8]),
            (floats, "g", &[Rgbf32]),
            (with("y", 17, PointField::UINT8), "y", &[FlatColor, AxisColor, Intensity, Rgb8, Mono8]),
        ] {
            for transformer in [FlatColor, AxisColor, Intensity, Rgb8, Mono8, Rgbf32] {
                // Without r, g and b another transformer takes its place.
                if transformer == Rgbf32 && name != "g" {
                    continue;
                }
                let error = read_as(&cloud, transformer).err().map(|error| error.to_string());
                let is_refused = error.as_ref().is_some_and(|text| text.starts_with(&format!("Channel {name} at ")));
                let expected = readers.contains(&transformer);
                assert_eq!((is_refused, error.is_some()), (expected, expected), "{name} {transformer:?} {error:?}");
            }
        }
    }

    #[test]
    fn a_cloud_whose_data_is_not_what_it_claims_is_refused() {
        let good = cloud(&[([0.0; 3], 0), ([1.0; 3], 0)]);
        let mut short = good.clone();
        short.set_data(good.data()[..39].to_vec());
        let error = read_as(&short, ColorTransformer::Rgb8).unwrap_err();
        assert_eq!(error, LayoutError::Size { actual: 39, width: 1, height: 2, point_step: 20 });
        let mut outside = good.clone();
        outside.fields[3].offset = 17;
        let error = read_as(&outside, ColorTransformer::Rgb8).unwrap_err();
        assert!(error.to_string().starts_with("Channel rgb at offset 17 reaches past point_step (20)"), "{error}");
        let mut flat = good.clone();
        flat.fields.remove(2);
        assert_eq!(read_as(&flat, ColorTransformer::Rgb8).unwrap_err(), LayoutError::NoPosition("z"));
        let mut double = good;
        double.fields[0].datatype = PointField::FLOAT64;
        assert!(matches!(read_as(&double, ColorTransformer::Rgb8), Err(LayoutError::PositionType { name: "x", .. })));
    }

    #[test]
    fn a_transformer_that_does_not_fit_gives_way_to_one_that_does() {
        let colored = cloud(&[([0.0; 3], 0), ([1.0; 3], 0)]);
        let layout = CloudLayout::of(&colored).unwrap();
        assert_eq!(layout.fitting_transformer(Some(ColorTransformer::Rgbf32)), ColorTransformer::Rgb8);
        assert_eq!(layout.fitting_transformer(Some(ColorTransformer::FlatColor)), ColorTransformer::FlatColor);
        let mut plain = colored;
        plain.fields.pop();
        let layout = CloudLayout::of(&plain).unwrap();
        assert_eq!(layout.fitting_transformer(Some(ColorTransformer::Mono8)), ColorTransformer::Intensity);
        assert_eq!(layout.fitting_transformer(None), ColorTransformer::Intensity);
    }

    proptest! {
        #[test]
        fn no_cloud_makes_it_panic(
            size in prop::array::uniform3(0_u32..40),
            offsets in prop::array::uniform4(prop_oneof![0_u32..40, Just(u32::MAX)]),
            datatypes in prop::array::uniform4(0_u8..10),
            is_bigendian: bool,
            data in prop::collection::vec(any::<u8>(), 0..2000),
            fits: bool,
        ) {
            let [width, height, point_step] = size;
            let mut cloud = PointCloud2::default();
            (cloud.width, cloud.height, cloud.point_step) = (width, height, point_step);
            cloud.is_bigendian = is_bigendian;
            cloud.fields = ["x", "y", "z", "rgba"]
                .iter()
                .zip(offsets)
                .zip(datatypes)
                .map(|((name, offset), datatype)| field(name, offset, datatype))
                .collect();
            let len = if fits { (width * height * point_step) as usize } else { data.len() };
            cloud.set_data(data.into_iter().cycle().take(len).collect());
            for transformer in [
                ColorTransformer::Rgb8,
                ColorTransformer::Mono8,
                ColorTransformer::Intensity,
                ColorTransformer::AxisColor,
            ] {
                if let Ok(buffer) = read_as(&cloud, transformer) {
                    prop_assert!(buffer.positions.iter().flatten().all(|value| value.is_finite()));
                    if let PointColors::PerPoint(colors) = &buffer.colors {
                        prop_assert_eq!(colors.len(), buffer.positions.len());
                    }
                }
            }
        }
    }
}
