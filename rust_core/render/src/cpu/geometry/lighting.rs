//! The colour of a mesh's vertex.
//!
//! OpenGL's fixed-function lighting as rviz sets it up; its formulas are in [`shading`](crate::shading). A face is lit
//! by its front's normal from both sides.

use nalgebra::Vector3;
use rcs_scene::{Lighting, Material, Vertex};

use crate::cpu::tile::screen::ObjectTransform;
use crate::shading::{light_on_surface, lit_channel};

/// Red, green, blue and alpha of a vertex, each 0 to 1.
pub(in crate::cpu) fn vertex_color(material: &Material, transform: &ObjectTransform, vertex: &Vertex) -> [f32; 4] {
    let own = || vertex.color.map(|c| f32::from(c) / 255.0);
    match &material.lighting {
        Lighting::Unlit if material.vertex_colors => own(),
        Lighting::Unlit => [1.0; 4],
        Lighting::Lit { diffuse, emissive } => {
            let diffuse = if material.vertex_colors { own() } else { diffuse.to_array() };
            let emissive = emissive.to_array();
            let light = light_at(transform, vertex.normal);
            let channel = |i: usize| lit_channel(emissive[i], diffuse[i], light);
            [channel(0), channel(1), channel(2), diffuse[3].clamp(0.0, 1.0)]
        }
    }
}

/// The light that falls on a surface of this normal in the object's frame.
fn light_at(transform: &ObjectTransform, normal: [f32; 3]) -> f32 {
    let Some(to_light) = transform.to_light else { return 0.0 };
    let normal = transform.view_from_normal * Vector3::from(normal);
    let length = if transform.normalizes { normal.norm() } else { 1.0 };
    if length > 0.0 {
        light_on_surface(normal.dot(&to_light), length)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry3, Matrix4};
    use rcs_scene::{Camera, DirectionalLight, Intrinsics, Rgba};

    fn lit(fixed_from_object: &Matrix4<f64>, normal: [f32; 3], emissive: Rgba) -> [f32; 4] {
        let p = [100.0, 0.0, 50.0, 0.0, 0.0, 100.0, 50.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let camera = Camera::new(Intrinsics::from_p(100, 100, &p).unwrap(), &Isometry3::identity(), 0.01);
        let view_from_object = camera.fixed_from_view().inverse().to_homogeneous() * fixed_from_object;
        let light = DirectionalLight { direction: Vector3::new(0.0, 0.0, -1.0) };
        let transform = ObjectTransform::new(&camera, &view_from_object, Some(&light));
        let mut material = Material::lit(Rgba::new(1.0, 0.5, 0.0, 0.25));
        if let Lighting::Lit { emissive: e, .. } = &mut material.lighting {
            *e = emissive;
        }
        vertex_color(&material, &transform, &Vertex::new([0.0; 3], normal))
    }

    #[test]
    fn brightness_is_the_cosine_to_the_light() {
        let close =
            |a: [f32; 4], b: [f32; 4]| assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
        let identity = Matrix4::identity();
        close(lit(&identity, [0.0, 0.0, 1.0], Rgba::TRANSPARENT), [1.0, 0.5, 0.0, 0.25]);
        close(lit(&identity, [0.0, 0.6, 0.8], Rgba::TRANSPARENT), [0.8, 0.4, 0.0, 0.25]);
        close(lit(&identity, [0.0, 0.0, -1.0], Rgba::TRANSPARENT), [0.0, 0.0, 0.0, 0.25]);
        close(lit(&identity, [0.0; 3], Rgba::new(0.1, 0.7, 0.2, 1.0)), [0.1, 0.7, 0.2, 0.25]);
        close(lit(&identity, [0.0, 0.0, 1.0], Rgba::new(0.1, 0.7, 0.2, 1.0)), [1.0, 1.0, 0.2, 0.25]);
    }

    #[test]
    fn normals_are_brought_to_unit_length_where_the_object_is_scaled() {
        let [r, ..] = lit(&Matrix4::identity(), [0.0, 0.0, 0.5], Rgba::TRANSPARENT);
        assert_eq!(r, 0.5);
        let [r, ..] = lit(&Matrix4::new_scaling(2.0), [0.0, 0.0, 0.5], Rgba::TRANSPARENT);
        assert_eq!(r, 1.0);
    }

    #[test]
    fn normals_follow_an_uneven_scale_and_stay_where_it_is_zero() {
        let squeezed = Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, 1.0, 0.5));
        let [r, ..] = lit(&squeezed, [0.0, 0.6, 0.8], Rgba::TRANSPARENT);
        let expected = 1.6 / (0.36f32 + 2.56).sqrt();
        assert!((r - expected).abs() < 1e-6);
        // The view direction is z, so that the light comes from behind the view frame's z.
        let flat = Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, 1.0, 0.0));
        assert_eq!(lit(&flat, [0.0, 0.0, 1.0], Rgba::TRANSPARENT), [0.0, 0.0, 0.0, 0.25]);
        assert_eq!(lit(&flat, [0.0, 0.0, -1.0], Rgba::TRANSPARENT), [1.0, 0.5, 0.0, 0.25]);
    }
}
