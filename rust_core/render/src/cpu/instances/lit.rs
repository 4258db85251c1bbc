//! The light on a solid's vertices, several at once.
//!
//! Of a small solid that is seen, most vertices that face the eye are a corner of what is drawn. So it is faster to
//! light all of them side by side than each one where it is met, and each normal only once, which many vertices have in
//! common. The arithmetic is that of [`vertex_color`](crate::cpu::lighting::vertex_color), in the same order.

use fearless_simd::prelude::*;
use rcs_scene::{Lighting, Rgba};

use super::corners::{InstanceScratch, Source, Vertices};
use super::shape::Shape;
use crate::cpu::lanes::{load, map, store, F, LANES};
use crate::cpu::screen::ObjectTransform;
use crate::cpu::surface::Paint;
use crate::shading::{light_on_surface, lit_channel, Number};

/// How a solid is lit whose vertices differ in nothing but their normals.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlainLight<'a> {
    transform: &'a ObjectTransform,
    diffuse: [f32; 4],
    emissive: [f32; 4],
}

impl<'a> PlainLight<'a> {
    /// Of a solid; `None` where its vertices have colours or texture coordinates of their own.
    pub(super) fn of(shape: &Shape, source: &Source<'a>) -> Option<Self> {
        let Vertices::Mesh(_) = source.vertices else { return None };
        let Lighting::Lit { diffuse, emissive } = source.material.lighting else { return None };
        let is_plain = !source.material.vertex_colors && matches!(source.surface.paint, Paint::Color);
        let [diffuse, emissive] = [diffuse, emissive].map(Rgba::to_array);
        (is_plain && shape.has_normals()).then_some(Self { transform: source.transform, diffuse, emissive })
    }

    /// The opacity of all vertices.
    pub(super) fn alpha(&self) -> f32 {
        self.diffuse[3].clamp(0.0, 1.0)
    }

    /// Lights all normals, for [`InstanceScratch::lit_corner`].
    #[inline(always)]
    pub(super) fn light<S: Simd>(&self, simd: S, shape: &Shape, scratch: &mut InstanceScratch) {
        let count = shape.normals[0].len();
        scratch.rgb.iter_mut().for_each(|channel| channel.resize(count, 0.0));
        let [x, y, z] = &shape.normals;
        for begin in (0..count).step_by(LANES) {
            let normal = [load(simd, x, begin), load(simd, y, begin), load(simd, z, begin)];
            let light = self.light_at(simd, normal);
            for (i, channel) in scratch.rgb.iter_mut().enumerate() {
                let [emissive, diffuse] = [self.emissive[i], self.diffuse[i]];
                store(channel, begin, lit_channel(F::splat(simd, emissive), F::splat(simd, diffuse), light));
            }
        }
    }

    /// How much light falls on surfaces of these normals in the solid's frame.
    #[inline(always)]
    fn light_at<S: Simd>(&self, simd: S, [x, y, z]: [F<S>; 3]) -> F<S> {
        let none = F::splat(simd, 0.0);
        let Some(to_light) = self.transform.to_light else { return none };
        let turn = &self.transform.view_from_normal;
        let [x, y, z] = map(
            [0, 1, 2],
            #[inline(always)]
            |row| x * turn[(row, 0)] + y * turn[(row, 1)] + z * turn[(row, 2)],
        );
        let length = if self.transform.normalizes { (x * x + y * y + z * z).root() } else { F::splat(simd, 1.0) };
        let light = light_on_surface(x * to_light.x + y * to_light.y + z * to_light.z, length);
        length.simd_gt(0.0).select(light, none)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use nalgebra::{Matrix3, Vector3};
    use proptest::prelude::*;
    use rcs_camera::simd_levels::levels;
    use rcs_scene::{Material, Mesh, Vertex};

    use super::*;
    use crate::cpu::lighting::vertex_color;
    use crate::cpu::surface::Surface;

    fn normal() -> impl Strategy<Value = [f32; 3]> {
        let coordinate = || prop_oneof![-1.0..1.0_f32, Just(0.0)];
        [coordinate(), coordinate(), coordinate()]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn all_vertices_are_lit_as_each_by_itself(
            normals in proptest::collection::vec(normal(), 1..40),
            turn in proptest::array::uniform9(-2.0..2.0_f32),
            to_light in proptest::option::of(normal()),
            normalizes: bool,
            colors in proptest::array::uniform8(-0.2..1.2_f32),
        ) {
            let [r, g, b, a, er, eg, eb, ea] = colors;
            let mut material = Material::lit(Rgba::new(r, g, b, a));
            if let Lighting::Lit { emissive, .. } = &mut material.lighting {
                *emissive = Rgba::new(er, eg, eb, ea);
            }
            let vertices: Vec<Vertex> = normals.iter().map(|normal| Vertex::new([0.0; 3], *normal)).collect();
            let indices = (0..vertices.len() as u32).flat_map(|vertex| [vertex; 3]).collect();
            let mesh = Mesh { vertices, indices };
            let transform = ObjectTransform {
                clip_from_object: [[0.0; 4]; 4],
                view_from_normal: Matrix3::from_row_slice(&turn),
                normalizes,
                to_light: to_light.map(Vector3::from),
            };
            let surface = Surface::of(&material, None);
            let vertices = Vertices::Mesh(&mesh);
            let source = Source { vertices, material: &material, transform: &transform, surface: &surface };
            let shape = Shape::new(&mesh);
            let light = PlainLight::of(&shape, &source).unwrap();
            for level in levels() {
                let mut scratch = InstanceScratch::default();
                dispatch!(level, simd => light.light(simd, &shape, &mut scratch));
                for ([normal, ..], vertex) in shape.triangle_normals.iter().zip(&mesh.vertices) {
                    let [red, green, blue] = [0, 1, 2].map(|channel: usize| scratch.rgb[channel][*normal as usize]);
                    let lit = [red, green, blue, light.alpha()];
                    prop_assert_eq!(lit.map(f32::to_bits), vertex_color(&material, &transform, vertex).map(f32::to_bits));
                }
            }
        }
    }
}
