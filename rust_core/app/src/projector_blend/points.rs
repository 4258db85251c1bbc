//! The points of a cloud message.

use nalgebra::Point3;
use rcs_messages::{NoPositions, PointCloud2};

/// The places of a cloud's points; those with numbers that are not finite are left out.
///
/// # Errors
/// Which field is missing, or that the data are too short.
pub fn points(cloud: &PointCloud2) -> Result<Vec<Point3<f64>>, NoPositions> {
    let places = cloud.positions()?.map(Point3::from);
    Ok(places.filter(|point| point.iter().all(|value| value.is_finite())).collect())
}

#[cfg(test)]
mod tests {
    use rcs_messages::sensor_msgs::PointField;

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
        assert_eq!(points(&short), Err(NoPositions::Short));
        let mut without_z = cloud();
        without_z.fields.pop();
        assert_eq!(points(&without_z), Err(NoPositions::Field("z")));
    }
}
