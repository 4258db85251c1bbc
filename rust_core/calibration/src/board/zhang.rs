//! First camera lens and board poses, from the homographies of a plane (Zhang, "A flexible new technique for camera
//! calibration", 2000), with square pixels and the principal point in the middle.

use nalgebra::{Isometry3, Matrix3, Point2, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::homography::homography;
use super::BoardCorner;
use crate::Lens;

/// Focal length as a share of the width where the boards do not tell, since none is tilted.
const USUAL_FOCAL: f64 = 1.0;
/// Plausible focal lengths, as shares of the width.
const FOCALS: std::ops::RangeInclusive<f64> = 0.2..=20.0;

/// First lens of a camera.
pub(super) fn first_lens(views: &[&[BoardCorner]], size_px: [u32; 2]) -> Lens {
    let width = f64::from(size_px[0].max(size_px[1]));
    let middle = size_px.map(|side| 0.5 * (f64::from(side) - 1.0));
    // Equations s·w = -t for w = 1/f², of r1 · r2 = 0 and |r1| = |r2|.
    let (mut products, mut squares) = (0.0, 0.0);
    for corners in views {
        let (places, pixels): (Vec<_>, Vec<_>) = corners
            .iter()
            .map(|corner| {
                (place(corner), Point2::from((corner.pixel.coords - nalgebra::Vector2::from(middle)) / width))
            })
            .unzip();
        let Some(h) = homography(&places, &pixels) else { continue };
        let h = h / (h.column(0).norm() * h.column(1).norm()).sqrt();
        let (a, b) = (h.column(0), h.column(1));
        for (s, t) in [
            (a.x * b.x + a.y * b.y, a.z * b.z),
            (0.5 * (a.x * a.x + a.y * a.y - b.x * b.x - b.y * b.y), 0.5 * (a.z * a.z - b.z * b.z)),
        ] {
            products -= s * t;
            squares += s * s;
        }
    }
    let focal = (squares / products).sqrt();
    let focal = if FOCALS.contains(&focal) { focal } else { USUAL_FOCAL };
    Lens::pinhole(size_px, [focal * width; 2], middle)
}

/// First pose `camera_from_board` of a board by a camera's lens.
pub(super) fn first_pose(corners: &[BoardCorner], lens: &Lens, square_m: f64) -> Option<Isometry3<f64>> {
    let (places, rays): (Vec<_>, Vec<_>) =
        corners.iter().filter_map(|corner| Some((place(corner), lens.plane(corner.pixel)?))).unzip();
    let h = homography(&places, &rays)?;
    let scale = 2.0 / (h.column(0).norm() + h.column(1).norm());
    // The board lies in front of the camera.
    let h = h * (scale * h[(2, 2)].signum());
    let (first, second) = (h.column(0).into_owned(), h.column(1).into_owned());
    let near = Matrix3::from_columns(&[first, second, first.cross(&second)]);
    let svd = near.svd(true, true);
    let rotation = svd.u? * svd.v_t?;
    if rotation.determinant() <= 0.0 {
        return None;
    }
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    let shift: Vector3<f64> = h.column(2) * square_m;
    Some(Isometry3::from_parts(Translation3::from(shift), turn))
}

/// Place on the board in squares.
fn place(corner: &BoardCorner) -> Point2<f64> {
    Point2::from(corner.place.map(f64::from))
}
