//! Tests of masks, keep-out frames, shares and orientations of finished images.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rcs_scene::{Camera, Encoding, Flip, Intrinsics, PixelMap};

use super::*;

/// An image of these colours.
fn image(encoding: Encoding, [width, height]: [u32; 2], color: impl Fn(u32, u32) -> [u8; 3]) -> Image {
    let mut image = Image::default();
    image.reset(width, height, encoding);
    let step = image.step();
    for (y, row) in (0..height).zip(image.data.chunks_mut(step)) {
        let pixels: Vec<[u8; 4]> = (0..width).map(|x| color(x, y)).map(|[r, g, b]| [r, g, b, 255]).collect();
        encoding.write_row(&pixels, row);
    }
    image
}

fn applied(step: &PostProcess, image: &Image) -> Image {
    let mut altered = image.clone();
    step.apply(&mut altered, &mut Image::default());
    altered
}

fn colors(x: u32, y: u32) -> [u8; 3] {
    [(3 * x + 1) as u8, (5 * y + 1) as u8, (x * y % 251) as u8]
}

#[test]
fn without_anything_to_do_a_image_keeps_its_bytes() {
    let nothing = PostProcess::default();
    assert!(nothing.is_nothing());
    for encoding in Encoding::ALL {
        let before = image(encoding, [33, 7], colors);
        assert_eq!(applied(&nothing, &before), before);
    }
    assert!(!PostProcess { orientation: "180".parse().unwrap(), ..nothing }.is_nothing());
}

/// Where a pixel of the image goes, said in other words than the code's: mirrored first, then turned clockwise.
fn goes_to(text: &str, [width, height]: [u32; 2], [u, v]: [u32; 2]) -> [u32; 2] {
    let u = if text.starts_with("mirrored") { width - 1 - u } else { u };
    match text.trim_start_matches("mirrored").trim_start_matches('-') {
        "90" => [height - 1 - v, u],
        "180" => [width - 1 - u, height - 1 - v],
        "270" => [v, width - 1 - u],
        _ => [u, v],
    }
}

#[test]
fn every_orientation_puts_every_pixel_in_its_place_in_every_encoding() {
    for text in ["0", "90", "180", "270", "mirrored", "mirrored-90", "mirrored-180", "mirrored-270"] {
        let orientation: Orientation = text.parse().unwrap();
        assert_eq!(orientation.to_string(), text);
        let step = PostProcess { orientation, ..PostProcess::default() };
        for encoding in Encoding::ALL {
            for size in [[1, 1], [5, 1], [1, 9], [67, 34], [32, 64], [33, 95]] {
                let before = image(encoding, size, colors);
                let after = applied(&step, &before);
                assert_eq!([after.width_px, after.height_px], orientation.size_px(size));
                let cell = encoding.bytes_per_pixel();
                for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
                    let [u, v] = goes_to(text, size, [x, y]).map(|at| at as usize);
                    let from = y as usize * before.step() + x as usize * cell;
                    let to = v * after.step() + u * cell;
                    assert_eq!(
                        after.data[to..to + cell],
                        before.data[from..from + cell],
                        "{text} {encoding:?} {size:?}"
                    );
                }
            }
        }
    }
    for wrong in ["", "1", "45", "360", "-90", "mirror", "mirrored90", "mirrored-", "90-mirrored"] {
        assert!(wrong.parse::<Orientation>().is_err(), "{wrong}");
    }
}

#[test]
fn a_mask_takes_its_share_of_the_light_in_every_encoding_and_leaves_alpha() {
    let levels: Vec<u8> = (0..40 * 3).map(|i| [255, 0, 51, 128][i % 4]).collect();
    let mask = LightMask::new([40, 3], levels.clone()).unwrap();
    let step = PostProcess { masks: vec![Arc::new(mask)], ..PostProcess::default() };
    for encoding in Encoding::ALL {
        let after = applied(&step, &image(encoding, [40, 3], |_, _| [200, 100, 50]));
        let expected = image(encoding, [40, 3], |x, y| {
            let share = f64::from(levels[(y * 40 + x) as usize]) / 255.0;
            [200.0, 100.0, 50.0].map(|level| (level * share).round() as u8)
        });
        // Of 16 bits, the upper eight.
        let levels = |image: &Image| match encoding {
            Encoding::Mono16 => image.data.iter().skip(1).step_by(2).copied().collect(),
            _ => image.data.clone(),
        };
        for (after, expected) in levels(&after).iter().zip(&levels(&expected)) {
            assert!(after.abs_diff(*expected) <= 1, "{encoding:?}: {after} {expected}");
        }
        let dark = after.data.chunks(encoding.bytes_per_pixel()).skip(1).step_by(4);
        dark.for_each(|pixel| assert!(pixel.iter().take(3).all(|level| *level == 0), "{encoding:?}"));
        if encoding.bytes_per_pixel() == 4 {
            assert!(after.data.iter().skip(3).step_by(4).all(|alpha| *alpha == 255));
        }
    }
    assert!(LightMask::new([2, 2], vec![0; 3]).is_none() && LightMask::new([0, 2], Vec::new()).is_none());
}

proptest! {
    /// A pixel that lies on any dark pixel of a mask of another size is dark; one on none is as it was.
    #[test]
    fn a_mask_of_another_size_is_stretched_to_the_dark_side(
        (mask_width, mask_height) in (1_u32..40, 1_u32..40), (width, height) in (1_u32..40, 1_u32..40), seed in 0_u64..1000,
    ) {
        let dark = |i: u64| (i * 7919 + seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 61 == 0;
        let levels = (0..u64::from(mask_width * mask_height)).map(|i| if dark(i) { 0 } else { 255 }).collect();
        let step = PostProcess { masks: LightMask::new([mask_width, mask_height], levels).map(Arc::new).into_iter().collect(), ..PostProcess::default() };
        let after = applied(&step, &image(Encoding::Mono8, [width, height], |_, _| [9; 3]));
        for (at, level) in (0..).zip(&after.data) {
            let (x, y) = (at % width, at / width);
            // The pixels overlap where both begin before the other ends.
            let overlaps = |a: u32, side: u32, b: u32, other: u32| a * other < (b + 1) * side && b * side < (a + 1) * other;
            let columns = (0..mask_width).filter(|column| overlaps(x, width, *column, mask_width));
            let is_dark = columns.flat_map(|column| (0..mask_height).map(move |row| (column, row)))
                .filter(|(_, row)| overlaps(y, height, *row, mask_height))
                .any(|(column, row)| dark(u64::from(row * mask_width + column)));
            prop_assert_eq!(*level, if is_dark { 0 } else { 9 }, "({}, {})", x, y);
        }
    }
}

const SIZE: [u32; 2] = [96, 64];

/// How a camera differs from a pinhole.
#[derive(Clone, Copy, Debug, Default)]
struct Kind {
    is_bent: bool,
    skew_px: [f64; 2],
    flip: Flip,
}

impl Kind {
    /// Where the lens takes a pixel from.
    fn place([u, v]: [f64; 2]) -> Option<[f64; 2]> {
        let (x, y) = ((u - 45.0) / 70.0, (v - 70.0) / 72.0);
        let scale = 1.0 + 0.15 * (x * x + y * y);
        Some([45.0 + 70.0 * x * scale, 70.0 + 72.0 * y * scale])
    }

    /// A camera somewhere in the fixed frame.
    fn camera(self) -> Camera {
        let [s, t] = self.skew_px;
        let p = [70.0, s, 45.0, 0.0, t, 72.0, 70.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let pose = Isometry3::from_parts(
            Vector3::new(1.0, -2.0, 0.5).into(),
            UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0),
        );
        let (drawn, _) = Intrinsics::exactly(SIZE[0], SIZE[1], &p).unwrap();
        let camera = if self.is_bent {
            let map = PixelMap::new(SIZE, Self::place).unwrap();
            let ([width_px, height_px], [left, top]) = (map.source_size_px(), map.source_origin_px().map(f64::from));
            let drawn =
                Intrinsics { width_px, height_px, cx_px: drawn.cx_px - left, cy_px: drawn.cy_px - top, ..drawn };
            Camera::new(drawn, &pose, 0.01).with_lens(Arc::new(map))
        } else {
            Camera::new(drawn, &pose, 0.01)
        };
        camera.with_flip(self.flip)
    }

    /// How far a pixel's ray passes a point, in the fixed frame.
    fn distance(self, camera: &Camera, pixel: [f64; 2], point: &Point3<f64>) -> f64 {
        let pixel = self.flip.pixel(SIZE, pixel);
        let [u, v] = if self.is_bent { Self::place(pixel).unwrap() } else { pixel };
        let [s, t] = self.skew_px;
        let direction = nalgebra::Matrix2::new(70.0, s, t, 72.0).try_inverse().unwrap()
            * nalgebra::Vector2::new(u - 45.0, v - 70.0);
        let direction = Vector3::new(direction.x, -direction.y, -1.0).normalize();
        let in_view = camera.fixed_from_view().inverse_transform_point(point).coords;
        let along = in_view.dot(&direction).max(0.0);
        (in_view - along * direction).norm()
    }
}

fn kinds() -> impl Strategy<Value = Kind> {
    let skew = || prop_oneof![Just(0.0), -30.0..30.0];
    let skews = prop_oneof![Just([0.0; 2]).boxed(), [skew(), skew()].boxed()];
    (any::<bool>(), skews, any::<bool>(), any::<bool>()).prop_map(|(is_bent, skew_px, is_left_right, is_up_down)| {
        Kind { is_bent, skew_px, flip: Flip { is_left_right, is_up_down } }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(160))]
    /// No part of a pixel that lights a sphere is lit, and what is some pixels away from its silhouette is.
    #[test]
    fn no_light_falls_on_a_sphere(
        kind in kinds(), x in -2.0_f64..2.0, y in -2.0_f64..1.0, z in -1.0_f64..4.0, radius_m in 0.02_f64..0.6,
    ) {
        let camera = kind.camera();
        // The view frame's y points up and its z backwards.
        let center = camera.fixed_from_view().transform_point(&Point3::new(x, -y, -z));
        let keep_out = KeepOut::new(&camera, &[Sphere { center, radius_m }]);
        let step = PostProcess { keep_out, ..PostProcess::default() };
        let after = applied(&step, &image(Encoding::Mono8, SIZE, |_, _| [9; 3]));
        let from_lens = (x * x + y * y + z * z).sqrt();
        for (at, level) in (0..).zip(&after.data) {
            let pixel = [at % SIZE[0], at / SIZE[0]].map(f64::from);
            let corners = [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.0, 0.0]];
            let nearest = corners.map(|[du, dv]| kind.distance(&camera, [pixel[0] + du, pixel[1] + dv], &center))
                .into_iter().fold(f64::INFINITY, f64::min);
            if nearest <= radius_m {
                prop_assert_eq!(*level, 0, "{:?} lights the sphere", pixel);
            }
            // Six pixels more, at most, of up to 1/38 (skewed) or 1/70.
            let pixel_m = if kind.skew_px == [0.0; 2] { 1.0 / 70.0 } else { 1.0 / 38.0 };
            if nearest > radius_m + 6.0 * pixel_m * (from_lens + radius_m) && from_lens > 1.5 * radius_m {
                prop_assert_eq!(*level, 9, "{:?} is dark for nothing", pixel);
            }
        }
    }
}

#[test]
fn all_is_dark_where_the_lens_is_in_the_sphere_or_its_place_is_no_number() {
    let camera = Kind::default().camera();
    let eye = camera.eye();
    for center in [eye, eye + Vector3::new(0.1, 0.1, 0.1), Point3::new(f64::NAN, 0.0, 0.0)] {
        let step = PostProcess {
            keep_out: KeepOut::new(&camera, &[Sphere { center, radius_m: 0.2 }]),
            ..PostProcess::default()
        };
        let after = applied(&step, &image(Encoding::Rgb8, SIZE, |_, _| [9; 3]));
        assert!(after.data.iter().all(|level| *level == 0), "{center}");
    }
    assert_eq!(KeepOut::new(&camera, &[]), None);
}

#[test]
fn weights_scale_light_and_not_levels() {
    let weights = [65535, 32768, 0, 65535];
    let blend = Blend::new([4, 1], &weights, &[], 2.2).unwrap();
    let step = PostProcess { blend: Some(Arc::new(blend)), ..PostProcess::default() };
    let after = applied(&step, &image(Encoding::Mono8, [4, 1], |_, _| [200; 3]));
    // Half the light of 200 is the level 200 · 0.5^(1 / 2.2).
    assert_eq!(after.data, [200, 146, 0, 200]);
    let other_size = applied(&step, &image(Encoding::Mono8, [5, 1], |_, _| [200; 3]));
    assert_eq!(other_size.data, [0; 5], "weights of another picture are no weights");
}

#[test]
fn black_is_lifted_in_linear_light_and_white_stays_white() {
    let lift = 0.01_f64;
    let lifts = [0, (lift * 65535.0).round() as u16];
    let blend = Blend::new([2, 2], &[65535; 4], &[lifts[0], lifts[1], lifts[0], lifts[1]], 2.2).unwrap();
    let step = PostProcess { blend: Some(Arc::new(blend)), ..PostProcess::default() };
    for encoding in Encoding::ALL {
        for level in [0, 50, 255_u8] {
            let after = applied(&step, &image(encoding, [2, 2], |_, _| [level; 3]));
            let light = lift + (1.0 - lift) * (f64::from(level) / 255.0).powf(2.2);
            let lifted = (255.0 * light.powf(1.0 / 2.2)).round() as u8;
            assert_eq!(after, image(encoding, [2, 2], |x, _| [if x == 0 { level } else { lifted }; 3]), "{encoding:?}");
        }
    }
}

#[test]
fn weights_that_cannot_be_are_refused() {
    let refused =
        |size, weights: &[u16], lifts: &[u16], gamma| Blend::new(size, weights, lifts, gamma).unwrap_err().to_string();
    assert_eq!(refused([2, 2], &[0; 3], &[], 2.2), "3 weights for 4 pixels");
    assert_eq!(refused([2, 2], &[0; 4], &[0; 5], 2.2), "5 weights for 4 pixels");
    assert!(refused([1, 1], &[0], &[], 0.0).starts_with("a gamma of 0"));
    assert!(refused([1, 1], &[0], &[], f32::NAN).starts_with("a gamma of NaN"));
    assert!(refused([1, 1], &[0], &[65535], 2.2).starts_with("black is lifted by 100 %"));
}

#[test]
fn what_forbids_light_comes_after_what_adds_some_and_both_before_the_image_is_turned() {
    let blend = Blend::new([2, 1], &[65535; 2], &[655; 2], 2.2).unwrap();
    let mask = LightMask::new([2, 1], vec![0, 255]).unwrap();
    let (blend, mask) = (Some(Arc::new(blend)), Some(Arc::new(mask)));
    let step = PostProcess {
        blend,
        masks: mask.into_iter().collect(),
        orientation: "mirrored".parse().unwrap(),
        ..PostProcess::default()
    };
    let after = applied(&step, &image(Encoding::Mono8, [2, 1], |_, _| [0; 3]));
    assert!(after.data[0] > 20 && after.data[1] == 0, "{:?}", after.data);
}

#[test]
fn of_two_masks_the_darker_one_counts() {
    let mask = |levels: &[u8]| LightMask::new([4, 1], levels.to_vec()).map(Arc::new);
    let (painted_mask, mask) = (mask(&[0, 255, 255, 51]), mask(&[255, 0, 255, 102]));
    let step = PostProcess { painted_mask, masks: mask.into_iter().collect(), ..PostProcess::default() };
    assert!(!step.is_nothing());
    let after = applied(&step, &image(Encoding::Mono8, [4, 1], |_, _| [200; 3]));
    assert_eq!(after.data, [0, 0, 200, 40]);
}
