//! Which triangles of a small solid may be seen.
//!
//! A triangle turns its front or its back to the eye by the side of its plane that the eye is on. In coordinates before
//! the division by w, twice its area on the picture is the determinant of its corners' x, y and w, over the product of
//! their w; and that determinant is, by Cauchy and Binet, the scalar product of two vectors of four [`minors`]: those
//! of the corners, which a shape keeps for each triangle, and those of the matrix's rows for x, y and w, which stand
//! for the eye. So that takes sixteen triangles a few steps. It leaves open what rounding and snapping may turn round:
//! where the product is small, the snapped places decide, as they do for all where perspective is strong.

use fearless_simd::prelude::*;
use rcs_scene::CullMode;

use super::corners::InstanceScratch;
use super::reach::Footprint;
use super::shape::{minors, Shape};
use crate::cpu::paint::Surface;
use crate::cpu::raster::triangle;
use crate::cpu::tile::lanes::{WideF, WIDE};
use crate::cpu::tile::screen::Screen;

/// The eye, as a shape's triangles see it.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct Facing {
    /// Its scalar product with a triangle's plane is positive where the side is seen that is drawn: twice the area in
    /// pixels, times the w of each corner.
    eye: [f32; 4],
    /// Nothing is sure within this on either side of zero.
    unsure: f32,
}

impl Facing {
    /// Of a solid in the view, given its matrix to clip coordinates; `None` where its surface is drawn from both sides,
    /// or perspective is strong.
    pub(in crate::cpu) fn of(
        shape: &Shape,
        surface: &Surface,
        rows: &[[f32; 4]; 4],
        footprint: &Footprint,
        screen: &Screen,
    ) -> Option<Self> {
        const MOST_PERSPECTIVE: f32 = 1.4;
        // The picture's y points down: what runs counter-clockwise to the eye has a negative area.
        let sign = match surface.cull {
            CullMode::None => return None,
            CullMode::Back => 1.0,
            CullMode::Front => -1.0,
        };
        let [least_w, most_w] = footprint.w;
        if most_w > MOST_PERSPECTIVE * least_w {
            return None;
        }
        // A side of a triangle is no longer than its share of the box's, and a fifth for the perspective.
        let sides_px = 2.0 * shape.longest * (footprint.width_and_height_px + 2.0);
        let unsure_area = 4.0 * footprint.error_px * (sides_px + 1.0);
        let (half_width, half_height) = screen.half_size();
        let scale = sign * f64::from(half_width) * f64::from(half_height);
        let eye = minors([rows[0], rows[1], rows[3]].map(|row| row.map(f64::from))).map(|minor| (minor * scale) as f32);
        Some(Self { eye, unsure: unsure_area * most_w * most_w * most_w })
    }

    /// Of some triangles, given by their planes, a bit for each: whether it is sure to be seen from the side that is
    /// drawn, and from the other.
    #[inline(always)]
    fn sides<S: Simd>(&self, simd: S, planes: &[[f32; WIDE]; 4]) -> [u32; 2] {
        // Of the sum of four products, several times.
        const ROUNDING: f32 = 2e-6;
        let (mut towards, mut size) = (WideF::splat(simd, 0.0), WideF::splat(simd, 0.0));
        for (plane, eye) in planes.iter().zip(self.eye) {
            let product = WideF::load_array_ref(simd, plane) * eye;
            towards += product;
            size += product.abs();
        }
        let unsure = size * ROUNDING + self.unsure;
        [towards.simd_gt(unsure), (-towards).simd_gt(unsure)].map(|mask| mask.to_bitmask() as u32)
    }
}

/// Lists the triangles of a solid inside the view that may be seen, given where its vertices were placed.
///
/// Which they are looks random to a processor, so that there is nothing to predict here: each is written down, and the
/// next one over it unless it is kept.
#[inline(always)]
pub(in crate::cpu) fn sieve<S: Simd>(
    simd: S,
    shape: &Shape,
    surface: &Surface,
    facing: Option<&Facing>,
    scratch: &mut InstanceScratch,
) {
    let InstanceScratch { x, y, gaps, seen, .. } = scratch;
    let (x, y, gaps) = (x.as_slice(), y.as_slice(), gaps.as_slice());
    let count = shape.places.len();
    seen.clear();
    seen.resize(count + 1, 0);
    let [keeps_clockwise, keeps_other] = match surface.cull {
        CullMode::None => [true, true],
        CullMode::Back => [false, true],
        CullMode::Front => [true, false],
    };
    let mut kept = 0;
    for ((begin, all), planes) in (0..).step_by(WIDE).zip(shape.places.chunks(WIDE)).zip(&shape.planes) {
        let [shown, hidden] = facing.map_or([0; 2], |facing| facing.sides(simd, planes));
        let mut left = !hidden & ((1 << all.len()) - 1);
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            let Some(&places) = all.get(lane) else { continue };
            let [a, b, c] = places.map(|place| place as usize);
            let (Some(gap_a), Some(gap_b), Some(gap_c)) = (gaps.get(a), gaps.get(b), gaps.get(c)) else { continue };
            let differences = (gap_a ^ gap_b) | (gap_a ^ gap_c);
            let mut is_kept = (differences & 0xffff != 0) & (differences >> 16 != 0);
            // Of what is left here, most is sure to be seen.
            if is_kept && shown >> lane & 1 == 0 {
                let doubled_area = triangle::doubled_area_of([[x[a], y[a]], [x[b], y[b]], [x[c], y[c]]]);
                is_kept = (keeps_clockwise & (doubled_area > 0)) | (keeps_other & (doubled_area < 0));
            }
            if let Some(place) = seen.get_mut(kept) {
                *place = (begin + lane) as u32;
            }
            kept += usize::from(is_kept);
        }
    }
    seen.truncate(kept);
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use nalgebra::{Isometry3, Matrix4, Vector3};
    use proptest::prelude::*;
    use rcs_camera::simd_levels::levels;
    use rcs_scene::{Camera, Intrinsics, Material};

    use super::*;
    use crate::cpu::geometry::instances::corners::place_vertices;
    use crate::cpu::geometry::instances::reach::{place_box, Placement};
    use crate::cpu::geometry::instances::tests::ball;
    use crate::cpu::tile::screen::ObjectTransform;

    /// Of a solid's triangles how many there are, and of how many it is sure which side is seen; none where it is not
    /// in the view. What is sure must be so.
    fn sure(shape: &Shape, optical_from_solid: &Matrix4<f64>, cull: CullMode) -> Option<[usize; 2]> {
        let p = [300.0, 0.0, 150.0, 0.0, 0.0, 310.0, 100.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let camera = Camera::new(Intrinsics::from_p(301, 203, &p).unwrap(), &Isometry3::identity(), 0.01);
        let screen = Screen::new(301, 203, 1);
        let view_from_solid = camera.fixed_from_view().inverse().to_homogeneous() * optical_from_solid;
        let rows = ObjectTransform::clip_rows(&camera, &view_from_solid);
        let Placement::Inside(footprint) = place_box(&shape.bounds.unwrap(), &rows, &screen) else { return None };
        let surface = Surface { cull, ..Surface::of(&Material::unlit(false), None) };
        let facing = Facing::of(shape, &surface, &rows, &footprint, &screen);
        let mut scratch = InstanceScratch::default();
        dispatch!(screen.simd_level, simd => place_vertices(simd, shape, &rows, &screen, &mut scratch));
        let mut known = 0;
        for level in levels() {
            known = 0;
            for (number, places) in shape.places.iter().enumerate() {
                let Some(facing) = &facing else { continue };
                let [shown, hidden] = dispatch!(level, simd => facing.sides(simd, &shape.planes[number / WIDE]));
                let [shown, hidden] = [shown, hidden].map(|sides| sides >> (number % WIDE) & 1 == 1);
                let doubled_area = triangle::doubled_area_of(places.map(|place| scratch.place_of(place)));
                let is_drawn = if cull == CullMode::Back { doubled_area < 0 } else { doubled_area > 0 };
                assert!(!(shown && hidden), "{number}");
                assert!(!shown || is_drawn, "{number}: {doubled_area}");
                assert!(!hidden || !is_drawn, "{number}: {doubled_area}");
                known += usize::from(shown || hidden);
            }
        }
        Some([shape.places.len(), known])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn what_is_sure_of_a_side_is_so(
            kind in 0..3_usize,
            place in [-2.0..2.0_f64, -1.5..1.5, 0.3..6.0],
            turn in [-3.0..3.0_f64, -3.0..3.0, -3.0..3.0],
            scale in proptest::array::uniform3(prop_oneof![5 => 0.001..0.3_f64, 1 => -0.2..0.0_f64, 1 => Just(0.0)]),
            is_turned_round: bool,
        ) {
            let shape = Shape::new(&[ball(6, 12), ball(2, 4), ball(16, 30)][kind]);
            let pose = Isometry3::new(Vector3::from(place), Vector3::from(turn)).to_homogeneous();
            let optical_from_solid = pose * Matrix4::new_nonuniform_scaling(&Vector3::from(scale));
            let cull = if is_turned_round { CullMode::Front } else { CullMode::Back };
            sure(&shape, &optical_from_solid, cull);
        }
    }

    #[test]
    fn of_most_triangles_of_a_ball_it_is_sure_and_of_none_where_perspective_is_strong() {
        let shape = Shape::new(&ball(16, 30));
        let at = |distance_m: f64, diameter_m: f64| {
            Matrix4::new_translation(&Vector3::new(0.02, 0.01, distance_m)) * Matrix4::new_scaling(diameter_m)
        };
        let [all, known] = sure(&shape, &at(2.0, 0.3), CullMode::Back).unwrap();
        assert!(known * 10 > all * 8, "{known} of {all}");
        assert_eq!(sure(&shape, &at(0.6, 0.25), CullMode::Back).unwrap()[1], 0, "strong perspective");
    }
}
