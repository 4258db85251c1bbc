//! Conversion of coordinates to float32, which rviz and most nodes need.

use rcs_messages::element_size;
use rcs_messages::sensor_msgs::PointField;

use super::{to_u32, PcdCloud};

/// Value of an element, little-endian; NaN for another number of bytes.
fn value(datatype: u8, bytes: &[u8]) -> f64 {
    match (datatype, bytes) {
        (PointField::INT8, &[a]) => f64::from(i8::from_le_bytes([a])),
        (PointField::UINT8, &[a]) => f64::from(a),
        (PointField::INT16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (PointField::UINT16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (PointField::INT32, &[a, b, c, d]) => f64::from(i32::from_le_bytes([a, b, c, d])),
        (PointField::UINT32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (PointField::FLOAT32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        (PointField::FLOAT64, &[a, b, c, d, e, f, g, h]) => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
        _ => f64::NAN,
    }
}

impl PcdCloud {
    /// Converts x, y and z to float32. Returns the largest rounding error in the file's unit; `None` if all are
    /// float32.
    ///
    /// ```
    /// use rcs_files::pcd::PcdCloud;
    /// use rcs_messages::sensor_msgs::PointField;
    ///
    /// let file = b"FIELDS x ring\nSIZE 8 1\nTYPE F U\nWIDTH 1\nHEIGHT 1\nDATA ascii\n0.5 7\n";
    /// let mut cloud = PcdCloud::parse(std::path::Path::new("one.pcd"), file)?;
    /// assert_eq!(cloud.coordinates_to_f32(), Some(0.0));
    /// assert_eq!(cloud.fields[0].datatype, PointField::FLOAT32);
    /// assert_eq!(cloud.data, [0, 0, 0, 0x3f, 7]);
    /// # Ok::<(), rcs_files::FileError>(())
    /// ```
    pub fn coordinates_to_f32(&mut self) -> Option<f64> {
        let is_converted = |field: &PointField| {
            ["x", "y", "z"].contains(&field.name.as_str()) && field.datatype != PointField::FLOAT32
        };
        if !self.fields.iter().any(is_converted) {
            return None;
        }
        let mut largest_change = 0.0_f64;
        let old_step = self.point_step_bytes.max(1) as usize;
        let mut data = Vec::with_capacity(self.data.len());
        for point in self.data.chunks_exact(old_step) {
            for field in &self.fields {
                let (start, size) = (field.offset as usize, element_size(field.datatype));
                let bytes = point.get(start..start + size * field.count as usize).unwrap_or_default();
                if !is_converted(field) {
                    data.extend_from_slice(bytes);
                    continue;
                }
                for element in bytes.chunks_exact(size) {
                    let exact = value(field.datatype, element);
                    let rounded = exact as f32;
                    self.is_dense &= rounded.is_finite();
                    largest_change = largest_change.max((f64::from(rounded) - exact).abs());
                    data.extend(rounded.to_le_bytes());
                }
            }
        }
        self.data = data;
        let mut offset = 0;
        for field in &mut self.fields {
            if is_converted(field) {
                field.datatype = PointField::FLOAT32;
            }
            field.offset = to_u32(offset);
            offset += element_size(field.datatype) * field.count as usize;
        }
        self.point_step_bytes = to_u32(offset);
        Some(largest_change)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn cloud(text: &str) -> PcdCloud {
        PcdCloud::parse(Path::new("cloud.pcd"), text.as_bytes()).unwrap()
    }

    #[test]
    fn doubles_and_integers_become_float32_and_other_fields_stay() {
        let mut cloud = cloud(
            "FIELDS x y _ z stamp id\nSIZE 8 2 1 8 8 2\nTYPE F I U I F U\nCOUNT 1 1 3 1 1 2\nWIDTH 2\nHEIGHT 1\n\
             DATA ascii\n1.5 -2 9 9 9 3 0.1 7 8\n4.1 5 9 9 9 -6 0.2 9 10\n",
        );
        let change = cloud.coordinates_to_f32().unwrap();
        assert!((change - (f64::from(4.1_f32) - 4.1).abs()).abs() < 1e-12, "{change}");
        let fields: Vec<_> = cloud.fields.iter().map(|f| (f.name.as_str(), f.datatype, f.offset, f.count)).collect();
        let float = PointField::FLOAT32;
        let rest = [("stamp", PointField::FLOAT64, 12, 1), ("id", PointField::UINT16, 20, 2)];
        assert_eq!(fields, [[("x", float, 0, 1), ("y", float, 4, 1), ("z", float, 8, 1)].as_slice(), &rest].concat());
        let point = |xyz: [f32; 3], stamp: f64, id: [u16; 2]| {
            [xyz.map(f32::to_le_bytes).concat(), stamp.to_le_bytes().to_vec(), id.map(u16::to_le_bytes).concat()]
                .concat()
        };
        assert_eq!(cloud.point_step_bytes, 24);
        assert_eq!(cloud.data, [point([1.5, -2.0, 3.0], 0.1, [7, 8]), point([4.1, 5.0, -6.0], 0.2, [9, 10])].concat());
    }

    #[test]
    fn float32_stays_as_it_is() {
        let mut float = cloud("FIELDS _ x y\nSIZE 1 4 4\nTYPE U F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n0 1 2\n");
        let before = float.clone();
        assert_eq!(float.coordinates_to_f32(), None);
        assert_eq!(float, before);
    }

    #[test]
    fn a_double_beyond_float32_makes_the_cloud_not_dense() {
        let mut cloud = cloud("FIELDS x\nSIZE 8\nTYPE F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1e300\n");
        assert!(cloud.is_dense);
        assert_eq!((cloud.coordinates_to_f32(), cloud.is_dense), (Some(f64::INFINITY), false));
    }
}
