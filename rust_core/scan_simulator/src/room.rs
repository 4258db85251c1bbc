//! Room to project into: planes, boxes and balls with diffuse surfaces, and ray casting.
//!
//! There are about twenty solids, so rays test each of them.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};

use rcs_calibration::board::Chessboard;

use crate::surface::Surface;
use crate::Random;

/// Half the thickness of a board, metres.
const BOARD_M: f64 = 0.002;

/// Intersection of a ray and a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance in lengths of the ray's direction: metres for a unit vector, the depth for one with z = 1.
    pub distance: f64,
    /// Point in the room's frame, metres.
    pub point: Point3<f64>,
    /// Unit normal in the room's frame, pointing out of the solid.
    pub normal: Vector3<f64>,
    /// Albedo, 0 to 1.
    pub albedo: f64,
    /// `true` if the surface swallows infrared light: a depth camera does not see it.
    pub is_infrared_black: bool,
}

/// Solids in the room's frame: x right, y down, z away from the rig, which is near the origin.
#[derive(Debug, Clone)]
pub struct Room {
    solids: Vec<Solid>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum Shape {
    /// Infinite plane z = 0 of the solid's frame, lit from positive z.
    Plane,
    /// Box around the origin, by half its size, metres.
    Cuboid(Vector3<f64>),
    /// Ball around the origin, by its radius, metres.
    Ball(f64),
    /// Cylinder around z with round ends, by its radius and half the length of its axis, metres.
    Capsule(f64, f64),
}

#[derive(Debug, Clone)]
pub(crate) struct Solid {
    shape: Shape,
    solid_from_room: Isometry3<f64>,
    /// Rotation of `solid_from_room`, faster as a matrix.
    rotation: Matrix3<f64>,
    /// Bounding sphere: centre in the room's frame and squared radius, metres; infinite for a plane.
    centre: Point3<f64>,
    squared_radius: f64,
    surface: Surface,
    is_infrared_black: bool,
}

/// Walls of a cluttered room, its first solids.
const WALLS: usize = 3;

impl Room {
    /// Random room: a back wall, a floor and a side wall, and 8 to 20 boxes, balls and slanted panels before them, from
    /// 0.6 to about 2 m from the origin.
    pub fn cluttered(seed: u64) -> Self {
        let random = &mut Random::new(&[seed, 0x0726_006d]);
        let mut solids = walls(random);
        for _ in 0..random.integer(8, 20) {
            solids.push(Solid::random(random));
        }
        Self { solids }
    }

    /// Flat wall of albedo 0.8 at a distance along z, metres, rotated about x and y, radians.
    pub fn wall(distance_m: f64, tilt_rad: [f64; 2]) -> Self {
        let turned = UnitQuaternion::from_euler_angles(tilt_rad[0], tilt_rad[1], 0.0);
        Self { solids: vec![Solid::plane(Vector3::new(0.0, 0.0, distance_m), turned, Surface::plain(0.8))] }
    }

    /// Table that is seen from above at a slope of 45°, 1.3 m from the origin, with six boxes and three balls on it.
    pub fn table(seed: u64) -> Self {
        let random = &mut Random::new(&[seed, 0x7461_626c]);
        let middle = Vector3::new(0.0, 0.0, 1.3);
        let slope = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -std::f64::consts::FRAC_PI_4);
        let mut solids = vec![Solid::plane(middle, slope, Surface::plain(0.7))];
        let room_from_table = Isometry3::from_parts(middle.into(), solids[0].solid_from_room.rotation.inverse());
        for index in 0..9 {
            // Three rows of three.
            let (column, row) = (f64::from(index % 3) - 1.0, f64::from(index / 3) - 1.0);
            let half_m =
                Vector3::new(random.uniform(0.03, 0.07), random.uniform(0.03, 0.07), random.uniform(0.03, 0.1));
            let shape = if index % 3 == 1 { Shape::Ball(half_m.z) } else { Shape::Cuboid(half_m) };
            let at = Vector3::new(
                0.28 * column + random.uniform(-0.05, 0.05),
                0.25 * row + random.uniform(-0.05, 0.05),
                half_m.z,
            );
            let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), random.uniform(0.0, 1.5));
            let place = room_from_table * Isometry3::from_parts(at.into(), turned);
            solids.push(Solid::new(shape, place.translation.vector, place.rotation, Surface::random(random, 0.4)));
        }
        Self { solids }
    }

    /// Number of the solids of a cluttered room that stand before its walls.
    pub fn objects(&self) -> usize {
        self.solids.len().saturating_sub(WALLS)
    }

    /// The room after an object was taken away, by its index below [`Self::objects`].
    #[must_use]
    pub fn without(&self, object: usize) -> Self {
        let mut room = self.clone();
        if WALLS + object < room.solids.len() {
            room.solids.remove(WALLS + object);
        }
        room
    }

    /// The room without checkered surfaces, which may look like a chessboard.
    #[must_use]
    pub fn without_checkers(mut self) -> Self {
        self.solids.iter_mut().for_each(|solid| solid.surface = solid.surface.without_checkers());
        self
    }

    /// The room with some of its objects of a material that a depth camera does not see.
    #[must_use]
    pub fn with_infrared_black(&self, seed: u64, share: f64) -> Self {
        let random = &mut Random::new(&[seed, 0x4441_524b]);
        let mut room = self.clone();
        room.solids.iter_mut().skip(WALLS).for_each(|solid| solid.is_infrared_black = random.happens(share));
        room
    }

    /// The room with more solids.
    #[must_use]
    pub(crate) fn with(&self, solids: impl IntoIterator<Item = Solid>) -> Self {
        let mut room = self.clone();
        room.solids.extend(solids);
        room
    }

    /// The room with a printed chessboard before all of it. The board's frame has its origin in its middle, x along its
    /// columns, y along its rows and z away from whoever looks at it.
    pub fn with_board(mut self, board: Chessboard, room_from_board: &Isometry3<f64>) -> Self {
        // The margin is a square wide.
        let half_m = board.corners.map(|count| (0.5 * f64::from(count) + 1.5) * board.square_m);
        let shape = Shape::Cuboid(Vector3::new(half_m[0], half_m[1], BOARD_M));
        let behind = room_from_board * Translation3::new(0.0, 0.0, BOARD_M);
        let solid = Solid::new(shape, behind.translation.vector, behind.rotation, Surface::board(board));
        self.solids.push(solid);
        self
    }

    /// First intersection of a ray from a point of the room's frame.
    pub fn hit(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> Option<Hit> {
        let mut nearest: Option<(f64, &Solid)> = None;
        for solid in &self.solids {
            let distance = solid.distance(origin, direction);
            if let Some(distance) = distance.filter(|distance| nearest.is_none_or(|(least, _)| *distance < least)) {
                nearest = Some((distance, solid));
            }
        }
        let (distance, solid) = nearest?;
        let point = origin + direction * distance;
        let (normal, albedo) = solid.surface_at(&point);
        Some(Hit { distance, point, normal, albedo, is_infrared_black: solid.is_infrared_black })
    }

    /// `true` if anything lies between two points, more than half a millimetre from both.
    pub fn is_blocked(&self, from: &Point3<f64>, to: &Point3<f64>) -> bool {
        let direction = to - from;
        let margin = 5e-4 / direction.norm();
        let origin = from + direction * margin;
        let least = 1.0 - 2.0 * margin;
        self.solids.iter().any(|solid| solid.distance(&origin, &direction).is_some_and(|distance| distance < least))
    }
}

/// Back wall, floor and a side wall.
fn walls(random: &mut Random) -> Vec<Solid> {
    let mut turned = || UnitQuaternion::from_euler_angles(random.uniform(-0.1, 0.1), random.uniform(-0.15, 0.15), 0.0);
    let (back, floor, side) = (turned(), turned(), turned());
    let half_turn = std::f64::consts::FRAC_PI_2;
    let floor = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -half_turn) * floor;
    let is_right = random.happens(0.5);
    let sign = if is_right { 1.0 } else { -1.0 };
    let side = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), sign * half_turn) * side;
    let at = |random: &mut Random, low, high| random.uniform(low, high);
    vec![
        Solid::plane(Vector3::new(0.0, 0.0, at(random, 1.6, 2.0)), back, Surface::random(random, 0.4)),
        Solid::plane(Vector3::new(0.0, at(random, 0.45, 0.75), 1.3), floor, Surface::random(random, 0.15)),
        Solid::plane(Vector3::new(sign * at(random, 0.8, 1.2), 0.0, 1.3), side, Surface::random(random, 0.15)),
    ]
}

impl Solid {
    /// Creates a solid with its origin at a place of the room.
    pub(crate) fn new(
        shape: Shape,
        place: Vector3<f64>,
        room_from_solid: UnitQuaternion<f64>,
        surface: Surface,
    ) -> Self {
        let solid_from_room = Isometry3::from_parts(Translation3::from(place), room_from_solid).inverse();
        let squared_radius = match shape {
            Shape::Plane => f64::INFINITY,
            Shape::Cuboid(half_size) => half_size.norm_squared(),
            Shape::Ball(radius) => radius * radius,
            Shape::Capsule(radius, half_length) => (radius + half_length).powi(2),
        };
        let rotation = solid_from_room.rotation.to_rotation_matrix().into_inner();
        let centre = place.into();
        Self { shape, solid_from_room, rotation, centre, squared_radius, surface, is_infrared_black: false }
    }

    /// Creates a plane through a point, rotated from facing the rig.
    fn plane(through: Vector3<f64>, turned: UnitQuaternion<f64>, surface: Surface) -> Self {
        // The plane's z points back at the rig.
        let facing = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        Self::new(Shape::Plane, through, turned * facing, surface)
    }

    /// Random box, ball or panel before the walls.
    fn random(random: &mut Random) -> Self {
        let mut uniform = |low, high| random.uniform(low, high);
        let depth = uniform(0.85, 1.7);
        let place = Vector3::new(uniform(-0.5, 0.5) * depth, uniform(-0.4, 0.35) * depth, depth);
        // Near solids are small, so that they do not occlude the rest.
        let size = depth * uniform(0.03, 0.11);
        let axis = Vector3::new(uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0));
        let stretch = Vector3::new(uniform(0.6, 1.5), uniform(0.6, 1.5), uniform(0.6, 1.5));
        let turned = UnitQuaternion::new(axis.try_normalize(1e-9).unwrap_or_else(Vector3::x) * uniform(0.0, 1.0));
        let panel = Vector3::new(1.6 * size * stretch.x, 1.6 * size * stretch.y, 0.005);
        let shape = match random.integer(0, 2) {
            0 => Shape::Cuboid(stretch * size),
            1 => Shape::Cuboid(panel),
            _ => Shape::Ball(1.2 * size),
        };
        Self::new(shape, place, turned, Surface::random(random, 0.0))
    }

    /// Entry of a ray ahead, in lengths of its direction; planes have one side.
    fn distance(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> Option<f64> {
        let from_centre = origin - self.centre;
        // A quarter of the discriminant for the bounding sphere.
        let (a, b) = (direction.norm_squared(), from_centre.dot(direction));
        let discriminant = b * b - a * (from_centre.norm_squared() - self.squared_radius);
        if discriminant <= 0.0 {
            return None;
        }
        let (from, along) = (self.rotation * from_centre, self.rotation * direction);
        match self.shape {
            Shape::Plane => (along.z < 0.0 && from.z > 0.0).then(|| -from.z / along.z),
            Shape::Cuboid(half_size) => {
                let (mut entry, mut exit) = (0.0_f64, f64::INFINITY);
                for axis in 0..3 {
                    let near = 1.0 / along[axis];
                    let (one, other) = ((-half_size[axis] - from[axis]) * near, (half_size[axis] - from[axis]) * near);
                    entry = entry.max(one.min(other));
                    exit = exit.min(one.max(other));
                }
                (entry < exit && entry > 0.0).then_some(entry)
            }
            Shape::Ball(_) => {
                let distance = -(b + discriminant.sqrt()) / a;
                (distance > 0.0).then_some(distance)
            }
            Shape::Capsule(radius, half_length) => capsule_entry(&from, &along, radius, half_length),
        }
    }

    /// Normal and albedo at a point on the surface.
    fn surface_at(&self, point: &Point3<f64>) -> (Vector3<f64>, f64) {
        let local = self.solid_from_room * point;
        let normal = match self.shape {
            Shape::Plane => Vector3::z(),
            Shape::Cuboid(half_size) => {
                let share = local.coords.component_div(&half_size);
                let axis = share.iamax();
                let mut normal = Vector3::zeros();
                normal[axis] = share[axis].signum();
                normal
            }
            Shape::Ball(_) => local.coords.try_normalize(1e-12).unwrap_or_else(Vector3::z),
            Shape::Capsule(_, half_length) => {
                let on_axis = Vector3::z() * local.z.clamp(-half_length, half_length);
                (local.coords - on_axis).try_normalize(1e-12).unwrap_or_else(Vector3::z)
            }
        };
        (self.solid_from_room.inverse_transform_vector(&normal), self.surface.albedo(&local))
    }
}

/// Entry of a ray ahead into a capsule around z.
fn capsule_entry(from: &Vector3<f64>, along: &Vector3<f64>, radius: f64, half_length: f64) -> Option<f64> {
    let entry = |a: f64, b: f64, c: f64| {
        let discriminant = b * b - a * c;
        (a > 0.0 && discriminant > 0.0).then(|| -(b + discriminant.sqrt()) / a).filter(|distance| *distance > 0.0)
    };
    let (a, b) = (along.x * along.x + along.y * along.y, from.x * along.x + from.y * along.y);
    let cylinder = entry(a, b, from.x * from.x + from.y * from.y - radius * radius);
    let is_on_cylinder = |distance: &f64| (from.z + distance * along.z).abs() <= half_length;
    let end = |z: f64| {
        let from = from - Vector3::new(0.0, 0.0, z);
        entry(along.norm_squared(), from.dot(along), from.norm_squared() - radius * radius)
    };
    let ends = [end(half_length), end(-half_length)];
    cylinder.filter(is_on_cylinder).into_iter().chain(ends.into_iter().flatten()).min_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_is_hit_where_it_stands() {
        let room = Room::wall(1.5, [0.0, 0.0]);
        let hit = room.hit(&Point3::origin(), &Vector3::new(0.2, -0.1, 1.0)).unwrap();
        assert!((hit.point - Point3::new(0.3, -0.15, 1.5)).norm() < 1e-12 && (hit.distance - 1.5).abs() < 1e-12);
        assert!((hit.normal + Vector3::z()).norm() < 1e-12 && hit.albedo == 0.8);
        assert_eq!(room.hit(&Point3::origin(), &-Vector3::z()), None);
        assert!(!room.is_blocked(&Point3::origin(), &hit.point));
        assert!(room.is_blocked(&Point3::origin(), &Point3::new(0.0, 0.0, 1.6)));
    }

    #[test]
    fn what_is_hit_faces_the_ray_and_is_seen_from_there() {
        for seed in 0..20 {
            let room = Room::cluttered(seed);
            let random = &mut Random::new(&[seed]);
            let mut hits = 0;
            for _ in 0..500 {
                let direction = Vector3::new(random.uniform(-0.5, 0.5), random.uniform(-0.4, 0.4), 1.0);
                let Some(hit) = room.hit(&Point3::origin(), &direction) else { continue };
                hits += 1;
                assert!(hit.normal.dot(&direction) < 1e-9 && (hit.normal.norm() - 1.0).abs() < 1e-9);
                assert!((0.15..=0.95).contains(&hit.albedo));
                assert!((0.6..3.0).contains(&hit.point.coords.norm()), "{}", hit.point);
                assert!(!room.is_blocked(&Point3::origin(), &hit.point));
                let behind = hit.point + direction * 1e-2;
                assert!(room.is_blocked(&Point3::origin(), &behind) || hit.normal.dot(&direction).abs() < 0.1);
            }
            assert_eq!(hits, 500, "seed {seed}");
        }
    }

    #[test]
    fn things_stand_on_a_table_that_slopes_away() {
        let room = Room::table(1);
        let down = |y: f64| room.hit(&Point3::origin(), &Vector3::new(0.9, y, 1.0)).unwrap().point;
        let table = Vector3::new(0.0, -1.0, -1.0).normalize();
        for y in [-0.4, 0.0, 0.4] {
            assert!((table.dot(&(down(y) - Point3::new(0.0, 0.0, 1.3)))).abs() < 1e-9, "{}", down(y));
        }
        for solid in &room.solids[1..] {
            let above_m = table.dot(&(solid.centre - Point3::new(0.0, 0.0, 1.3)));
            assert!((0.03..=0.1).contains(&above_m), "{above_m}");
        }
    }

    #[test]
    fn a_capsule_is_a_cylinder_with_round_ends() {
        let capsule = Solid::new(
            Shape::Capsule(0.1, 0.3),
            Vector3::new(0.0, 0.0, 1.0),
            UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2),
            Surface::plain(0.5),
        );
        // Its axis is along x.
        let room = Room { solids: vec![capsule] };
        let depth = |x: f64, y: f64| room.hit(&Point3::new(x, y, 0.0), &Vector3::z()).map(|hit| hit.distance);
        let close = |found: Option<f64>, expected: f64| (found.unwrap() - expected).abs() < 1e-9;
        assert!(close(depth(0.0, 0.0), 0.9) && close(depth(0.29, 0.06), 0.92) && close(depth(0.36, 0.0), 0.92));
        assert!(close(depth(-0.36, 0.0), 0.92) && depth(0.0, 0.11).is_none() && depth(0.41, 0.0).is_none());
        let hit = room.hit(&Point3::new(0.2, 0.06, 0.0), &Vector3::z()).unwrap();
        assert!((hit.normal - Vector3::new(0.0, 0.6, -0.8)).norm() < 1e-9);
    }
}
