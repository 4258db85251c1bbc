//! Light in simulated rooms while arms reach into them and objects are taken away: where it is dark and where not.
//!
//! A few rooms; 100 with `MANY_SEEDS=1`. `-- --nocapture` prints the figures of each, and
//! `-- --ignored` draws a room: `ROOM=17 cargo test --release -p rcs_confirm --test rooms -- --ignored`.
#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test without its room fails")]

mod world;

use std::time::Duration;

use rcs_confirm::{ConfirmSettings, Confirmation, Confirmer};
use rcs_scan_simulator::{has_many_seeds, seeds, Arm, View};
use world::{tolerance_m, World};

/// Distance between sampled pixels along rows and columns.
const STEP_PX: usize = 3;
/// Largest share of right and observed light that may be dark by what each depth image alone shows.
const BY_ONE_IMAGE: f64 = 0.01;
/// Largest share of right and observed light that may be dark, with the light that is held back after a flip.
const WITH_HOLD_TIMES: f64 = 0.01;
/// Depth images before something happens.
const STILL: u32 = 13;
/// Time between two depth images.
const FRAME: Duration = Duration::from_micros(33_333);

/// Pixels, and how many of them are dark.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    all: usize,
    dark: usize,
}

impl Tally {
    fn add(&mut self, is_dark: bool) {
        self.all += 1;
        self.dark += usize::from(is_dark);
    }

    fn share(self) -> f64 {
        self.dark as f64 / self.all.max(1) as f64
    }
}

impl std::fmt::Display for Tally {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(to, "{} px, {:.2} % dark", self.all, 100.0 * self.share())
    }
}

/// Ray-cast classification of a pixel's light.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Truth {
    /// It meets its object, which the depth images measure there; the depth camera sees its whole way.
    Observed,
    /// It meets its object, but the depth camera does not see it or its way.
    Unobserved,
    /// It would hit something nearer than its object.
    OnObstacle,
    /// Its object is not there any more.
    Gone,
    /// Within the tolerance.
    Undecided,
}

fn truth(world: &World, view: &View, images: &[Vec<f32>], pixel: usize) -> Truth {
    let (object, now) = (f64::from(world.objects[pixel]), world.depth(view.room(), pixel));
    if (now - object).abs() < 1e-4 {
        let is_observed = world.is_observed(images, pixel, now) && world.is_way_seen(view, pixel, now);
        return if is_observed { Truth::Observed } else { Truth::Unobserved };
    }
    match now - object {
        nearer if nearer < -tolerance_m(object) => Truth::OnObstacle,
        // On what is there instead, the tolerance is as wide as the angle makes it.
        farther if farther > tolerance_m(object) * world.widening(view.room(), pixel) => Truth::Gone,
        _ => Truth::Undecided,
    }
}

/// `true` if a pixel at most 4 pixels away lights an obstacle.
fn is_in_margin(world: &World, view: &View, pixel: usize) -> bool {
    let [width, height] = world.size_px().map(|side| side as usize);
    let around = [-4, -2, 0, 2, 4_isize].map(|down| [-4, -2, 0, 2, 4_isize].map(|right| (down, right)));
    around.as_flattened().iter().any(|(down, right)| {
        let row = (pixel / width).checked_add_signed(*down).filter(|row| *row < height);
        let column = (pixel % width).checked_add_signed(*right).filter(|column| *column < width);
        row.zip(column).is_some_and(|(row, column)| {
            let pixel = row * width + column;
            let object = f64::from(world.objects[pixel]);
            world.depth(view.room(), pixel) < object - tolerance_m(object)
        })
    })
}

fn sampled([width, height]: [u32; 2]) -> impl Iterator<Item = usize> {
    let [width, height] = [width as usize, height as usize];
    (0..height)
        .step_by(STEP_PX)
        .flat_map(move |row| (0..width).step_by(STEP_PX).map(move |column| row * width + column))
}

/// Figures of a room.
#[derive(Clone, Copy, Debug, Default)]
struct Figures {
    on_obstacle: Tally,
    /// Farther than the margin from light on an obstacle.
    observed: Tally,
    /// As observed, but dark, and within the margin of light on an obstacle.
    margin: Tally,
    unobserved: Tally,
    gone: Tally,
}

impl Figures {
    /// Adds an image's pixels. A pixel is observed if all of the depth images measure its surface.
    fn add(&mut self, world: &World, view: &View, images: &[Vec<f32>], confirmation: &Confirmation) {
        let mask = confirmation.mask.as_ref().unwrap();
        for pixel in sampled(world.size_px()) {
            let is_dark = mask.levels()[pixel] == 0;
            match truth(world, view, images, pixel) {
                Truth::Observed if is_dark && is_in_margin(world, view, pixel) => self.margin.add(is_dark),
                Truth::Observed => self.observed.add(is_dark),
                Truth::Unobserved => self.unobserved.add(is_dark),
                Truth::OnObstacle => self.on_obstacle.add(is_dark),
                Truth::Gone => self.gone.add(is_dark),
                Truth::Undecided => {}
            }
        }
    }
}

/// A confirmer that sees one depth image after another.
struct Stream<'a> {
    world: &'a World,
    confirmer: Confirmer,
    images: Vec<Vec<f32>>,
}

impl<'a> Stream<'a> {
    /// It has seen the room for a while.
    fn new(world: &'a World) -> Self {
        let mut stream = Self { world, confirmer: Confirmer::new(ConfirmSettings::default()), images: Vec::new() };
        let view = world.view(&world.room);
        world.stream(&view, 0, STILL).into_iter().for_each(|depths_m| {
            stream.show(depths_m);
        });
        stream
    }

    fn show(&mut self, depths_m: Vec<f32>) -> Confirmation {
        self.images.push(depths_m);
        let count = self.images.len();
        self.world.confirm(&mut self.confirmer, &self.images[count - 1], FRAME * count as u32)
    }
}

/// Confirmation by a single depth image, which is shown until no light is held back.
fn by_one_image(world: &World, depths_m: &[f32]) -> Confirmation {
    let mut confirmer = Confirmer::new(ConfirmSettings::default());
    let mut at = |ms| world.confirm(&mut confirmer, depths_m, Duration::from_millis(ms));
    (at(0), at(200), at(400)).2
}

/// Figures of a room while an arm reaches into it in three steps, each with the first depth image that shows it and two
/// more: as the node does it, and by each depth image alone.
fn with_an_arm(seed: u64, mut draw: impl FnMut(&World, &View, &[Vec<f32>], &Confirmation)) -> [Figures; 2] {
    let world = World::new(seed);
    let arm = Arm::reaching(&world.room, &world.rig, seed).expect("the projector lights something");
    let mut figures = [Figures::default(); 2];
    let mut stream = Stream::new(&world);
    for step in 0..3 {
        let view = world.view(&arm.moved(f64::from(step) - 2.0).within(&world.room));
        for (image, depths_m) in world.stream(&view, STILL + 3 * step, 3).into_iter().enumerate() {
            let confirmation = stream.show(depths_m);
            if image == 1 {
                continue;
            }
            // Light is held back for longer where it flipped: observed is what all images have shown.
            let images = &stream.images[..];
            let newest = &images[images.len() - 1..];
            figures[0].add(&world, &view, images, &confirmation);
            figures[1].add(&world, &view, newest, &by_one_image(&world, &newest[0]));
            if step == 2 && image == 0 {
                draw(&world, &view, images, &confirmation);
            }
        }
    }
    figures
}

/// Light of the largest object after it was taken away, with the next depth image; its pixels only.
fn without_an_object(seed: u64) -> Tally {
    let world = World::new(seed);
    let lit = |object: usize| {
        let room = world.room.without(object);
        let is_its = |pixel: &usize| world.depth(&room, *pixel) > f64::from(world.objects[*pixel]) + 0.1;
        sampled(world.size_px()).step_by(17).filter(is_its).count()
    };
    let largest = (0..world.room.objects()).max_by_key(|object| lit(*object)).expect("there are objects");
    let view = world.view(&world.room.without(largest));
    let mut stream = Stream::new(&world);
    let confirmation = stream.show(world.stream(&view, STILL, 1).remove(0));
    let mut figures = Figures::default();
    figures.add(&world, &view, &stream.images, &confirmation);
    figures.gone
}

/// Prints the mean and the worst of the rooms.
fn print(what: &str, shares: &[(u64, f64)], is_worst_high: bool) {
    let mean = shares.iter().map(|(_, share)| share).sum::<f64>() / shares.len() as f64;
    let sign = if is_worst_high { 1.0 } else { -1.0 };
    let worst = shares.iter().max_by(|one, other| (sign * one.1).total_cmp(&(sign * other.1))).unwrap();
    println!("{what}: mean {:.2} %, worst {:.2} % (room {})", 100.0 * mean, 100.0 * worst.1, worst.0);
}

/// Prints the figures of rooms, by number; returns those of light on arms and of right light that is observed. Right
/// light in the margin is dark by the settings.
fn judge(what: &str, rooms: &[(u64, Figures)]) -> (Tally, Tally) {
    println!("{what}:");
    let shares = |tally: fn(&Figures) -> Tally| -> Vec<(u64, f64)> {
        rooms.iter().map(|(seed, figures)| (*seed, tally(figures).share())).collect()
    };
    for (seed, Figures { on_obstacle, observed, margin, unobserved, .. }) in rooms {
        let margin = margin.all;
        println!("room {seed}: arm {on_obstacle}; observed {observed}, margin {margin} px; unobserved {unobserved}");
    }
    let total = |tally: fn(&Figures) -> Tally| {
        let sum = |all: Tally, (_, figures): &(u64, Figures)| {
            let own = tally(figures);
            Tally { all: all.all + own.all, dark: all.dark + own.dark }
        };
        rooms.iter().fold(Tally::default(), sum)
    };
    print("light on arms that is dark", &shares(|room| room.on_obstacle), false);
    print("right light, observed, that is dark", &shares(|room| room.observed), true);
    print("right light, not observed, that is dark", &shares(|room| room.unobserved), true);
    let [on_obstacle, observed, margin, unobserved] = [
        total(|room| room.on_obstacle),
        total(|room| room.observed),
        total(|room| room.margin),
        total(|room| room.unobserved),
    ];
    println!("all pixels: arm {on_obstacle}; observed {observed}, margin {margin}; unobserved {unobserved}");
    (on_obstacle, observed)
}

#[test]
fn arms_stay_dark_and_what_is_observed_stays_lit() {
    let rooms: Vec<(u64, [Figures; 2])> =
        seeds(0, 3, 100).map(|seed| (seed, with_an_arm(seed, |_, _, _, _| {}))).collect();
    let judged = ["with hold times", "by each depth image alone"].into_iter().enumerate().map(|(index, what)| {
        let rooms: Vec<_> = rooms.iter().map(|(seed, figures)| (*seed, figures[index])).collect();
        judge(what, &rooms)
    });
    let limits = [WITH_HOLD_TIMES, BY_ONE_IMAGE];
    for ((on_obstacle, observed), limit) in judged.collect::<Vec<_>>().into_iter().zip(limits) {
        assert!(on_obstacle.share() >= 0.99, "{on_obstacle}");
        assert!(observed.share() <= limit, "{observed}");
    }
}

#[test]
fn an_object_that_is_taken_away_is_dark_with_the_next_depth_image() {
    let rooms: Vec<(u64, f64)> = seeds(0, 3, 100).map(|seed| (seed, without_an_object(seed).share())).collect();
    print("light of an object taken away that is dark", &rooms, false);
    assert!(rooms.iter().all(|(_, share)| *share >= 0.99), "{rooms:?}");
}

/// Half of the rooms have a still arm.
#[test]
fn in_a_still_room_no_pixel_is_lit_again_twice_within_10_s() {
    let (images, frame) = if has_many_seeds() { (330, FRAME) } else { (110, 3 * FRAME) };
    for seed in seeds(0, 2, 20) {
        let world = World::new(seed);
        let arm = Arm::reaching(&world.room, &world.rig, seed).filter(|_| seed % 2 == 1);
        let room = arm.map_or_else(|| world.room.clone(), |arm| arm.within(&world.room));
        let mut confirmer = Confirmer::new(ConfirmSettings::default());
        let mut before: Vec<u8> = Vec::new();
        let mut last_on = vec![None; world.objects.len()];
        let (mut relit, mut again) = (0, 0);
        for (index, depths_m) in world.stream(&world.view(&room), 0, images).iter().enumerate() {
            let now = frame * index as u32;
            let mask = world.confirm(&mut confirmer, depths_m, now).mask.unwrap();
            for ((last, level), before) in last_on.iter_mut().zip(mask.levels()).zip(&before) {
                if *before == 0 && *level == 255 {
                    relit += usize::from(last.is_some());
                    again += usize::from(last.is_some_and(|last| now - last < Duration::from_secs(10)));
                    *last = Some(now);
                }
            }
            before = mask.levels().to_vec();
        }
        println!("room {seed}: {relit} pixels lit again, {again} of them twice within 10 s");
        assert!(relit > 0 && again == 0, "room {seed}: {again}");
    }
}

/// Grey: right and lit. Blue: right, but not observed, and dark. Magenta: right, observed and dark. Green: dark where
/// it would hit the arm. Red: lit on the arm. Black: within the tolerance.
#[test]
#[ignore = "draws a room, for people"]
fn draw_a_room() {
    let seed = std::env::var("ROOM").ok().and_then(|seed| seed.parse().ok()).unwrap_or(0);
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("room_{seed}.png"));
    with_an_arm(seed, |world, view, images, confirmation| {
        let mask = confirmation.mask.as_ref().unwrap();
        let [width, height] = world.size_px();
        let image = image::RgbImage::from_fn(width, height, |column, row| {
            let pixel = (row * width + column) as usize;
            let is_dark = mask.levels()[pixel] == 0;
            let shade = (255.0 - 70.0 * world.objects[pixel]).clamp(40.0, 255.0) as u8;
            image::Rgb(match (truth(world, view, images, pixel), is_dark) {
                (Truth::Observed | Truth::Unobserved, false) => [shade; 3],
                (Truth::Observed, true) => [255, 0, 255],
                (Truth::Unobserved, true) => [30, 60, 200],
                (Truth::OnObstacle, true) => [0, 150, 0],
                (Truth::OnObstacle, false) => [255, 0, 0],
                (Truth::Gone | Truth::Undecided, _) => [0; 3],
            })
        });
        image.save(&path).unwrap();
    });
    println!("{}", path.display());
}
