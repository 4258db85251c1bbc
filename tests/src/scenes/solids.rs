//! Triangles, lines, ribbons and labels, any number of them, spread over the image of a camera that looks along z.
//!
//! Positions follow a sequence that fills the view evenly (multiples of irrational numbers), 1 to 3 metres away.

use std::sync::Arc;

use nalgebra::{Matrix4, Point3, Vector3};
use rcs_scene::{
    Blending, Drawable, Geometry, HorizontalAlignment, LineTopology, Lines, Material, Mesh, RenderGroup, Rgba,
    RibbonElement, Ribbons, Text, Vertex, VerticalAlignment,
};

/// Position of an object by its number, in a view of this width and height in metres at a distance of one metre.
fn place(number: usize, [width, height]: [f64; 2]) -> Vector3<f64> {
    let share = |step: f64| (number as f64 * step).fract();
    let z = 1.0 + 2.0 * share(0.819_172_513_396_164_4);
    let (u, v) = (share(0.754_877_666_246_693) - 0.5, share(0.569_840_290_998_053) - 0.5);
    Vector3::new(u * width * z, v * height * z, z)
}

/// Color of an object by its number.
fn color(number: usize) -> [u8; 4] {
    [(40 + number * 37 % 200) as u8, (40 + number * 91 % 200) as u8, (40 + number * 53 % 200) as u8, 255]
}

/// A geometry at its own coordinates.
pub fn drawable(geometry: Geometry) -> Drawable {
    Drawable {
        display: 0,
        fixed_from_object: Matrix4::identity(),
        sort_point: Point3::origin(),
        group: RenderGroup::Main,
        geometry,
    }
}

/// Triangles that face the camera, with legs of `leg_px` pixels on an image of this focal length; neighbours share no
/// corners.
pub fn triangles(count: usize, leg_px: f64, focal_px: f64, view: [f64; 2]) -> Geometry {
    let mut mesh = Mesh::default();
    for i in 0..count {
        let (corner, base) = (place(i, view), mesh.vertices.len() as u32);
        let leg_m = leg_px / focal_px * corner.z;
        for offset in [Vector3::zeros(), Vector3::y() * leg_m, Vector3::x() * leg_m] {
            let position = (corner + offset).map(|c| c as f32).into();
            mesh.vertices.push(Vertex { color: color(i), ..Vertex::new(position, [0.0, 0.0, -1.0]) });
        }
        mesh.indices.extend([base, base + 1, base + 2]);
    }
    let material = Material::unlit(false);
    Geometry::Mesh { mesh: Arc::new(mesh), material: Arc::new(material) }
}

/// Lines one pixel wide and `length_px` long, in all directions.
pub fn lines(count: usize, length_px: f64, focal_px: f64, view: [f64; 2]) -> Geometry {
    let mut lines = Lines {
        positions: Vec::with_capacity(2 * count),
        colors: Vec::with_capacity(2 * count),
        topology: LineTopology::List,
        blending: Blending::Replace,
    };
    for i in 0..count {
        let begin = place(i, view);
        let (sin, cos) = (i as f64).sin_cos();
        let end = begin + Vector3::new(cos, sin, 0.0) * (length_px / focal_px * begin.z);
        lines.positions.extend([begin, end].map(|at| <[f32; 3]>::from(at.map(|c| c as f32))));
        lines.colors.extend([color(i), color(i + 1)]);
    }
    Geometry::Lines(Arc::new(lines))
}

/// Ribbons of ten elements each, `elements` in all.
pub fn ribbons(elements: usize, view: [f64; 2]) -> Geometry {
    let element = |i: usize| RibbonElement { position: place(i, view).map(|c| c as f32).into(), color: color(i) };
    let chains = (0..elements).step_by(10).map(|begin| (begin..elements.min(begin + 10)).map(element).collect());
    Geometry::Ribbons(Arc::new(Ribbons { chains: chains.collect(), width_m: 0.002, blending: Blending::Replace }))
}

/// Labels of about 16 characters, 2 cm high.
pub fn labels(count: usize, view: [f64; 2]) -> Vec<Drawable> {
    let alignment = (HorizontalAlignment::Center, VerticalAlignment::Center);
    let label = |i: usize| {
        let text = Text::new(&format!("object_{i:04} 0.42"), 0.02, Rgba::WHITE, alignment);
        let place = place(i, view);
        let fixed_from_object = Matrix4::new_translation(&place);
        Drawable { fixed_from_object, sort_point: place.into(), ..drawable(Geometry::Text(Arc::new(text))) }
    };
    (0..count).map(label).collect()
}

/// Many meshes of one box each, as a MarkerArray of cubes is.
pub fn boxes(count: usize, view: [f64; 2]) -> Vec<Drawable> {
    let Geometry::Mesh { mesh, material } = triangles(12, 8.0, 1900.0, [0.01; 2]) else { return Vec::new() };
    let one = |i: usize| {
        let geometry = Geometry::Mesh { mesh: mesh.clone(), material: material.clone() };
        let place = place(i, view);
        Drawable { fixed_from_object: Matrix4::new_translation(&place), sort_point: place.into(), ..drawable(geometry) }
    };
    (0..count).map(one).collect()
}
