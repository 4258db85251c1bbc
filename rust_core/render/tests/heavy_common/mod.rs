//! Scenes that are heavy to draw: much that is large on the image, behind the lens, or both.
//!
//! The images have 640×480 pixels and a focal length of a depth camera's cloud seen from a projector beside it.
#![allow(dead_code, unreachable_pub, reason = "each user of this module uses its part")]

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Point3, Vector3};
use rcs_scene::{
    Blending, Camera, CullMode, Drawable, Geometry, Intrinsics, LineTopology, Lines, Material, Mesh, PointBuffer,
    PointColors, PointStyle, Points, RenderGroup, Rgba, RibbonElement, Ribbons, Scene, Vertex,
};

/// Pixels in a row, and rows.
pub const SIZE_PX: [u32; 2] = [640, 480];

/// Points of a depth camera's cloud.
pub const DEPTH_CAMERA_POINTS: usize = 640 * 480;

/// The side of a point in metres.
pub const SIDE_M: f32 = 0.004;

/// Every style whose size is in metres.
pub const STYLES: [(&str, PointStyle); 5] = [
    ("Flat Squares", PointStyle::FlatSquares { side_m: SIDE_M }),
    ("Squares", PointStyle::Squares { size_m: [SIDE_M; 2] }),
    ("Spheres", PointStyle::Spheres { size_m: [SIDE_M; 2] }),
    ("Boxes", PointStyle::Boxes { size_m: [SIDE_M; 3] }),
    ("Tiles", PointStyle::Tiles { size_m: [SIDE_M; 2], normal: [0.0, 0.0, -1.0], up: [0.0, -1.0, 0.0] }),
];

/// A row of the table: a scene, the camera that sees it and the time that an image may take.
pub struct Row {
    /// What it is.
    pub name: String,
    /// Makes what the scene has.
    pub drawable: Box<dyn Fn() -> Drawable>,
    /// The camera.
    pub camera: Camera,
    /// The longest time of an image.
    pub limit_ms: f64,
}

impl Row {
    /// The scene.
    pub fn scene(&self) -> Scene {
        Scene { drawables: vec![(self.drawable)()], light: None }
    }
}

/// A sequence of numbers from 0 to before 1 that looks random.
pub struct Numbers(u64);

impl Numbers {
    /// Each seed has its own.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number.
    #[allow(clippy::should_implement_trait, reason = "the sequence has no end")]
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    /// A number between two.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }
}

/// A camera of this focal length at the origin, turned by a rotation vector.
pub fn camera(focal_px: f64, turn: [f64; 3]) -> Camera {
    camera_of(SIZE_PX, focal_px, turn)
}

/// A camera of this image size and focal length at the origin, turned by a rotation vector.
#[expect(clippy::expect_used, reason = "the intrinsics are valid")]
pub fn camera_of([width, height]: [u32; 2], focal_px: f64, turn: [f64; 3]) -> Camera {
    let (cx, cy) = (f64::from(width) / 2.0, f64::from(height) / 2.0);
    let p = [focal_px, 0.0, cx, 0.0, 0.0, focal_px, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    let intrinsics = Intrinsics::from_p(width, height, &p).expect("a projection");
    Camera::new(intrinsics, &Isometry3::new(Vector3::zeros(), Vector3::from(turn)), 0.01)
}

/// A drawable in the fixed frame's origin.
pub fn drawable(geometry: Geometry) -> Drawable {
    Drawable {
        display: 0,
        fixed_from_object: Matrix4::identity(),
        sort_point: Point3::origin(),
        group: RenderGroup::Main,
        geometry,
    }
}

/// A color by a number, not transparent.
pub fn color(number: usize) -> [u8; 4] {
    let mixed = (number as u32).wrapping_mul(0x9e37_79b9) >> 8;
    [(mixed & 255) as u8, (mixed >> 8 & 255) as u8, (mixed >> 16 & 255) as u8, 255]
}

/// A cloud of these positions, each in a color of its own; translucent ones blend.
pub fn cloud(positions: Vec<[f32; 3]>, style: PointStyle, alpha: f32) -> Drawable {
    let colors = PointColors::PerPoint((0..positions.len()).map(color).collect());
    let buffer = Arc::new(PointBuffer { positions, colors });
    drawable(Geometry::Points(Points { buffer, style, alpha, blended: alpha < 1.0, auto_size: false }))
}

/// Points 6 cm before a lens of this focal length, spread over its image in the camera's rows.
pub fn spread(count: usize, focal_px: f32, distance_m: f32) -> Vec<[f32; 3]> {
    let columns = ((count as f32 * 4.0 / 3.0).sqrt().round() as usize).max(1);
    let rows = count.div_ceil(columns);
    let place = |i: usize, of: usize, side_px: u32| {
        ((i as f32 + 0.5) / of as f32 - 0.5) * side_px as f32 / focal_px * distance_m
    };
    let point = |i: usize| [place(i % columns, columns, SIZE_PX[0]), place(i / columns, rows, SIZE_PX[1]), distance_m];
    (0..count).map(point).collect()
}

/// Points between two distances, spread over an image and, where the distance is negative, over its mirror image
/// behind the lens.
pub fn between(count: usize, focal_px: f32, [near_m, far_m]: [f32; 2]) -> Vec<[f32; 3]> {
    let mut numbers = Numbers::new(7);
    let mut point = || {
        let z = numbers.between(near_m, far_m);
        let [x, y] = SIZE_PX.map(|side_px| (numbers.next() - 0.5) * side_px as f32 / focal_px * z);
        [x, y, z]
    };
    (0..count).map(|_| point()).collect()
}

/// Places around the camera, up to 2 m away.
pub fn around(count: usize) -> Vec<[f32; 3]> {
    let mut numbers = Numbers::new(3);
    let mut side = || numbers.between(-2.0, 2.0);
    (0..count).map(|_| [side(), side(), side()]).collect()
}

/// A path that winds around the camera, closer than 2 m.
pub fn winding(count: usize) -> Vec<[f32; 3]> {
    let point = |i: usize| {
        let t = i as f32 * 0.01;
        let radius = 0.3 + 0.2 * (t * 0.0131).sin();
        [radius * t.sin(), 0.3 * (t * 0.037).sin(), radius * t.cos()]
    };
    (0..count).map(point).collect()
}

/// Lines of one pixel.
pub fn lines(positions: Vec<[f32; 3]>, topology: LineTopology, blending: Blending) -> Drawable {
    let colors = (0..positions.len()).map(color).collect();
    drawable(Geometry::Lines(Arc::new(Lines { positions, colors, topology, blending })))
}

/// The three lines of a flat arrow at each of these places.
pub fn arrows(places: &[[f32; 3]]) -> Drawable {
    let mut numbers = Numbers::new(5);
    let mut positions = Vec::with_capacity(places.len() * 6);
    for &[x, y, z] in places {
        let (turn, length) = (numbers.between(0.0, 6.3), 0.3);
        let tip = [x + length * turn.cos(), y + length * turn.sin(), z];
        let barb = |turn: f32| [tip[0] - 0.2 * length * turn.cos(), tip[1] - 0.2 * length * turn.sin(), z];
        positions.extend([[x, y, z], tip, tip, barb(turn + 0.5), tip, barb(turn - 0.5)]);
    }
    let colors = vec![[255, 25, 0, 255]];
    let lines = Lines { positions, colors, topology: LineTopology::List, blending: Blending::Replace };
    drawable(Geometry::Lines(Arc::new(lines)))
}

/// Wide lines through these places, in chains of equal length.
pub fn ribbons(positions: &[[f32; 3]], in_chain: usize, blending: Blending) -> Drawable {
    let element = |(i, position): (usize, &[f32; 3])| RibbonElement { position: *position, color: color(i) };
    let all: Vec<RibbonElement> = positions.iter().enumerate().map(element).collect();
    let chains = all.chunks(in_chain).map(<[RibbonElement]>::to_vec).collect();
    drawable(Geometry::Ribbons(Arc::new(Ribbons { chains, width_m: 0.01, blending })))
}

/// Triangles that each fill the image, at the distances that a function gives.
pub fn filling(count: usize, blending: Blending, distance_m: impl Fn(usize) -> f32) -> Drawable {
    let mut mesh = Mesh::default();
    for i in 0..count {
        let z = distance_m(i);
        for [x, y] in [[-1.0, -1.0], [0.0, 2.0], [1.0, -1.0]] {
            let (color, position) = (color(i), [x * 2.0 * z, y * 2.0 * z, z]);
            mesh.vertices.push(Vertex { color, ..Vertex::new(position, [0.0, 0.0, -1.0]) });
        }
        mesh.indices.extend([0, 1, 2].map(|corner| 3 * i as u32 + corner));
    }
    let material = Material { cull: CullMode::None, ..Material::unlit(blending == Blending::Alpha) };
    drawable(Geometry::Mesh { mesh: Arc::new(mesh), material: Arc::new(material) })
}

/// Translucent balls of an octahedron's facets divided into 4, so 32 triangles each, in one mesh.
pub fn balls(places: &[[f32; 3]], radius_m: f32, alpha: u8) -> Drawable {
    let mut facets: Vec<[Vector3<f32>; 3]> = Vec::new();
    for signs in 0..8 {
        let axis = |i: usize| {
            let mut v = Vector3::zeros();
            v[i] = if signs >> i & 1 == 0 { 1.0 } else { -1.0 };
            v
        };
        let (x, y, z) = (axis(0), axis(1), axis(2));
        let [a, b, c] = if x.cross(&y).dot(&z) > 0.0 { [x, y, z] } else { [x, z, y] };
        let middle = |a: Vector3<f32>, b: Vector3<f32>| (a + b).normalize();
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        facets.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    let mut mesh = Mesh::default();
    for (i, place) in places.iter().enumerate() {
        let [r, g, b, _] = color(i);
        for corner in facets.iter().flatten() {
            let position = Vector3::from(*place) + corner * radius_m;
            mesh.indices.push(mesh.vertices.len() as u32);
            mesh.vertices.push(Vertex { color: [r, g, b, alpha], ..Vertex::new(position.into(), (*corner).into()) });
        }
    }
    let material = Material { vertex_colors: true, ..Material::unlit(true) };
    drawable(Geometry::Mesh { mesh: Arc::new(mesh), material: Arc::new(material) })
}

/// A detailed mesh of about `count` triangles that fills the middle of the image: a wavy sheet, whose triangles share
/// their vertices as in COLLADA files or, as in STL files, do not.
pub fn detailed(count: usize, shares: bool) -> Drawable {
    let side = ((count as f32 / 2.0).sqrt() as usize).max(1);
    let vertex = |[i, j]: [usize; 2]| {
        let [x, y] = [i, j].map(|at| at as f32 / side as f32 - 0.5);
        let slope = (40.0 * x).cos() * 0.4;
        Vertex::new([x, y, 1.5 + 0.01 * (40.0 * x).sin()], Vector3::new(slope, 0.0, -1.0).normalize().into())
    };
    let mut mesh = Mesh::default();
    let corners = |i: usize, j: usize| [[i, j], [i, j + 1], [i + 1, j], [i + 1, j], [i, j + 1], [i + 1, j + 1]];
    if shares {
        mesh.vertices.extend((0..=side).flat_map(|i| (0..=side).map(move |j| [i, j])).map(vertex));
        let index = |[i, j]: [usize; 2]| (i * (side + 1) + j) as u32;
        mesh.indices.extend((0..side).flat_map(|i| (0..side).flat_map(move |j| corners(i, j))).map(index));
    } else {
        mesh.vertices.extend((0..side).flat_map(|i| (0..side).flat_map(move |j| corners(i, j))).map(vertex));
        mesh.indices.extend(0..mesh.vertices.len() as u32);
    }
    let material = Material::lit(Rgba::new(0.8, 0.4, 0.2, 1.0));
    drawable(Geometry::Mesh { mesh: Arc::new(mesh), material: Arc::new(material) })
}

/// How far before the eye each triangle lies.
type DistanceOf = Box<dyn Fn(usize) -> f32>;

/// A turn of a camera by which no axis stays along one of the fixed frame's.
pub const TILT: [f64; 3] = [0.03, -0.02, 0.4];

/// All rows, with a share of the numbers of things: 1 for the table.
#[expect(clippy::too_many_lines, reason = "a table")]
pub fn rows(share: f64) -> Vec<Row> {
    let count = |all: usize| (all as f64 * share) as usize;
    let mut rows = Vec::new();
    let mut row = |name: String, limit_ms: f64, camera: Camera, drawable: Box<dyn Fn() -> Drawable>| {
        rows.push(Row { name, drawable, camera, limit_ms });
    };
    let straight = |focal_px: f64| camera(focal_px, [0.0; 3]);
    let points = count(DEPTH_CAMERA_POINTS);
    for (name, style) in STYLES {
        let limit_ms = if ["Flat Squares", "Spheres"].contains(&name) { 300.0 } else { f64::INFINITY };
        let near = move || cloud(spread(points, 1900.0, 0.06), style, 1.0);
        row(format!("{name} at 6 cm, f 1900"), limit_ms, straight(1900.0), Box::new(near));
        let blended = move || cloud(spread(points, 1900.0, 0.06), style, 0.5);
        row(format!("{name} at 6 cm, alpha 0.5"), f64::INFINITY, straight(1900.0), Box::new(blended));
    }
    let flat = PointStyle::FlatSquares { side_m: SIDE_M };
    let round = PointStyle::Points { diameter_px: 3.0 };
    let many = count(5_000_000);
    for (name, style) in [("Flat Squares", flat), ("Points 3 px", round)] {
        for (place, range_m) in [("behind", [-1.0, -0.001]), ("around", [-0.5, 0.5]), ("at 5 to 10 cm", [0.05, 0.1])] {
            let drawable = move || cloud(between(many, 1400.0, range_m), style, 1.0);
            row(format!("5 M {name} {place}"), 500.0, straight(1400.0), Box::new(drawable));
        }
    }
    let million = count(1_000_000);
    for (name, place) in [("around", around as fn(usize) -> Vec<[f32; 3]>), ("winding", winding)] {
        for (topology, kind) in [(LineTopology::List, "list"), (LineTopology::Strip, "strip")] {
            let drawable = move || lines(place(million), topology, Blending::Replace);
            row(format!("1 M line {kind} {name}"), 500.0, straight(1400.0), Box::new(drawable));
        }
        for (in_chain, kind) in [(2, "list"), (million, "strip")] {
            let drawable = move || ribbons(&place(million), in_chain, Blending::Replace);
            row(format!("1 M ribbon {kind} {name}"), 500.0, straight(1400.0), Box::new(drawable));
        }
    }
    let drawable = move || lines(around(million), LineTopology::List, Blending::Alpha);
    row("1 M line list, blended".into(), 500.0, straight(1400.0), Box::new(drawable));
    let near = move || around(million).into_iter().map(|place| place.map(|c| c * 0.15)).collect::<Vec<_>>();
    row("1 M flat arrows".into(), 500.0, straight(1400.0), Box::new(move || arrows(&near())));
    let filled = count(100_000);
    let last = filled.max(1) as f32;
    let kinds: [(&str, [f64; 3], DistanceOf); 5] = [
        ("towards the eye", [0.0; 3], Box::new(move |i| 3.0 - 2.0 * i as f32 / last)),
        ("away from the eye", [0.0; 3], Box::new(move |i| 1.0 + 2.0 * i as f32 / last)),
        ("at random depths", [0.0; 3], Box::new(|i| 1.0 + 2.0 * (i as f32 * 0.618_034).fract())),
        ("at one depth", [0.0; 3], Box::new(|_| 1.5)),
        ("at random, tilted", TILT, Box::new(|i| 1.0 + 2.0 * (i as f32 * 0.618_034).fract())),
    ];
    for (name, turn, distance_m) in kinds {
        let drawable = move || filling(filled, Blending::Replace, &distance_m);
        row(format!("0.1 M filling triangles {name}"), 200.0, camera(1400.0, turn), Box::new(drawable));
    }
    let places = move || between(filled, 1400.0, [0.5, 2.0]);
    let drawable = move || balls(&places(), 0.02, 128);
    row("0.1 M translucent balls".into(), 1000.0, straight(1400.0), Box::new(drawable));
    let spheres = PointStyle::Spheres { size_m: [0.04; 2] };
    let drawable = move || cloud(places(), spheres, 0.5);
    row("0.1 M Spheres of 4 cm, alpha 0.5".into(), 1000.0, straight(1400.0), Box::new(drawable));
    let detail = count(3_000_000);
    for (name, shares) in [("with common vertices", true), ("with their own vertices", false)] {
        let drawable = move || detailed(detail, shares);
        row(format!("3 M triangles of a mesh {name}"), 100.0, straight(700.0), Box::new(drawable));
    }
    rows
}
