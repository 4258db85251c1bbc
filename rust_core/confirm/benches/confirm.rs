//! Time of a depth image of 640×480 pixels for a projector of 1280×800, on one core: from its points to the mask.
#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark without its scene measures nothing")]

#[path = "../tests/world/mod.rs"]
#[allow(dead_code, reason = "the tests use more of it")]
mod world;

use std::hint::black_box;
use std::time::Duration;

use criterion::{criterion_group, criterion_main, Criterion};
use rcs_confirm::{ConfirmSettings, Confirmer, ObjectDepths};
use rcs_scan_simulator::Arm;
use rcs_scene::{Camera, Intrinsics};
use world::World;

fn confirm(criterion: &mut Criterion) {
    let world = World::new(0);
    let room = Arm::reaching(&world.room, &world.rig, 0).expect("it is lit").within(&world.room);
    let grid = world.grid(&world.stream(&world.view(&room), 0, 1)[0]);
    let from_sensor = world.rig.projector_from_camera();
    let p = [1400.0, 0.0, 640.0, 0.0, 0.0, 1400.0, 400.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let intrinsics = Intrinsics::exactly(1280, 800, &p).expect("it is a camera").0;
    let straight = Camera::new(intrinsics, &nalgebra::Isometry3::identity(), 0.01);
    let mut confirmer = Confirmer::new(ConfirmSettings::default());
    let mut now = Duration::ZERO;
    for (lit, depths_m) in [("all of it lit", world.objects.clone()), ("a tenth of it lit", a_tenth(&world))] {
        let objects = ObjectDepths { size_px: world.size_px(), depths_m: &depths_m, is_strict: false };
        for (lens, camera) in [("straight", &straight), ("lens", &world.camera)] {
            criterion.bench_function(&format!("{lens}, {lit}"), |bencher| {
                bencher.iter(|| {
                    now += Duration::from_millis(33);
                    confirmer.observe(black_box(camera), &from_sensor, black_box(&grid), now);
                    black_box(confirmer.confirm(black_box(&objects)))
                });
            });
        }
    }
}

/// The scene's depths in a rectangle in each quarter of the image.
fn a_tenth(world: &World) -> Vec<f32> {
    let width = world.size_px()[0] as usize;
    let is_lit = |index: usize| index % width % 640 / 202 == 1 && index / width % 400 / 126 == 1;
    world.objects.iter().enumerate().map(|(index, depth)| if is_lit(index) { *depth } else { f32::NAN }).collect()
}

criterion_group!(benches, confirm);
criterion_main!(benches);
