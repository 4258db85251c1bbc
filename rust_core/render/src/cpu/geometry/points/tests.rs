//! The image of a cloud does not depend on the processor's instruction set, nor on whether its faces are drawn as
//! quadrangles or as triangles.

use std::sync::Arc;

use fearless_simd::Level;
use nalgebra::{Isometry3, Matrix4, Point3, Vector3};
use rcs_scene::{
    Camera, DisplayMask, Drawable, Encoding, Geometry, Image, Intrinsics, PointBuffer, PointColors, PointStyle, Points,
    RenderGroup, Scene,
};

use super::draw::draw_triangles;
use super::{draw, Cloud, PointScratch};
use crate::cpu::tile::band::{pack, BandBuffers};
use crate::cpu::tile::screen::{ObjectTransform, Screen, FARTHEST};
use crate::{CpuRenderer, Renderer, View};
use rcs_camera::simd_levels::levels;

/// Scattered points of many sizes on the image; some are behind the eye, at the near plane or off the image.
fn scattered() -> PointBuffer {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mut position = || {
        let z = -0.1 + 3.0 * next();
        [(next() - 0.5) * 2.0 * z, (next() - 0.5) * 2.0 * z, z]
    };
    let positions: Vec<[f32; 3]> = (0..3000).map(|_| position()).collect();
    let colors = (0..3000_u32).map(|i| (i.wrapping_mul(0x9e37_79b9) | 0x8000_0000).to_le_bytes()).collect();
    PointBuffer { positions, colors: PointColors::PerPoint(colors) }
}

#[test]
fn all_instruction_sets_draw_the_same_image() {
    let p = [300.0, 0.0, 160.0, 0.0, 0.0, 300.0, 120.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let pose = Isometry3::new(Vector3::new(0.05, -0.05, 0.0), Vector3::new(0.1, 0.2, 0.3));
    let camera = Camera::new(Intrinsics::from_p(320, 240, &p).unwrap(), &pose, 0.05);
    let buffer = Arc::new(scattered());
    let mut names = Vec::new();
    for style in [
        PointStyle::Points { diameter_px: 7.5 },
        PointStyle::FlatSquares { side_m: 0.02 },
        PointStyle::Squares { size_m: [0.03; 2] },
        PointStyle::Spheres { size_m: [0.02, 0.04] },
        PointStyle::Boxes { size_m: [0.01, 0.02, 0.03] },
        PointStyle::Tiles { size_m: [0.03, 0.02], normal: [0.0, 0.6, -0.8], up: [0.0, 0.8, 0.6] },
    ] {
        for blended in [false, true] {
            let points = Points { buffer: buffer.clone(), style, alpha: 0.7, blended, auto_size: false };
            let drawable = Drawable {
                display: 0,
                fixed_from_object: Matrix4::identity(),
                sort_point: Point3::origin(),
                group: RenderGroup::Main,
                geometry: Geometry::Points(points),
            };
            let scene = Scene { drawables: vec![drawable], light: None };
            let visible = DisplayMask::all();
            let (background, encoding) = ([9, 9, 9], Encoding::Rgba8);
            let view = View { scene: &scene, camera: &camera, visible: &visible, background, encoding };
            let images: Vec<(Level, Image)> = levels()
                .into_iter()
                .map(|level| {
                    let mut renderer = CpuRenderer::with_threads(1).with_simd_level(level);
                    let mut image = Image::default();
                    renderer.render(&view, &mut image).unwrap();
                    (level, image)
                })
                .collect();
            let (_, first) = &images[0];
            assert!(first.data.chunks(4).any(|pixel| pixel[0] != 9));
            for (level, image) in &images {
                let different = image.data.iter().zip(&first.data).filter(|(a, b)| a != b).count();
                assert_eq!(different, 0, "{style:?}, blended: {blended}, {level:?}");
            }
            names = images.iter().map(|(level, _)| format!("{level:?}")).collect();
        }
    }
    println!("{names:?}");
}

#[test]
fn faces_of_any_size_cover_the_pixels_of_their_triangles() {
    let p = [500.0, 0.0, 320.0, 0.0, 0.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let camera = Camera::new(Intrinsics::from_p(640, 480, &p).unwrap(), &Isometry3::identity(), 0.05);
    let screen = Screen::new(640, 480, 2);
    let object = Isometry3::new(Vector3::new(0.0, 0.0, 1.3), Vector3::new(0.5, -0.4, 0.7)).to_homogeneous();
    let view_from_object = camera.fixed_from_view().inverse().to_homogeneous() * object;
    let mut scratch = PointScratch::default();
    let (mut one_way, mut other_way) = (BandBuffers::default(), BandBuffers::default());
    // From 3 to 700 pixels, and of each size at several places.
    for number in 0..300_u16 {
        let at = |step: f32| (f32::from(number) * step).fract() - 0.5;
        let side_m = 0.008 * 233.0_f32.powf(f32::from(number) / 300.0);
        let position = [at(0.754_877), at(0.569_84), at(0.324_5) * 0.2];
        let buffer = Arc::new(PointBuffer { positions: vec![position], colors: PointColors::Uniform([200; 4]) });
        for style in [
            PointStyle::FlatSquares { side_m },
            PointStyle::Tiles { size_m: [side_m, side_m * 0.7], normal: [0.0, 0.6, -0.8], up: [0.0, 0.8, 0.6] },
            PointStyle::Boxes { size_m: [side_m * 0.5, side_m * 0.3, side_m * 0.2] },
        ] {
            let points = Points { buffer: buffer.clone(), style, alpha: 1.0, blended: false, auto_size: false };
            let transform = ObjectTransform::new(&camera, &view_from_object, None);
            let cloud = Cloud::new(&points, transform, camera.eye_in_object(&object));
            let (mut differ, mut apart) = (0, 0.0_f32);
            let (mut near, mut far) = (f32::MAX, f32::MIN);
            for index in 0..screen.bands() {
                let background = pack([1, 2, 3, 255]);
                let mut band = one_way.begin(&screen, index, background, false);
                draw(&cloud, (&[0], &[]), &screen, &mut scratch, &mut band);
                let mut other_band = other_way.begin(&screen, index, background, false);
                draw_triangles(&cloud, 0, &screen, &mut other_band);
                let is_covered = |pixel: &[u8; 4]| *pixel != [1, 2, 3, 255];
                for (row, other_row) in band.pixel_rows().zip(other_band.pixel_rows()) {
                    differ += row.iter().zip(other_row).filter(|(a, b)| is_covered(a) != is_covered(b)).count();
                }
                for (row, other_row) in band.depth_rows().zip(other_band.depth_rows()) {
                    let both = row.iter().zip(other_row).filter(|(a, b)| a.max(**b) < FARTHEST);
                    apart = both.map(|(a, b)| (a - b).abs()).fold(apart, f32::max);
                    let covered = || other_row.iter().copied().filter(|depth| *depth < FARTHEST);
                    (near, far) = (covered().fold(near, f32::min), covered().fold(far, f32::max));
                }
            }
            // A box's corner is the sum of its sides, which come in another order here and there: it may be snapped to
            // the next place.
            let may_differ = if matches!(style, PointStyle::Boxes { .. }) { 2 } else { 0 };
            assert!(differ <= may_differ, "{style:?} at {position:?}: {differ} pixels");
            // The quadrangle's plane goes through three of its corners, those of its triangles each through their own,
            // and corners are snapped to 1/256 pixel, which tilts the planes of narrow faces.
            let allowed = 8.0 + (far - near).max(0.0) * 0.02;
            assert!(apart <= allowed, "{style:?} at {position:?}: {apart} steps of depth, allowed are {allowed}");
        }
    }
}
