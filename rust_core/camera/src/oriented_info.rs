//! The CameraInfo of an image that is mirrored and turned by quarters, as a projector's mounting asks for.
//!
//! An image turned by quarters is what a camera sees that is turned about its optical axis. Its CameraInfo is in that
//! camera's optical frame: sizes, focal lengths and principal point change places, and all is positive as before.
//! Mirroring is no rotation: it makes a focal length negative in K and P. D is about coordinates before the focal
//! lengths and so knows no mirroring; its tangential and thin prism parts turn with the axes.

use nalgebra::{Matrix3, Matrix3x4, Matrix4, Rotation3};

use crate::CameraInfoFields;

/// Mirrors an image, left to right, and then turns it clockwise by quarters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuarterTurns {
    /// Left and right are swapped first.
    pub is_mirrored: bool,
    /// Clockwise turns by 90°.
    pub quarters: u32,
}

/// The fields of an oriented image's CameraInfo, see [`CameraInfoFields`]; the distortion model is that of the
/// original.
#[derive(Clone, Debug, PartialEq)]
pub struct OrientedInfo {
    /// Width and height, pixels.
    pub size_px: [u32; 2],
    /// The coefficients of the distortion.
    pub d: Vec<f64>,
    /// Intrinsics of the raw image, pixels, 3×3.
    pub k: [f64; 9],
    /// The rotation from the raw image's frame to that of P, 3×3.
    pub r: [f64; 9],
    /// The projection to the rectified image, pixels, 3×4.
    pub p: [f64; 12],
}

impl QuarterTurns {
    /// The rotation from the axes of the camera's optical frame to those of the turned image's.
    pub fn turned_from_optical(self) -> Rotation3<f64> {
        // By a quarter to the right: what points up points to the right then.
        let quarter = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        let axes = (0..self.quarters % 4).fold(Matrix3::identity(), |axes, _| quarter * axes);
        Rotation3::from_matrix_unchecked(axes)
    }

    /// The CameraInfo of the oriented image. Binning and region of interest do not count: the image is the whole one.
    pub fn info(self, info: &CameraInfoFields<'_>) -> OrientedInfo {
        let axes = self.turned_from_optical().into_inner();
        let pixels = self.turned_from_own_pixels(info);
        let size_px = [info.width_px, info.height_px];
        let [k, mut r] = [info.k, info.r].map(|rows| Matrix3::from_row_slice(rows));
        if info.r.iter().any(|number| *number != 0.0) {
            r = axes * r * axes.transpose();
        }
        let mut points = Matrix4::identity();
        points.fixed_view_mut::<3, 3>(0, 0).copy_from(&axes.transpose());
        let p = pixels * Matrix3x4::from_row_slice(info.p) * points;
        OrientedInfo {
            size_px: if self.quarters.is_multiple_of(2) { size_px } else { [size_px[1], size_px[0]] },
            d: self.distortion(info),
            k: rows(&(pixels * k * axes.transpose()).transpose()),
            r: rows(&r.transpose()),
            p: rows(&p.transpose()),
        }
    }

    /// From the pixels of the image to those of the oriented one; an integer is a pixel's centre.
    fn turned_from_own_pixels(self, info: &CameraInfoFields<'_>) -> Matrix3<f64> {
        let (mut last_column, mut last_row) = (f64::from(info.width_px) - 1.0, f64::from(info.height_px) - 1.0);
        let mut pixels = Matrix3::identity();
        if self.is_mirrored {
            pixels = Matrix3::new(-1.0, 0.0, last_column, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        }
        for _ in 0..self.quarters % 4 {
            pixels = Matrix3::new(0.0, -1.0, last_row, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0) * pixels;
            (last_column, last_row) = (last_row, last_column);
        }
        pixels
    }

    /// D with what of it depends on the axes turned: p1 and p2, and a thin prism's s1 to s4.
    fn distortion(self, info: &CameraInfoFields<'_>) -> Vec<f64> {
        let mut d = info.d.to_vec();
        if !matches!(info.distortion_model, "plumb_bob" | "rational_polynomial" | "") {
            return d;
        }
        for _ in 0..self.quarters % 4 {
            if let [_, _, p1, p2, ..] = &mut d[..] {
                (*p1, *p2) = (*p2, -*p1);
            }
            if let Some([s1, s2, s3, s4]) = d.get_mut(8..12) {
                (*s1, *s2, *s3, *s4) = (-*s3, -*s4, *s1, *s2);
            }
        }
        d
    }
}

/// The numbers of a transposed matrix's columns, which are the matrix's rows.
fn rows<const N: usize, const C: usize>(transposed: &nalgebra::SMatrix<f64, C, 3>) -> [f64; N] {
    transposed.as_slice().try_into().unwrap_or([0.0; N])
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector2, Vector4};
    use proptest::prelude::*;

    use super::*;
    use crate::lens_of;

    const R: &[f64; 9] = &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    const P: &[f64; 12] = &[1400.0, 0.0, 630.0, -70.0, 0.0, 1390.0, 780.0, 20.0, 0.0, 0.0, 1.0, 0.0];

    fn info<'a>(k: &'a [f64; 9], d: &'a [f64]) -> CameraInfoFields<'a> {
        let distortion_model = if d.len() == 8 { "rational_polynomial" } else { "plumb_bob" };
        let (width_px, height_px, binning, region_px) = (1280, 800, [0; 2], [0; 4]);
        CameraInfoFields { width_px, height_px, distortion_model, d, k, r: R, p: P, binning, region_px }
    }

    fn fields<'a>(oriented: &'a OrientedInfo, own: &CameraInfoFields<'a>) -> CameraInfoFields<'a> {
        let [width_px, height_px] = oriented.size_px;
        let OrientedInfo { d, k, r, p, .. } = oriented;
        CameraInfoFields { width_px, height_px, d, k, r, p, ..*own }
    }

    fn all() -> impl Iterator<Item = QuarterTurns> {
        (0..8).map(|which| QuarterTurns { is_mirrored: which >= 4, quarters: which % 4 })
    }

    /// Place of a pixel of the image in the oriented one.
    fn turned(turns: QuarterTurns, [u, v]: [f64; 2]) -> Vector2<f64> {
        let (width, height) = (1279.0, 799.0);
        let u = if turns.is_mirrored { width - u } else { u };
        match turns.quarters {
            1 => Vector2::new(height - v, u),
            2 => Vector2::new(width - u, height - v),
            3 => Vector2::new(v, width - u),
            _ => Vector2::new(u, v),
        }
    }

    fn by_p(p: &[f64; 12], point: &Point3<f64>) -> Vector2<f64> {
        let pixel = Matrix3x4::from_row_slice(p) * Vector4::new(point.x, point.y, point.z, 1.0);
        Vector2::new(pixel.x / pixel.z, pixel.y / pixel.z)
    }

    proptest! {
        /// P alone, and K with D, lead a point to its pixel in the oriented image.
        #[test]
        fn a_point_lands_where_it_is_in_the_oriented_image(
            x in -0.4..0.4, y in -0.5..0.1, z in 0.8..3.0, is_mirrored: bool, quarters in 0_u32..4, rational: bool,
        ) {
            let turns = QuarterTurns { is_mirrored, quarters };
            let d: &[f64] = if rational {
                &[-0.1, 0.02, 0.002, -0.001, 0.003, 0.01, -0.002, 0.001]
            } else {
                &[-0.12, 0.03, 0.001, -0.0015, 0.002]
            };
            let k = [1400.0, 0.0, 630.0, 0.0, 1390.0, 780.0, 0.0, 0.0, 1.0];
            let (own, point) = (info(&k, d), Point3::new(x * z, y * z, z));
            let after = turns.info(&own);
            let point_there = turns.turned_from_optical() * point;
            let expected = turned(turns, by_p(own.p, &point).into());
            prop_assert!((by_p(&after.p, &point_there) - expected).norm() < 1e-9, "{:?}", turns);
            // Focal lengths stand where they are looked for, and are positive unless the image is mirrored.
            prop_assert!(after.p[1].abs() + after.p[4].abs() + after.k[1].abs() + after.k[3].abs() < 1e-9);
            prop_assert_eq!(after.p[0] * after.p[5] > 0.0, !is_mirrored);
            let lens = lens_of(&own).unwrap();
            let Some(raw) = lens.project(&point) else { return Ok(()) };
            let there = lens_of(&fields(&after, &own)).unwrap().project(&point_there).unwrap();
            let off = (there.coords - turned(turns, [raw.x, raw.y])).norm();
            prop_assert!(off < 1e-6, "{:?}: {} {}", turns, there, raw);
        }
    }

    #[test]
    fn a_skewed_lens_is_one_in_each_orientation() {
        let k = [1400.0, 12.0, 630.0, 0.0, 1390.0, 780.0, 0.0, 0.0, 1.0];
        let own = info(&k, &[-0.12, 0.03, 0.001, -0.0015, 0.002]);
        let (lens, point) = (lens_of(&own).unwrap(), Point3::new(0.3, -0.4, 1.5));
        let raw = lens.project(&point).unwrap();
        for turns in all() {
            let after = turns.info(&own);
            let lens = lens_of(&fields(&after, &own)).unwrap();
            let there = lens.project(&(turns.turned_from_optical() * point)).unwrap();
            assert!((there.coords - turned(turns, raw.into())).norm() < 1e-6, "{turns:?}: {there} {raw}");
        }
    }
}
