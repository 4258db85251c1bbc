//! The points of a cloud message.

use nalgebra::Point3;
use rcs_messages::sensor_msgs::PointField;
use rcs_messages::PointCloud2;

/// The places of a cloud's points; those with numbers that are not finite are left out.
///
/// # Errors
/// Which field is missing, or that the data are too short.
pub fn points(cloud: &PointCloud2) -> Result<Vec<Point3<f64>>, String> {
    let offsets = ["x", "y", "z"].map(|name| {
        let is_it = |field: &&PointField| field.name == name && field.datatype == PointField::FLOAT32;
        cloud.fields.iter().find(is_it).map(|field| field.offset as usize)
    });
    let [Some(x), Some(y), Some(z)] = offsets else {
        return Err("the cloud has no fields x, y and z of float32".to_owned());
    };
    let (step, row_step) = (cloud.point_step as usize, cloud.row_step as usize);
    let (width, height) = (cloud.width as usize, cloud.height as usize);
    let is_inside =
        [x, y, z].iter().all(|offset| offset + 4 <= step) && width.checked_mul(step).is_some_and(|row| row <= row_step);
    if !is_inside || row_step == 0 || height.checked_mul(row_step).is_none_or(|bytes| bytes > cloud.data().len()) {
        return Err("the cloud's data are shorter than its size says".to_owned());
    }
    let number = |point: &[u8], offset: usize| {
        let bytes = point.get(offset..).and_then(<[u8]>::first_chunk::<4>).copied().unwrap_or([0xff; 4]);
        f64::from(if cloud.is_bigendian { f32::from_be_bytes(bytes) } else { f32::from_le_bytes(bytes) })
    };
    let rows = cloud.data().chunks_exact(row_step).take(height);
    let all = rows.flat_map(|row| row.chunks_exact(step).take(width));
    let places = all.map(|point| Point3::new(number(point, x), number(point, y), number(point, z)));
    Ok(places.filter(|point| point.iter().all(|value| value.is_finite())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud() -> PointCloud2 {
        let field = |(name, offset): (&str, u32)| PointField {
            name: name.to_owned(),
            offset,
            datatype: PointField::FLOAT32,
            count: 1,
        };
        let mut cloud = PointCloud2::default();
        cloud.fields = [("x", 0), ("y", 4), ("z", 8)].map(field).to_vec();
        (cloud.width, cloud.height, cloud.point_step, cloud.row_step) = (2, 1, 12, 24);
        let values = [1.0_f32, 2.0, 3.0, f32::NAN, 0.0, 0.0];
        cloud.with_data(values.iter().flat_map(|value| value.to_le_bytes()).collect())
    }

    #[test]
    fn the_finite_points_of_a_cloud_are_read() {
        assert_eq!(points(&cloud()), Ok(vec![Point3::new(1.0, 2.0, 3.0)]));
        let mut short = cloud();
        short.height = 2;
        assert!(points(&short).unwrap_err().contains("shorter"));
        let mut without_z = cloud();
        without_z.fields.pop();
        assert!(points(&without_z).unwrap_err().contains("x, y and z"));
    }
}
