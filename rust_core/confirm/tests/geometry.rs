//! The surface as seen from the projector, in scenes of a wall and a hand.
#![expect(clippy::unwrap_used, reason = "a test without its camera fails")]

use std::sync::Arc;
use std::time::Duration;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rcs_confirm::{ConfirmSettings, Confirmation, Confirmer, ObjectDepths, PointGrid, Unseen, HOLE_PX};
use rcs_scene::{Camera, Flip, Intrinsics, PixelMap};

const SIZE_PX: [u32; 2] = [321, 201];
const SENSOR_PX: [u32; 2] = [200, 150];
const SENSOR_FOCAL_PX: f64 = 170.0;
const FOCAL_PX: f64 = 400.0;

fn intrinsics() -> Intrinsics {
    let p = [FOCAL_PX, 0.0, 160.0, 0.0, 0.0, FOCAL_PX, 100.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    Intrinsics::exactly(SIZE_PX[0], SIZE_PX[1], &p).unwrap().0
}

fn camera() -> Camera {
    Camera::new(intrinsics(), &Isometry3::identity(), 0.01)
}

/// Rectangle in the projector's frame, parallel to its image: centre and half of its size, metres.
#[derive(Clone, Copy)]
struct Sheet {
    center: [f64; 3],
    half_m: [f64; 2],
}

const WALL: Sheet = Sheet { center: [0.0, 0.0, 2.0], half_m: [50.0, 50.0] };
const HAND: Sheet = Sheet { center: [0.0, 0.0, 1.0], half_m: [0.05, 0.05] };

fn beside(x: f64, y: f64, z: f64) -> Isometry3<f64> {
    Translation3::new(x, y, z).into()
}

/// Points that a sensor measures on sheets; they are parallel to its image, too.
fn measured(sheets: &[Sheet], projector_from_sensor: &Isometry3<f64>) -> PointGrid {
    let point = |index: u32| {
        let [u, v] = [index % SENSOR_PX[0], index / SENSOR_PX[0]].map(f64::from);
        let ray = Vector3::new((u - 99.5) / SENSOR_FOCAL_PX, (v - 74.5) / SENSOR_FOCAL_PX, 1.0);
        let hit = |sheet: &Sheet| {
            let center = projector_from_sensor.inverse_transform_point(&Point3::from(sheet.center));
            let at = ray * center.z;
            let is_hit = center.z > 0.0
                && (at.x - center.x).abs() < sheet.half_m[0]
                && (at.y - center.y).abs() < sheet.half_m[1];
            is_hit.then_some(center.z)
        };
        let z = sheets.iter().filter_map(hit).min_by(f64::total_cmp).unwrap_or(f64::NAN);
        [ray.x * z, ray.y * z, z].map(|value| value as f32)
    };
    PointGrid { size_px: SENSOR_PX, points: (0..SENSOR_PX[0] * SENSOR_PX[1]).map(point).collect() }
}

/// Light for objects of this depth everywhere.
fn light(confirmer: &mut Confirmer, object_m: f32) -> Confirmation {
    let depths_m = vec![object_m; SIZE_PX[0] as usize * SIZE_PX[1] as usize];
    confirmer.confirm(&ObjectDepths { size_px: SIZE_PX, depths_m: &depths_m, is_strict: false })
}

/// A confirmer that holds no light back: it saw the same depth image for 0.4 s, when nothing was lit.
fn observed(settings: ConfirmSettings, camera: &Camera, from_sensor: &Isometry3<f64>, grid: &PointGrid) -> Confirmer {
    let mut confirmer = Confirmer::new(settings);
    for at_ms in [0, 200, 400] {
        confirmer.observe(camera, from_sensor, grid, Duration::from_millis(at_ms));
        light(&mut confirmer, f32::NAN);
    }
    confirmer
}

fn confirmed(camera: &Camera, from_sensor: &Isometry3<f64>, grid: &PointGrid, object_m: f32) -> Confirmation {
    light(&mut observed(ConfirmSettings::default(), camera, from_sensor, grid), object_m)
}

fn is_lit(confirmation: &Confirmation, [u, v]: [f64; 2]) -> bool {
    confirmation.mask.as_ref().unwrap().levels()[v as usize * SIZE_PX[0] as usize + u as usize] == 255
}

/// Pixel of a point in the projector's frame, without lens.
fn pixel([x, y, z]: [f64; 3]) -> [f64; 2] {
    [160.5 + FOCAL_PX * x / z, 100.5 + FOCAL_PX * y / z]
}

/// Columns of the middle row that are dark.
fn dark_columns(confirmation: &Confirmation) -> Vec<u32> {
    (0..SIZE_PX[0]).filter(|column| !is_lit(confirmation, [f64::from(*column), 100.0])).collect()
}

#[test]
fn a_wall_at_its_place_is_lit_and_one_elsewhere_is_not() {
    let from_sensor = beside(0.2, 0.0, 0.0);
    let wall = measured(&[WALL], &from_sensor);
    for (object_m, expected) in [(2.0, 1.0), (2.04, 1.0), (1.96, 1.0), (2.06, 0.0), (1.94, 0.0)] {
        let shares = confirmed(&camera(), &from_sensor, &wall, object_m).shares;
        assert_eq!(shares.confirmed, expected, "{object_m}: {shares:?}");
        assert_eq!((shares.blocked == 1.0, shares.gone == 1.0), (object_m > 2.05, object_m < 1.95), "{shares:?}");
    }
}

#[test]
fn a_hand_before_the_object_is_dark_though_the_sensor_sees_it_beside_the_object() {
    for side in [-1.0, 1.0] {
        let from_sensor = beside(0.3 * side, 0.0, 0.0);
        let light = confirmed(&camera(), &from_sensor, &measured(&[WALL, HAND], &from_sensor), 2.0);
        // In the sensor's image the hand is 0.15 m, or 13 pixels of the depth image, beside the wall's middle.
        let [left, right] = [-0.05, 0.05].map(|x| pixel([x, 0.0, 1.0])[0]);
        let dark = dark_columns(&light);
        assert!((left as u32 - 4..=right as u32 + 4).all(|column| dark.contains(&column)), "{dark:?}");
        // What the hand hides from the sensor is as wide on the wall as the parallax: 60 pixels, on the far side.
        let hidden = FOCAL_PX * 0.3 * (1.0 / 1.0 - 1.0 / 2.0);
        let (first, last) = (f64::from(dark[0]), f64::from(*dark.last().unwrap()));
        let expected = if side > 0.0 { [left - hidden, right + 4.0] } else { [left - 4.0, right + hidden] };
        assert!((first - expected[0]).abs() < 6.0 && (last - expected[1]).abs() < 6.0, "{first} {last} {expected:?}");
        let shares = light.shares;
        assert!(shares.blocked > 0.015 && shares.unseen > 0.02 && shares.gone == 0.0, "{shares:?}");
    }
}

#[test]
fn an_object_behind_nothing_is_gone_and_one_behind_a_hand_is_blocked() {
    let from_sensor = beside(0.0, 0.15, 0.0);
    let grid = measured(&[WALL, HAND], &from_sensor);
    let blocked = confirmed(&camera(), &from_sensor, &grid, 2.0).shares;
    let gone = confirmed(&camera(), &from_sensor, &grid, 1.0).shares;
    assert!(blocked.blocked > 0.015 && blocked.gone == 0.0, "{blocked:?}");
    // The hand itself is confirmed.
    assert!(gone.gone > 0.9 && gone.confirmed > 0.015 && gone.blocked == 0.0, "{gone:?}");
}

#[test]
fn a_pencil_of_one_pixel_is_in_the_way() {
    // One pixel of the depth image is 6 mm wide at 1 m.
    let pencil = Sheet { center: [0.003, 0.0, 1.0], half_m: [0.003, 0.1] };
    let from_sensor = beside(0.0, 0.0, 0.0);
    let settings = ConfirmSettings { unseen: Unseen::Light, ..ConfirmSettings::default() };
    let grid = measured(&[WALL, pencil], &from_sensor);
    let light = light(&mut observed(settings, &camera(), &from_sensor, &grid), 2.0);
    for y in [-0.08, -0.04, 0.0, 0.04, 0.08] {
        assert!(!is_lit(&light, pixel([0.003, y, 1.0])), "{y}");
    }
    assert!(is_lit(&light, pixel([0.03, 0.0, 1.0])));
}

#[test]
fn a_table_at_a_grazing_angle_has_more_tolerance() {
    // A table 0.3 m below the projector: its rays meet it at a cosine of 0.3 / distance.
    let from_sensor = Isometry3::from_parts(
        Translation3::new(0.0, -0.5, 0.0),
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -0.35),
    );
    let point = |index: u32| {
        let [u, v] = [index % SENSOR_PX[0], index / SENSOR_PX[0]].map(f64::from);
        let ray = from_sensor.rotation * Vector3::new((u - 99.5) / 170.0, (v - 74.5) / 170.0, 1.0);
        let distance = (0.3 - from_sensor.translation.y) / ray.y;
        let at = from_sensor.inverse_transform_point(&Point3::from(from_sensor.translation.vector + ray * distance));
        if ray.y > 0.0 {
            [at.x as f32, at.y as f32, at.z as f32]
        } else {
            [f32::NAN; 3]
        }
    };
    let table = PointGrid { size_px: SENSOR_PX, points: (0..SENSOR_PX[0] * SENSOR_PX[1]).map(point).collect() };
    let depth_of_row = |row: u32| FOCAL_PX * 0.3 / (f64::from(row) + 0.5 - 100.5);
    // Depths that are off by a share of the tolerance, everywhere.
    let lit = |tolerances: f64, row: u32| {
        let mut confirmer = observed(ConfirmSettings::default(), &camera(), &from_sensor, &table);
        let depth = |row: u32| if row > 105 { depth_of_row(row) } else { f64::NAN };
        let depths_m: Vec<f32> = (0..SIZE_PX[0] * SIZE_PX[1])
            .map(|index| depth(index / SIZE_PX[0]))
            .map(|depth| (depth + tolerances * (0.03 + 0.01 * depth)) as f32)
            .collect();
        let objects = ObjectDepths { size_px: SIZE_PX, depths_m: &depths_m, is_strict: false };
        is_lit(&confirmer.confirm(&objects), [160.0, f64::from(row)])
    };
    // 1.5 m ahead, the cosine is 0.196, so that the tolerance is 5.1 times as wide.
    for (tolerances, expected) in [(0.0, true), (4.0, true), (-4.0, true), (7.0, false), (-7.0, false)] {
        assert_eq!(lit(tolerances, 180), expected, "off by {tolerances} tolerances");
    }
    // On a wall it is not.
    let wall = measured(&[WALL], &beside(0.2, 0.0, 0.0));
    assert_eq!(confirmed(&camera(), &beside(0.2, 0.0, 0.0), &wall, 2.1).shares.confirmed, 0.0);
}

#[test]
fn small_holes_are_closed_and_large_ones_are_unseen() {
    let from_sensor = beside(0.1, 0.0, 0.0);
    for (size, expected) in [(HOLE_PX, true), (HOLE_PX + 3, false)] {
        for is_long in [false, true] {
            let mut wall = measured(&[WALL], &from_sensor);
            // Across the middle: as high as the image if it is long, so that rows or columns alone close it.
            let rows = if is_long { 0..150 } else { 72..72 + size };
            for index in rows.flat_map(|v| (88..88 + size).map(move |u| v * 200 + u)) {
                wall.points[index] = [f32::NAN; 3];
            }
            let light = confirmed(&camera(), &from_sensor, &wall, 2.0);
            let center = wall_pixel_of_sensor(88.0 + size as f64 / 2.0 - 0.5, &from_sensor);
            assert_eq!(is_lit(&light, center), expected, "{size}, {is_long}");
            assert_eq!(light.shares.unseen == 0.0, expected, "{size}, {is_long}: {:?}", light.shares);
        }
    }
}

#[test]
fn a_hole_beside_a_hand_hides_nothing_that_is_measured() {
    // The sensor is below the projector and misses the wall right of the hand.
    let from_sensor = beside(0.0, 0.3, 0.0);
    let mut grid = measured(&[WALL, HAND], &from_sensor);
    for index in (14..34).flat_map(|v| (108..129).map(move |u| v * 200 + u)) {
        grid.points[index] = [f32::NAN; 3];
    }
    let light = confirmed(&camera(), &from_sensor, &grid, 2.0);
    // A straight line from the hand to the wall behind the hole would be before this part of the wall.
    for y in [-0.14, -0.12, -0.1] {
        assert!(is_lit(&light, pixel([0.224, y, 2.0])), "{y}");
    }
    // Behind the hole and behind the hand nothing is measured.
    assert!(!is_lit(&light, pixel([0.224, -0.3, 2.0])) && !is_lit(&light, pixel([0.0, -0.3, 2.0])));
}

/// Pixel of the projector at a place of the sensor's middle row on the wall.
fn wall_pixel_of_sensor(u: f64, from_sensor: &Isometry3<f64>) -> [f64; 2] {
    let at = from_sensor * Point3::new(2.0 * (u - 99.5) / SENSOR_FOCAL_PX, 0.0, 2.0);
    pixel([at.x, at.y, at.z])
}

/// A lens that moves the image's corners by 60 pixels.
fn strong_lens() -> (Camera, impl Fn([f64; 2]) -> [f64; 2]) {
    let bend = |[u, v]: [f64; 2], strength: f64| {
        let (x, y) = (u - 160.0, v - 100.0);
        let scale = 1.0 + strength * (x * x + y * y) / (160.0 * 160.0);
        [160.0 + x * scale, 100.0 + y * scale]
    };
    let map = PixelMap::new(SIZE_PX, |place| Some(bend(place, 0.25))).unwrap();
    let ([left, top], [width_px, height_px]) = (map.source_origin_px(), map.source_size_px());
    let drawn = intrinsics();
    let (cx_px, cy_px) = (drawn.cx_px - f64::from(left), drawn.cy_px - f64::from(top));
    let drawn = Intrinsics { width_px, height_px, cx_px, cy_px, ..drawn };
    let camera = Camera::new(drawn, &Isometry3::identity(), 0.01).with_lens(Arc::new(map));
    // Image pixel whose place in the drawn image is that of a pixel: by fixed-point iteration.
    let unbend = move |drawn: [f64; 2]| {
        (0..200).fold(drawn, |at, _| {
            let bent = bend(at, 0.25);
            [at[0] + 0.5 * (drawn[0] - bent[0]), at[1] + 0.5 * (drawn[1] - bent[1])]
        })
    };
    (camera, unbend)
}

#[test]
fn behind_a_strong_lens_a_hand_is_dark_where_the_light_meets_it() {
    let (camera, unbend) = strong_lens();
    let from_sensor = beside(0.2, 0.1, 0.0);
    let corner = Sheet { center: [-0.3, -0.18, 1.0], half_m: [0.05, 0.03] };
    let light = confirmed(&camera, &from_sensor, &measured(&[WALL, corner], &from_sensor), 2.0);
    let straight = pixel(corner.center);
    let bent = unbend([straight[0] - 0.5, straight[1] - 0.5]);
    assert!((bent[0] - straight[0]).hypot(bent[1] - straight[1]) > 15.0);
    assert!(!is_lit(&light, bent) && light.shares.blocked > 0.003, "{:?}", light.shares);
    for (x, y) in [(-0.05, 0.0), (0.05, 0.0), (0.0, -0.03), (0.0, 0.03)] {
        let [x, y] = [corner.center[0] + 0.8 * x, corner.center[1] + 0.8 * y];
        let [u, v] = pixel([x, y, 1.0]);
        assert!(!is_lit(&light, unbend([u - 0.5, v - 0.5])), "{x} {y}");
    }
    // Right of the hand, where the sensor sees the wall, and in the middle.
    let [u, v] = pixel([corner.center[0] + 0.09, corner.center[1], 1.0]);
    assert!(is_lit(&light, unbend([u - 0.5, v - 0.5])) && is_lit(&light, [160.0, 100.0]));
}

#[test]
fn a_flipped_image_has_a_flipped_mask() {
    let from_sensor = beside(0.2, 0.0, 0.0);
    let hand = Sheet { center: [0.15, -0.1, 1.0], ..HAND };
    let grid = measured(&[WALL, hand], &from_sensor);
    let straight = confirmed(&camera(), &from_sensor, &grid, 2.0);
    for flip in [[true, false], [false, true], [true, true]] {
        let flip = Flip { is_left_right: flip[0], is_up_down: flip[1] };
        let flipped = confirmed(&camera().with_flip(flip), &from_sensor, &grid, 2.0);
        // Cells begin at the other edge: a pixel more or less at boundaries.
        let mut differing = 0;
        for (v, u) in (0..SIZE_PX[1]).flat_map(|v| (0..SIZE_PX[0]).map(move |u| (v, u))) {
            let place = [u, v].map(f64::from);
            differing += usize::from(is_lit(&straight, place) != is_lit(&flipped, flip.pixel(SIZE_PX, place)));
        }
        assert!(differing < 400, "{flip:?}: {differing}");
        let [u, v] = flip.pixel(SIZE_PX, pixel(hand.center).map(|place| place - 0.5));
        assert!(!is_lit(&flipped, [u, v]) && (flipped.shares.blocked - straight.shares.blocked).abs() < 0.002);
    }
}

#[test]
fn a_sensor_behind_the_projector_and_one_turned_to_it_see_the_same_wall() {
    for z in [-0.6, -0.2, 0.4] {
        let from_sensor = beside(0.2, -0.1, z);
        let light = confirmed(&camera(), &from_sensor, &measured(&[WALL, HAND], &from_sensor), 2.0);
        assert!(!is_lit(&light, pixel(HAND.center)) && light.shares.confirmed > 0.5, "{z}: {:?}", light.shares);
    }
}

#[test]
fn points_behind_the_projector_do_not_matter() {
    let from_sensor = beside(0.3, 0.0, -1.5);
    let person = Sheet { center: [0.6, 0.0, -0.5], half_m: [0.1, 0.3] };
    let without = confirmed(&camera(), &from_sensor, &measured(&[WALL], &from_sensor), 2.0);
    let with = confirmed(&camera(), &from_sensor, &measured(&[WALL, person], &from_sensor), 2.0);
    assert!(with.shares.confirmed > 0.99 && with.shares.blocked == 0.0, "{:?}", with.shares);
    assert_eq!(without.shares.confirmed, 1.0);
}

#[test]
fn without_points_everything_is_unseen_and_without_a_surface_everything_is_dark() {
    let nothing = PointGrid { size_px: SENSOR_PX, points: vec![[f32::NAN; 3]; 200 * 150] };
    let short = PointGrid { size_px: SENSOR_PX, points: Vec::new() };
    for unseen in [Unseen::Dark, Unseen::Light] {
        let settings = ConfirmSettings { unseen, ..ConfirmSettings::default() };
        assert!(!is_lit(&light(&mut Confirmer::new(settings), 2.0), [9.0, 9.0]), "no surface yet");
        let mut confirmer = observed(settings, &camera(), &Isometry3::identity(), &nothing);
        let unseen_light = light(&mut confirmer, 2.0);
        assert_eq!((is_lit(&unseen_light, [9.0, 9.0]), unseen_light.shares.unseen), (unseen == Unseen::Light, 1.0));
        confirmer.forget();
        let stale = light(&mut confirmer, 2.0);
        assert!(!is_lit(&stale, [9.0, 9.0]) && stale.shares.unseen == 1.0);
        confirmer.observe(&camera(), &Isometry3::identity(), &short, Duration::from_millis(600));
        assert!(!is_lit(&light(&mut confirmer, 2.0), [9.0, 9.0]), "a grid without its points");
    }
}

#[test]
fn pixels_without_an_object_are_left_alone_unless_it_is_strict() {
    let wall = measured(&[WALL], &Isometry3::identity());
    let settings = ConfirmSettings::default();
    for mut confirmer in [Confirmer::new(settings), observed(settings, &camera(), &Isometry3::identity(), &wall)] {
        let depths_m = vec![f32::NAN; SIZE_PX[0] as usize * SIZE_PX[1] as usize];
        for is_strict in [false, true] {
            let objects = ObjectDepths { size_px: SIZE_PX, depths_m: &depths_m, is_strict };
            let nothing = confirmer.confirm(&objects);
            let is_lit = nothing.mask.unwrap().levels().iter().all(|level| *level == if is_strict { 0 } else { 255 });
            assert!(is_lit && nothing.shares == rcs_confirm::Shares::default());
        }
    }
}

/// Whether a pixel for an object at 2 m is lit, at these times in ms, while a sensor sees `sheets_at` them.
fn lit_over_time(place: [f64; 2], times_ms: &[u64], sheets_at: impl Fn(u64) -> Vec<Sheet>) -> Vec<bool> {
    let from_sensor = beside(0.2, 0.0, 0.0);
    let mut confirmer = Confirmer::new(ConfirmSettings::default());
    let lit_at = |ms: &u64| {
        let grid = measured(&sheets_at(*ms), &from_sensor);
        confirmer.observe(&camera(), &from_sensor, &grid, Duration::from_millis(*ms));
        is_lit(&light(&mut confirmer, 2.0), place)
    };
    times_ms.iter().map(lit_at).collect()
}

#[test]
fn light_comes_on_after_the_start_and_comes_back_a_while_after_a_hand_has_left() {
    let times_ms: Vec<u64> = (0..=280).map(|image| 50 * image).collect();
    let sheets_at = |ms: u64| if ms == 12_000 { vec![WALL, HAND] } else { vec![WALL] };
    let lit = lit_over_time(pixel(HAND.center), &times_ms, sheets_at);
    let is_held_back = |ms: u64| ms < 350 || (12_000..12_400).contains(&ms);
    assert_eq!(lit, times_ms.iter().map(|ms| !is_held_back(*ms)).collect::<Vec<_>>());
}

#[test]
fn one_depth_image_after_a_gap_or_a_stale_surface_lights_nothing() {
    let from_sensor = beside(0.2, 0.0, 0.0);
    let wall = measured(&[WALL], &from_sensor);
    for is_forgotten in [false, true] {
        let mut confirmer = observed(ConfirmSettings::default(), &camera(), &from_sensor, &wall);
        assert!(is_lit(&light(&mut confirmer, 2.0), [9.0, 9.0]));
        if is_forgotten {
            confirmer.forget();
        }
        let begin_ms = if is_forgotten { 500 } else { 1900 };
        let lit_after = |ms: u64| {
            confirmer.observe(&camera(), &from_sensor, &wall, Duration::from_millis(begin_ms + ms));
            // Another frame is compared with the same depth image.
            [(); 2].map(|()| is_lit(&light(&mut confirmer, 2.0), [9.0, 9.0]))
        };
        assert_eq!([0, 200].map(lit_after), [[false; 2]; 2], "{is_forgotten}");
    }
}

#[test]
fn an_object_that_is_away_twice_for_a_moment_is_lit_again_after_2_s() {
    let farther = Sheet { center: [0.0, 0.0, 2.5], ..WALL };
    let sheets_at = |ms: u64| vec![if matches!(ms, 13_000..13_100 | 14_000..14_100) { farther } else { WALL }];
    let times_ms: Vec<u64> = (0..340).map(|image| image * 50).collect();
    let lit = lit_over_time([160.0, 100.0], &times_ms, sheets_at);
    let relit: Vec<u64> = (1..lit.len()).filter(|i| !lit[i - 1] && lit[*i]).map(|i| times_ms[i]).collect();
    assert!(matches!(relit[..], [350, 13_400..=13_500, 16_100..=16_200]), "{relit:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_grid_and_no_pose_is_too_strange(
        seed: u64,
        columns in 0..40_u32,
        rows in 0..30_u32,
        offset in prop::array::uniform3(-3.0..3.0),
        angle in -4.0..4.0,
    ) {
        let strange = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -1.0, 1e-9, 1e30, 0.5, 2.0, 2.01];
        let value = |index: u32| strange[(seed.rotate_left(index % 64) ^ u64::from(index)) as usize % strange.len()];
        let points = (0..columns * rows).map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2)]).collect();
        let turned = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle);
        let from_sensor = Isometry3::from_parts(Translation3::from(offset), turned);
        let grid = PointGrid { size_px: [columns, rows], points };
        for camera in [camera(), strong_lens().0] {
            let light = confirmed(&camera, &from_sensor, &grid, 2.0);
            prop_assert_eq!(light.mask.unwrap().size_px(), SIZE_PX);
        }
    }

    #[test]
    fn light_meets_the_same_surface_wherever_it_moves_between_two_depth_images(
        patches in prop::collection::vec((0..SIZE_PX[0], 0..SIZE_PX[1], 1..90_u32, 1..90_u32), 1..5),
        margin_px in 0..40_u32,
        is_bent: bool,
        flip: [bool; 2],
        offset in prop::array::uniform3(-0.3..0.3),
    ) {
        let flip = Flip { is_left_right: flip[0], is_up_down: flip[1] };
        let camera = if is_bent { strong_lens().0 } else { camera() }.with_flip(flip);
        let from_sensor = Isometry3::from_parts(Translation3::from(offset), UnitQuaternion::identity());
        let grid = measured(&[WALL, HAND, Sheet { center: [0.3, 0.1, 1.5], half_m: [0.1, 0.2] }], &from_sensor);
        let settings = ConfirmSettings { margin_px, ..ConfirmSettings::default() };
        let new = || observed(settings, &camera, &from_sensor, &grid);
        let mut moving = new();
        // Where light was before, and dark: it is held back there.
        let mut was_dark = vec![false; SIZE_PX[0] as usize * SIZE_PX[1] as usize];
        for (left, top, width, height) in patches {
            // Whole cells.
            let [columns, rows] = [[left, width], [top, height]].map(|[first, len]| first & !1..(first + len) & !1);
            let is_in = |index: u32| columns.contains(&(index % SIZE_PX[0])) && rows.contains(&(index / SIZE_PX[0]));
            let depth = |index: u32| if is_in(index) { 2.0 } else { f32::NAN };
            let depths_m: Vec<f32> = (0..SIZE_PX[0] * SIZE_PX[1]).map(depth).collect();
            let objects = ObjectDepths { size_px: SIZE_PX, depths_m: &depths_m, is_strict: true };
            let [moving, fresh] = [moving.confirm(&objects), new().confirm(&objects)];
            prop_assert_eq!(moving.shares, fresh.shares);
            let levels = fresh.mask.unwrap().levels().to_vec();
            let expected = levels.iter().zip(&was_dark).map(|(level, was_dark)| if *was_dark { 0 } else { *level });
            prop_assert!(expected.eq(moving.mask.unwrap().levels().iter().copied()));
            for ((was_dark, depth_m), level) in was_dark.iter_mut().zip(&depths_m).zip(levels) {
                *was_dark |= !depth_m.is_nan() && level == 0;
            }
        }
    }
}
