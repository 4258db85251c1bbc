//! Organised grid of measured points, as a depth camera delivers it.

/// Organised grid of measured points: row by row, metres in the sensor's optical frame (x right, y down, z forward).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointGrid {
    /// Columns and rows.
    pub size_px: [u32; 2],
    /// A point for each pixel. A pixel with a NaN, or with z of 0 or less, is missing.
    pub points: Vec<[f32; 3]>,
}

impl PointGrid {
    /// Grid of a depth image: metres along the optical axis, 0 or NaN where missing. `rays` are the directions x/z and
    /// y/z of all pixels, which do not change with the image. Pixels without a ray are missing.
    ///
    /// ```
    /// use rcs_confirm::PointGrid;
    ///
    /// let grid = PointGrid::from_depths([2, 1], &[2.0, 0.0], &[[0.1, 0.2], [0.3, 0.2]]);
    /// assert_eq!(grid.points[0], [0.2, 0.4, 2.0]);
    /// assert!(grid.points[1][2].is_nan());
    /// ```
    pub fn from_depths(size_px: [u32; 2], depths_m: &[f32], rays: &[[f32; 2]]) -> Self {
        let count = size_px[0] as usize * size_px[1] as usize;
        let point = |(depth, [x, y]): (&f32, &[f32; 2])| {
            let z = if *depth > 0.0 { *depth } else { f32::NAN };
            [x * z, y * z, z]
        };
        let mut points: Vec<_> = depths_m.iter().zip(rays).take(count).map(point).collect();
        points.resize(count, [f32::NAN; 3]);
        Self { size_px, points }
    }
}
