//! View of the room by the camera, with the projector pixels that light it, by ray casting.
//!
//! The ray through a pixel's centre gives the ground truth. A pixel's light comes from 2×2 rays, each for a quarter of
//! its area, for soft edges and shadows. The quarter's extent over the projector's pixels counts as blur.

use nalgebra::{Isometry3, Point2, Point3, Vector2, Vector3};
use rayon::prelude::*;
use rcs_calibration::Lens;

use crate::{Hit, Rig, Room};

/// Rays per pixel.
pub(crate) const RAYS: usize = 4;
/// Margin of the projector's image that blur lights, pixels.
const MARGIN_PX: f64 = 10.0;
/// Relative light fall-off at the corner of the projector's image.
const VIGNETTING: f64 = 0.2;

/// Surface point at the centre of a camera pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Point in the camera's optical frame, metres.
    pub point: Point3<f64>,
    /// Unit normal in the camera's optical frame.
    pub normal: Vector3<f64>,
    /// Albedo.
    pub albedo: f64,
    /// Projector pixel that lights it; `None` in shadow and outside of the projector's image.
    pub lit_by: Option<Point2<f64>>,
    /// `true` if a depth camera does not see the surface.
    pub is_infrared_black: bool,
}

/// Ray of a pixel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Ray {
    /// Projector pixel that lights it, in the image or its margin.
    pub(crate) lit_by: [f32; 2],
    /// Depth in the projector's optical frame, metres.
    pub(crate) depth_m: f32,
    /// Radiance for a white pixel; 1 for a white surface 1 m before the centre of the projector's image, 0 if not lit.
    pub(crate) light: f32,
}

/// Camera pixel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Pixel {
    pub(crate) rays: [Ray; RAYS],
    /// Extent of a ray's quarter over the projector's u and v: standard deviation, pixels.
    pub(crate) extent_px: [f32; 2],
    /// Mean albedo.
    pub(crate) albedo: f32,
    /// Mean albedo times the share of ambient light, which comes from above.
    pub(crate) ambient: f32,
}

/// View of a room by a rig's camera.
#[derive(Debug, Clone)]
pub struct View {
    room: Room,
    rig: Rig,
    sights: Vec<Option<Sight>>,
    pixels: Vec<Pixel>,
}

impl View {
    /// Casts the rays.
    pub fn new(room: &Room, rig: &Rig) -> Self {
        let caster = Caster::new(room, rig);
        let [width, height] = rig.camera.size_px;
        let (count, rows) = (width as usize * height as usize, lattice(&rig.camera));
        let mut sights = vec![None; count];
        let mut pixels = vec![Pixel::default(); count];
        let columns = width as usize;
        sights.par_chunks_mut(columns).zip(pixels.par_chunks_mut(columns)).enumerate().for_each(
            |(v, (sights, pixels))| {
                for (u, (sight, pixel)) in sights.iter_mut().zip(pixels).enumerate() {
                    let at = |du: usize, dv: usize| rows[v + dv].get(u + du).copied().flatten();
                    let (Some(centre), Some(left), Some(right)) = (at(1, 1), at(0, 1), at(2, 1)) else { continue };
                    let (Some(up), Some(down)) = (at(1, 0), at(1, 2)) else { continue };
                    let steps = [0.5 * (right - left), 0.5 * (down - up)];
                    *sight = caster.sight(centre);
                    *pixel = caster.pixel(centre, steps, sight.as_ref());
                }
            },
        );
        Self { room: room.clone(), rig: rig.clone(), sights, pixels }
    }

    /// Casts only the rays through the pixels' centres: for depth images, not for a [`Scan`](crate::Scan).
    pub fn for_depth(room: &Room, rig: &Rig) -> Self {
        let caster = Caster::new(room, rig);
        let [width, height] = rig.camera.size_px;
        let rows = (0..height).into_par_iter();
        let pixels = rows.flat_map_iter(|v| (0..width).map(move |u| Point2::new(f64::from(u), f64::from(v))));
        let sights = pixels.map(|pixel| caster.sight(rig.camera.plane(pixel)?.coords)).collect();
        Self { room: room.clone(), rig: rig.clone(), sights, pixels: Vec::new() }
    }

    /// The room.
    pub fn room(&self) -> &Room {
        &self.room
    }

    /// The rig.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Width and height of the camera's image, pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.rig.camera.size_px
    }

    /// Surface point at the centre of a pixel; `None` where there is none.
    pub fn sight(&self, u: u32, v: u32) -> Option<&Sight> {
        let [width, height] = self.size_px();
        let index = (u < width && v < height).then(|| v as usize * width as usize + u as usize)?;
        self.sights.get(index)?.as_ref()
    }

    /// Projector pixel that lights the centre of a camera pixel.
    pub fn truth(&self, u: u32, v: u32) -> Option<Point2<f64>> {
        self.sight(u, v)?.lit_by
    }

    /// Share of the camera's pixels that the projector lights.
    #[cfg(test)]
    fn lit_share(&self) -> f64 {
        let lit = self.sights.iter().flatten().filter(|sight| sight.lit_by.is_some()).count();
        lit as f64 / self.sights.len().max(1) as f64
    }

    /// Surface points, row by row.
    pub(crate) fn sights(&self) -> &[Option<Sight>] {
        &self.sights
    }

    /// Camera pixels, row by row.
    pub(crate) fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }
}

/// Points of the plane z = 1 for all pixels, with a margin of one pixel.
fn lattice(camera: &Lens) -> Vec<Vec<Option<Vector2<f64>>>> {
    let [width, height] = camera.size_px;
    let row = |v: u32| {
        let pixel = |u: u32| Point2::new(f64::from(u) - 1.0, f64::from(v) - 1.0);
        (0..width + 2).map(|u| camera.plane(pixel(u)).map(|place| place.coords)).collect()
    };
    (0..height + 2).into_par_iter().map(row).collect()
}

/// Ray caster.
struct Caster<'a> {
    room: &'a Room,
    projector: &'a Lens,
    room_from_camera: Isometry3<f64>,
    projector_from_room: Isometry3<f64>,
    eye: Point3<f64>,
    lamp: Point3<f64>,
}

impl<'a> Caster<'a> {
    fn new(room: &'a Room, rig: &'a Rig) -> Self {
        Self {
            room,
            projector: &rig.projector,
            room_from_camera: rig.room_from_camera,
            projector_from_room: rig.room_from_projector.inverse(),
            eye: rig.room_from_camera.translation.vector.into(),
            lamp: rig.room_from_projector.translation.vector.into(),
        }
    }

    fn hit(&self, place: Vector2<f64>) -> Option<Hit> {
        self.room.hit(&self.eye, &(self.room_from_camera * place.push(1.0)))
    }

    /// Projector pixel and depth of a point.
    fn landing(&self, point: &Point3<f64>) -> Option<(Point2<f64>, f64)> {
        let seen = self.projector_from_room * point;
        self.projector.project(&seen).map(|pixel| (pixel, seen.z))
    }

    /// `true` if the projector's light reaches a hit.
    fn is_reached(&self, hit: &Hit) -> bool {
        (self.lamp - hit.point).dot(&hit.normal) > 0.0 && !self.room.is_blocked(&self.lamp, &hit.point)
    }

    fn sight(&self, place: Vector2<f64>) -> Option<Sight> {
        let hit = self.hit(place)?;
        let pixel = self.landing(&hit.point).map(|(pixel, _)| pixel);
        let lit_by = pixel.filter(|pixel| self.projector.contains(*pixel) && self.is_reached(&hit));
        Some(Sight {
            point: self.room_from_camera.inverse_transform_point(&hit.point),
            normal: self.room_from_camera.inverse_transform_vector(&hit.normal),
            albedo: hit.albedo,
            lit_by,
            is_infrared_black: hit.is_infrared_black,
        })
    }

    /// Pixel at a point of the plane z = 1; the steps lead to the next pixels to the right and down.
    fn pixel(&self, place: Vector2<f64>, steps: [Vector2<f64>; 2], sight: Option<&Sight>) -> Pixel {
        let mut pixel = Pixel::default();
        let quarters = [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]];
        for (ray, [right, down]) in pixel.rays.iter_mut().zip(quarters) {
            let Some(hit) = self.hit(place + steps[0] * right + steps[1] * down) else { continue };
            let share = hit.albedo / RAYS as f64;
            pixel.albedo += share as f32;
            pixel.ambient += (share * (0.7 - 0.3 * hit.normal.y)) as f32;
            *ray = self.ray(&hit).unwrap_or_default();
        }
        if let Some(sight) = sight.filter(|_| pixel.rays.iter().any(|ray| ray.light > 0.0)) {
            pixel.extent_px = self.extent_px(sight, place, steps).unwrap_or_default();
        }
        pixel
    }

    fn ray(&self, hit: &Hit) -> Option<Ray> {
        let (pixel, depth_m) = self.landing(&hit.point)?;
        let size = Vector2::from(self.projector.size_px.map(f64::from));
        // -1 to 1 from edge to edge.
        let share = 2.0 * (pixel.coords.add_scalar(0.5)).component_div(&size) - Vector2::repeat(1.0);
        let margin = Vector2::repeat(1.0) + Vector2::repeat(2.0 * MARGIN_PX).component_div(&size);
        if share.x.abs() > margin.x || share.y.abs() > margin.y || !self.is_reached(hit) {
            return None;
        }
        let towards = self.lamp - hit.point;
        let squared = towards.norm_squared();
        let cosine = towards.dot(&hit.normal) / squared.sqrt();
        let light = hit.albedo * cosine / squared * (1.0 - 0.5 * VIGNETTING * share.norm_squared());
        let lit_by = [pixel.x as f32, pixel.y as f32];
        Some(Ray { lit_by, depth_m: depth_m as f32, light: light as f32 })
    }

    /// Standard deviation, over the projector's u and v, of a quarter of a pixel on a flat surface.
    fn extent_px(&self, sight: &Sight, place: Vector2<f64>, steps: [Vector2<f64>; 2]) -> Option<[f32; 2]> {
        let (point, normal) = (sight.point, sight.normal);
        let on_surface = |place: Vector2<f64>| {
            let ray = place.push(1.0);
            let point = Point3::from(ray * (point.coords.dot(&normal) / ray.dot(&normal)));
            self.landing(&(self.room_from_camera * point)).map(|(pixel, _)| pixel)
        };
        let middle = on_surface(place)?;
        let [right, down] =
            [on_surface(place + 0.5 * steps[0])? - middle, on_surface(place + 0.5 * steps[1])? - middle];
        // Of an even distribution over two edges of these lengths.
        let deviation = |axis: usize| ((right[axis].powi(2) + down[axis].powi(2)) / 12.0).sqrt().min(20.0) as f32;
        Some([deviation(0), deviation(1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_is_what_the_lenses_say() {
        let rig = Rig::random(3);
        let view = View::new(&Room::cluttered(3), &rig);
        let mut lit = 0;
        for (u, v) in (0..480).step_by(7).flat_map(|v| (0..640).step_by(7).map(move |u| (u, v))) {
            let sight = view.sight(u, v).unwrap();
            let seen = rig.camera.project(&sight.point).unwrap();
            assert!((seen - Point2::new(f64::from(u), f64::from(v))).norm() < 1e-6);
            assert!(sight.normal.dot(&sight.point.coords) < 0.0);
            let pixel = rig.projector.project(&(rig.projector_from_camera() * sight.point)).unwrap();
            if let Some(truth) = view.truth(u, v) {
                assert!((pixel - truth).norm() < 1e-6 && rig.projector.contains(truth));
                lit += 1;
            }
        }
        assert!(lit > 500, "{lit}");
        assert!(view.sight(640, 0).is_none() && view.sight(0, 480).is_none());
    }

    #[test]
    fn a_flat_wall_has_no_shadow_and_a_cluttered_room_has() {
        for seed in 0..2 {
            let rig = Rig::random(seed);
            let shadowed = |room: &Room| {
                let view = View::new(room, &rig);
                let in_image = view.sights().iter().flatten().filter(|sight| {
                    let pixel = rig.projector.project(&(rig.projector_from_camera() * sight.point));
                    pixel.is_some_and(|pixel| rig.projector.contains(pixel))
                });
                let count = in_image.count() as f64 / view.sights().len() as f64;
                (1.0 - view.lit_share() / count, view.lit_share())
            };
            let (shadow, lit) = shadowed(&Room::wall(1.4, [0.1, -0.15]));
            assert!(shadow == 0.0 && (0.15..=1.0).contains(&lit), "seed {seed}: {shadow} {lit}");
            let (shadow, lit) = shadowed(&Room::cluttered(seed));
            assert!((0.005..0.5).contains(&shadow) && (0.15..=1.0).contains(&lit), "seed {seed}: {shadow} {lit}");
        }
    }
}
