//! Numbers of a cloud's points, one by one. Drawing reads them faster, in bulk.

use crate::sensor_msgs::PointField;
use crate::PointCloud2;

/// Why a cloud's numbers cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoPositions {
    /// No such field of 32-bit or 64-bit floats.
    #[error("the cloud has no field {0} of type float32 or float64")]
    Field(&'static str),
    /// The data are too short.
    #[error("the cloud's data are shorter than its size says")]
    Short,
}

/// Bytes of an element of a `sensor_msgs/PointField` datatype; 0 for an unknown one.
pub fn element_size(datatype: u8) -> usize {
    match datatype {
        PointField::INT8 | PointField::UINT8 => 1,
        PointField::INT16 | PointField::UINT16 => 2,
        PointField::INT32 | PointField::UINT32 | PointField::FLOAT32 => 4,
        PointField::FLOAT64 => 8,
        _ => 0,
    }
}

/// A number's place in a point's bytes.
#[derive(Clone, Copy, Debug)]
struct NumberField {
    offset: usize,
    is_double: bool,
}

impl PointCloud2 {
    /// x, y and z of each point, metres; not finite where a sensor measured nothing.
    ///
    /// # Errors
    /// [`NoPositions`], before the first point.
    pub fn positions(&self) -> Result<impl Iterator<Item = [f64; 3]> + '_, NoPositions> {
        self.numbers(["x", "y", "z"])
    }

    /// Numbers of these fields in each point. A `row_step` of 0, as some drivers send it, means rows without gaps.
    ///
    /// # Errors
    /// [`NoPositions`], before the first point.
    pub fn numbers<const N: usize>(
        &self,
        names: [&'static str; N],
    ) -> Result<impl Iterator<Item = [f64; N]> + '_, NoPositions> {
        let mut fields = [NumberField { offset: 0, is_double: false }; N];
        for (field, name) in fields.iter_mut().zip(names) {
            *field = self.coordinate(name)?;
        }
        let (width, height, step) = (self.width as usize, self.height as usize, self.point_step as usize);
        let row = width.checked_mul(step).ok_or(NoPositions::Short)?;
        let row_step = if self.row_step == 0 { row } else { self.row_step as usize };
        let before_last = height.saturating_sub(1).checked_mul(row_step).ok_or(NoPositions::Short)?;
        let is_empty = width == 0 || height == 0;
        let needed = before_last.checked_add(row).ok_or(NoPositions::Short)?;
        let ends = fields.map(|at| at.offset + if at.is_double { 8 } else { 4 });
        if !is_empty && (needed > self.data().len() || row_step < row || ends.iter().any(|end| *end > step)) {
            return Err(NoPositions::Short);
        }
        let height = if is_empty { 0 } else { height };
        let points = (0..height).flat_map(move |line| {
            let data = self.data().get(line * row_step..line * row_step + row).unwrap_or_default();
            data.chunks_exact(step.max(1))
        });
        Ok(points.map(move |point| fields.map(|at| self.number(point, at))))
    }

    fn coordinate(&self, name: &'static str) -> Result<NumberField, NoPositions> {
        let field = self.fields.iter().find(|field| field.name == name).ok_or(NoPositions::Field(name))?;
        let is_double = match field.datatype {
            PointField::FLOAT32 => false,
            PointField::FLOAT64 => true,
            _ => return Err(NoPositions::Field(name)),
        };
        Ok(NumberField { offset: field.offset as usize, is_double })
    }

    fn number(&self, point: &[u8], at: NumberField) -> f64 {
        let bytes = point.get(at.offset..).unwrap_or_default();
        if at.is_double {
            bytes.first_chunk().map_or(f64::NAN, |bytes| f64::from_le_bytes(*bytes))
        } else {
            bytes.first_chunk().map_or(f64::NAN, |bytes| f64::from(f32::from_le_bytes(*bytes)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn field(name: &str, offset: u32, datatype: u8) -> PointField {
        PointField { name: name.to_owned(), offset, datatype, count: 1 }
    }

    /// Two rows of two points with four bytes after each row.
    fn cloud(datatype: u8, is_bigendian: bool) -> PointCloud2 {
        let size = if datatype == PointField::FLOAT64 { 8 } else { 4 };
        let mut cloud = PointCloud2::default();
        (cloud.width, cloud.height, cloud.is_bigendian) = (2, 2, is_bigendian);
        (cloud.point_step, cloud.row_step) = (3 * size, 6 * size + 4);
        cloud.fields = vec![field("x", 0, datatype), field("y", size, datatype), field("z", 2 * size, datatype)];
        let mut data = Vec::new();
        for number in 0..12_u8 {
            let (single, double) = (f32::from(number), f64::from(number));
            match size {
                8 => data.extend(double.to_le_bytes()),
                _ => data.extend(single.to_le_bytes()),
            }
            if number == 5 || number == 11 {
                data.extend([0; 4]);
            }
        }
        cloud.with_data(data)
    }

    #[test]
    fn points_are_read_row_by_row_as_little_endian_whatever_the_flag_says() {
        for datatype in [PointField::FLOAT32, PointField::FLOAT64] {
            for is_bigendian in [false, true] {
                let points: Vec<[f64; 3]> = cloud(datatype, is_bigendian).positions().unwrap().collect();
                assert_eq!(points, [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0], [6.0, 7.0, 8.0], [9.0, 10.0, 11.0]]);
            }
        }
    }

    #[test]
    fn rows_without_gaps_may_have_no_row_step() {
        let mut cloud = cloud(PointField::FLOAT32, false);
        let data: Vec<u8> = cloud.data().chunks(28).flat_map(|row| row[..24].to_vec()).collect();
        cloud.row_step = 0;
        let cloud = cloud.with_data(data);
        assert_eq!(cloud.numbers(["z"]).unwrap().collect::<Vec<_>>(), [[2.0], [5.0], [8.0], [11.0]]);
        let short = cloud.clone().with_data(cloud.data()[1..].to_vec());
        assert_eq!(short.positions().map(Iterator::count), Err(NoPositions::Short));
    }

    #[test]
    fn what_has_no_places_is_an_error() {
        let error = |change: fn(&mut PointCloud2)| {
            let mut cloud = cloud(PointField::FLOAT32, false);
            change(&mut cloud);
            cloud.positions().map(Iterator::count)
        };
        assert_eq!(error(|cloud| cloud.fields.truncate(2)), Err(NoPositions::Field("z")));
        assert_eq!(error(|cloud| cloud.fields[0].datatype = PointField::INT32), Err(NoPositions::Field("x")));
        assert_eq!(error(|cloud| cloud.height = 3), Err(NoPositions::Short));
        assert_eq!(error(|cloud| cloud.fields[2].offset = 9), Err(NoPositions::Short));
        assert_eq!(error(|cloud| cloud.width = 0), Ok(0));
    }

    proptest! {
        #[test]
        fn no_size_makes_it_read_past_the_data(numbers: [u32; 5], offset: u32) {
            let mut cloud = cloud(PointField::FLOAT32, false);
            [cloud.width, cloud.height, cloud.point_step, cloud.row_step, _] = numbers;
            cloud.fields[1].offset = offset;
            let count = cloud.positions().map(|points| points.take(1000).count());
            prop_assert!(count.unwrap_or_default() <= cloud.data().len());
        }
    }
}
