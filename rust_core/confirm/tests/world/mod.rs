//! Simulated rooms with a projector and a depth camera, and what is true in them by ray casting.

use std::sync::Arc;
use std::time::Duration;

use nalgebra::{Isometry3, Point2, Point3, Vector3};
use rayon::prelude::*;
use rcs_confirm::{Confirmation, Confirmer, ObjectDepths, PointGrid};
use rcs_scan_simulator::{DepthCamera, Hit, Rig, Room, View};
use rcs_scene::{Camera, Intrinsics, PixelMap};

/// Share of the objects that a depth camera does not see.
const INFRARED_BLACK: f64 = 0.1;

/// A room as the scene describes it: the projector lights all of it.
pub(crate) struct World {
    pub(crate) rig: Rig,
    pub(crate) room: Room,
    pub(crate) camera: Camera,
    pub(crate) depth_camera: DepthCamera,
    /// Directions of the depth camera's pixels.
    sensor_rays: Vec<[f32; 2]>,
    /// Directions of the projector's pixels in the room, of depth 1.
    rays: Vec<Vector3<f64>>,
    /// Depths of the scene, for each pixel of the projector.
    pub(crate) objects: Vec<f32>,
}

/// The exact camera of a projector, as its CameraInfo would give it.
fn camera_of(rig: &Rig) -> Camera {
    let lens = &rig.projector;
    let [width_px, height_px] = lens.size_px;
    let ([fx_px, fy_px], [cx, cy]) = (<[f64; 2]>::from(lens.focal_px), [lens.center_px.x, lens.center_px.y]);
    let p = [fx_px, 0.0, cx, 0.0, 0.0, fy_px, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    let (intrinsics, _) = Intrinsics::exactly(width_px, height_px, &p).unwrap();
    let place = |pixel: [f64; 2]| {
        let plane = lens.plane(Point2::from(pixel))?;
        Some(intrinsics.place([plane.x, plane.y]).map(|place| place - 0.5))
    };
    let map = PixelMap::new(lens.size_px, place).unwrap();
    let [left, top] = map.source_origin_px();
    let [width_px, height_px] = map.source_size_px();
    let (cx_px, cy_px) = (intrinsics.cx_px - f64::from(left), intrinsics.cy_px - f64::from(top));
    let drawn = Intrinsics { width_px, height_px, cx_px, cy_px, ..intrinsics };
    Camera::new(drawn, &Isometry3::identity(), 0.01).with_lens(Arc::new(map))
}

fn pixels([width, height]: [u32; 2]) -> impl IndexedParallelIterator<Item = Point2<f64>> {
    let at = move |index: u32| Point2::new(f64::from(index % width), f64::from(index / width));
    (0..width * height).into_par_iter().map(at)
}

impl World {
    pub(crate) fn new(seed: u64) -> Self {
        let (rig, room) = (Rig::random(seed), Room::cluttered(seed).with_infrared_black(seed, INFRARED_BLACK));
        let (sensor, projector) = (&rig.camera, &rig.projector);
        let sensor_ray = |pixel| {
            let plane = sensor.plane(pixel).unwrap();
            [plane.x as f32, plane.y as f32]
        };
        let ray = |pixel| rig.room_from_projector * projector.plane(pixel).unwrap().coords.push(1.0);
        let mut world = Self {
            camera: camera_of(&rig),
            depth_camera: DepthCamera::kinect(seed),
            sensor_rays: pixels(sensor.size_px).map(sensor_ray).collect(),
            rays: pixels(projector.size_px).map(ray).collect(),
            objects: Vec::new(),
            rig,
            room,
        };
        world.objects =
            (0..world.rays.len()).into_par_iter().map(|pixel| world.depth(&world.room, pixel) as f32).collect();
        world
    }

    pub(crate) fn size_px(&self) -> [u32; 2] {
        self.rig.projector.size_px
    }

    /// Depth at which a pixel's light meets a room; NaN where it meets nothing.
    pub(crate) fn depth(&self, room: &Room, pixel: usize) -> f64 {
        let lamp = Point3::from(self.rig.room_from_projector.translation.vector);
        room.hit(&lamp, &self.rays[pixel]).map_or(f64::NAN, |hit| hit.distance)
    }

    /// Factor of the tolerance by the angle at which a pixel's light meets a room.
    pub(crate) fn widening(&self, room: &Room, pixel: usize) -> f64 {
        let lamp = Point3::from(self.rig.room_from_projector.translation.vector);
        let cosine = |hit: Hit| hit.normal.dot(&self.rays[pixel].normalize()).abs();
        room.hit(&lamp, &self.rays[pixel]).map(cosine).filter(|cosine| *cosine < 0.3).map_or(1.0, |cosine| 1.0 / cosine)
    }

    /// A room as an error-free depth camera sees it.
    pub(crate) fn view(&self, room: &Room) -> View {
        View::for_depth(room, &self.rig)
    }

    /// Depth images of a view, from a number on.
    pub(crate) fn stream(&self, view: &View, first: u32, count: u32) -> Vec<Vec<f32>> {
        self.depth_camera.stream(view, first, count)
    }

    pub(crate) fn grid(&self, depths_m: &[f32]) -> PointGrid {
        PointGrid::from_depths(self.rig.camera.size_px, depths_m, &self.sensor_rays)
    }

    /// Shows a depth image to a confirmer and asks for the light of the scene.
    pub(crate) fn confirm(&self, confirmer: &mut Confirmer, depths_m: &[f32], now: Duration) -> Confirmation {
        confirmer.observe(&self.camera, &self.rig.projector_from_camera(), &self.grid(depths_m), now);
        let objects = ObjectDepths { size_px: self.size_px(), depths_m: &self.objects, is_strict: false };
        confirmer.confirm(&objects)
    }

    /// `true` if the depth camera sees all of the way of a pixel's light, as far as it is in its image: light that goes
    /// behind something is unseen.
    pub(crate) fn is_way_seen(&self, view: &View, pixel: usize, depth_m: f64) -> bool {
        const SAMPLES: u32 = 64;
        let lamp = Point3::from(self.rig.room_from_projector.translation.vector);
        (1..SAMPLES).all(|sample| {
            let at = lamp + self.rays[pixel] * (depth_m * f64::from(sample) / f64::from(SAMPLES));
            let at = self.rig.room_from_camera.inverse_transform_point(&at);
            let seen = self.rig.camera.project(&at).filter(|seen| self.rig.camera.contains(*seen));
            let sight = seen.and_then(|seen| view.sight(seen.x.round() as u32, seen.y.round() as u32));
            sight.is_none_or(|sight| sight.point.z > at.z - tolerance_m(at.z))
        })
    }

    /// `true` if the four pixels around a lit point measure its surface in all of these depth images.
    pub(crate) fn is_observed(&self, images: &[Vec<f32>], pixel: usize, depth_m: f64) -> bool {
        let lamp = Point3::from(self.rig.room_from_projector.translation.vector);
        let point = self.rig.room_from_camera.inverse_transform_point(&(lamp + self.rays[pixel] * depth_m));
        let [width, height] = self.rig.camera.size_px.map(f64::from);
        let Some(seen) = self.rig.camera.project(&point) else { return false };
        if !(0.0..width - 1.0).contains(&seen.x) || !(0.0..height - 1.0).contains(&seen.y) {
            return false;
        }
        let first = seen.y as usize * width as usize + seen.x as usize;
        let around = [first, first + 1, first + width as usize, first + width as usize + 1];
        let is_near = |depth_m: f32| (f64::from(depth_m) - point.z).abs() <= tolerance_m(point.z);
        images.iter().all(|depths_m| around.iter().all(|index| is_near(depths_m[*index])))
    }
}

/// The tolerance of the settings' default.
pub(crate) fn tolerance_m(depth_m: f64) -> f64 {
    0.03 + 0.01 * depth_m
}
