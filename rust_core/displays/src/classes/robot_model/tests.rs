//! A small robot in frames that come and go.

use super::*;
use crate::framework::test_world::{TestWorld, STL};
use rcs_scene::Lighting;

const ROBOT: &str = "<robot name='r'>
    <link name='a'><visual><geometry><box size='1 1 1'/></geometry>
      <material name='m'><color rgba='0 1 0 0.5'/></material></visual>
      <collision><geometry><sphere radius='1'/></geometry></collision></link>
    <link name='b'><visual><geometry><mesh filename='package://none/x.stl'/></geometry></visual>
      <visual><geometry><cylinder radius='1' length='1'/></geometry></visual></link>
    <joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint></robot>";

struct Bench {
    display: RobotModelDisplay,
    world: TestWorld,
}

impl Bench {
    fn new(settings: &RobotModelSettings) -> Self {
        let mut display = create(0, settings);
        let world = TestWorld::at(Time::from_secs_f64(10.0));
        display.take_parameter("robot_description", Some(&ROBOT.into()), &world.get());
        Self { display, world }
    }

    fn place(&mut self, child: &str, x: f64) {
        self.world.place(child, self.world.now, [x, 0.0, 0.0]);
    }

    fn update(&mut self) -> bool {
        self.display.update(&self.world.get())
    }

    fn status(&self, name: &str) -> (Level, String) {
        let status = self.display.statuses.iter().find(|(key, _)| *key == name).unwrap().1;
        (status.level, status.text.clone())
    }

    /// Of each drawable, where it is and its material's colour; none for the white of links without a place.
    fn shown(&self) -> Vec<(f64, Option<[f32; 4]>)> {
        let shown = self.display.drawables().iter().map(|drawable| {
            let Geometry::Mesh { material, .. } = &drawable.geometry else { panic!("{drawable:?}") };
            let color = match material.lighting {
                Lighting::Lit { diffuse, .. } => Some(diffuse.to_array()),
                Lighting::Unlit => None,
            };
            (drawable.fixed_from_object[(0, 3)], color)
        });
        shown.collect()
    }
}

const RED: Option<[f32; 4]> = Some([1.0, 0.0, 0.0, 1.0]);
const GREEN: Option<[f32; 4]> = Some([0.0, 1.0, 0.0, 0.5]);

#[test]
fn links_follow_their_frames_and_are_white_until_these_are_known() {
    let mut bench = Bench::new(&RobotModelSettings::default());
    bench.place("b", 2.0);
    assert!(bench.update());
    assert_eq!(bench.shown(), [(0.0, None), (2.0, RED)]);
    assert_eq!(bench.status("a"), (Level::Error, "No transform from [a] to [map]".to_owned()));
    assert_eq!(bench.status("b"), (Level::Ok, "Transform OK".to_owned()));
    assert!(!bench.update(), "nothing moved");
    bench.world.now = Time::from_secs_f64(11.0);
    bench.place("a", 1.0);
    assert!(bench.update());
    assert_eq!(bench.shown(), [(1.0, GREEN), (2.0, RED)]);
    assert_eq!(bench.status("a"), (Level::Ok, "Transform OK".to_owned()));
    bench.display.reset();
    bench.world.tree.clear();
    assert!(bench.update());
    assert_eq!(bench.shown(), [(1.0, None), (2.0, None)], "the robot stays where it was");
}

#[test]
fn a_missing_mesh_is_named_and_the_rest_is_drawn() {
    let bench = Bench::new(&RobotModelSettings::default());
    let (level, text) = bench.status("URDF");
    assert_eq!(level, Level::Error);
    let expected = "Errors loading geometries:\n• for link 'b':\nCould not load mesh resource 'package://none/x.stl'";
    assert!(text.starts_with(expected), "{text}");
}

#[test]
fn links_move_once_in_an_update_interval() {
    let mut bench = Bench::new(&RobotModelSettings { update_interval_secs: 0.5, ..RobotModelSettings::default() });
    bench.place("a", 0.0);
    bench.place("b", 0.0);
    bench.update();
    for (secs, x) in [(10.2, 0.0), (10.4, 0.0), (10.6, 10.6)] {
        bench.world.now = Time::from_secs_f64(secs);
        bench.place("a", secs);
        bench.update();
        assert_eq!(bench.shown()[0].0, x, "at {secs}");
    }
    assert_eq!(bench.display.next_change(), Some(Time::from_secs_f64(11.1)));
}

#[test]
fn links_appear_as_their_meshes_and_textures_are_loaded() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.stl"), STL).unwrap();
    image::RgbaImage::from_pixel(2, 2, image::Rgba([1, 2, 3, 255])).save(folder.path().join("t.png")).unwrap();
    let at = |file: &str| format!("file://{}/{file}", folder.path().display());
    let description = format!(
        "<robot name='r'><link name='a'><visual><geometry><mesh filename='{mesh}'/></geometry></visual></link>
         <link name='b'><visual><geometry><box size='1 1 1'/></geometry><material name='m'><texture filename='{image}'/>
         </material></visual></link><link name='c'><visual><geometry><sphere radius='1'/></geometry></visual></link>
         <joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>
         <joint name='k' type='fixed'><parent link='a'/><child link='c'/></joint></robot>",
        mesh = at("a.stl"),
        image = at("t.png"),
    );
    let mut world = TestWorld::at(Time::from_secs_f64(10.0));
    let gate = world.load_behind_gate(folder.path());
    for link in ["a", "b", "c"] {
        world.place_static(link, [0.0; 3]);
    }
    // Links that move once in an hour appear all the same.
    let settings = RobotModelSettings { update_interval_secs: 3600.0, ..RobotModelSettings::default() };
    let mut display = create(0, &settings);
    display.take_parameter("robot_description", Some(&description.into()), &world.get());
    assert!(display.update(&world.get()));
    assert_eq!(display.drawables().len(), 1, "the sphere");
    let status = |display: &RobotModelDisplay| display.statuses.get("URDF").unwrap().text.clone();
    assert_eq!(status(&display), "Loading geometries: 2 left");
    assert!(!display.update(&world.get()), "nothing new");
    let version = world.version();
    gate.open();
    world.wait_for_version(version + 2);
    assert!(display.update(&world.get()));
    assert_eq!(display.drawables().len(), 3);
    assert_eq!(status(&display), "URDF parsed OK");
    let is_textured = |drawable: &Drawable| matches!(&drawable.geometry, Geometry::Mesh { material, .. } if material.texture.is_some());
    assert_eq!(display.drawables().iter().filter(|drawable| is_textured(drawable)).count(), 1);
    assert!(!display.update(&world.get()), "nothing new");
}
