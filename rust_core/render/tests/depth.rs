//! How far away is what an image shows: both renderers write the depths of a slanted wall, through a lens, too.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Point3};
use rcs_render::{create, DepthRequest, Depths, Finished, RendererChoice, View};
use rcs_scene::{
    Camera, DepthImage, DisplayMask, Drawable, Encoding, Geometry, Image, Intrinsics, Material, Mesh, PixelMap,
    RenderGroup, Rgba, Scene, Vertex,
};

const SIZE: [u32; 2] = [80, 60];
const F: f64 = 70.0;
const CX: f64 = 38.0;
const CY: f64 = 31.0;

/// A wall z = 2 + 0.5 x of the optical frame, whose left edge is at x = −0.4.
fn wall() -> Scene {
    let corner = |x: f32, y: f32| Vertex::new([x, y, 2.0 + 0.5 * x], [0.0, 0.0, -1.0]);
    let vertices = vec![corner(-0.4, -9.0), corner(9.0, -9.0), corner(9.0, 9.0), corner(-0.4, 9.0)];
    let mesh = Arc::new(Mesh { vertices, indices: vec![0, 1, 2, 0, 2, 3, 0, 2, 1, 0, 3, 2] });
    let wall = Drawable {
        display: 0,
        fixed_from_object: Matrix4::identity(),
        sort_point: Point3::origin(),
        group: RenderGroup::Main,
        geometry: Geometry::Mesh { mesh, material: Arc::new(Material::lit(Rgba::WHITE)) },
    };
    Scene { drawables: vec![wall], light: None }
}

/// The wall's depth at a place in what is drawn; none beside its edge.
fn depth_at([u, v]: [f64; 2]) -> Option<f64> {
    let _ = v;
    let x = (u - CX) / F;
    let depth = 2.0 / (1.0 - 0.5 * x);
    (depth * x > -0.4).then_some(depth)
}

fn depths(choice: RendererChoice, camera: &Camera) -> DepthImage {
    let (scene, visible) = (wall(), DisplayMask::all());
    let view = View { scene: &scene, camera, visible: &visible, background: [0; 3], encoding: Encoding::Rgb8 };
    let mut renderer = create(choice).unwrap();
    let (mut depths, mut image, mut alone) = (Depths::default(), Image::default(), Image::default());
    renderer.submit_with_depths(&view, &DepthRequest { opaque: true, objects_of: Some(&visible) }).unwrap();
    assert_eq!(renderer.finish_with_depths(&mut image, &mut depths).unwrap(), Finished::Drawn);
    renderer.render(&view, &mut alone).unwrap();
    assert_eq!(image, alone, "the picture is the same");
    let [opaque, objects] = [&depths.opaque, &depths.objects]
        .map(|depth| depth.depths_m.iter().map(|depth_m| depth_m.to_bits()).collect::<Vec<_>>());
    assert_eq!(opaque, objects, "there is nothing else");
    depths.opaque
}

fn camera(size: [u32; 2], [left, top]: [f64; 2]) -> Camera {
    let p = [F, 0.0, CX - left, 0.0, 0.0, F, CY - top, 0.0, 0.0, 0.0, 1.0, 0.0];
    Camera::new(Intrinsics::from_p(size[0], size[1], &p).unwrap().as_p_means(), &Isometry3::identity(), 0.01)
}

/// Asserts that each pixel has the depth at its place, but for those beside the wall's edge.
fn assert_wall(depths: &DepthImage, place: impl Fn([f64; 2]) -> [f64; 2]) {
    assert_eq!([depths.width_px, depths.height_px], SIZE);
    let (mut on_wall, mut beside) = (0, 0);
    for (at, depth) in (0..).zip(&depths.depths_m) {
        let place = place([at % SIZE[0], at / SIZE[0]].map(f64::from));
        let around = [-1.5, 0.0, 1.5].map(|step| depth_at([place[0] + step, place[1]]));
        match around {
            [Some(low), Some(_), Some(high)] => {
                on_wall += 1;
                let depth = f64::from(*depth);
                assert!((low - 1e-3..high + 1e-3).contains(&depth), "{place:?}: {depth}, not {low} to {high}");
            }
            [None, None, None] => {
                beside += 1;
                assert!(depth.is_nan(), "{place:?}: {depth}");
            }
            _ => {}
        }
    }
    assert!(on_wall > 1000 && beside > 500, "{on_wall} {beside}");
}

#[test]
fn depths_are_metres_along_the_optical_axis_and_nan_where_nothing_is() {
    for choice in [RendererChoice::Cpu, RendererChoice::Gpu] {
        let depths = depths(choice, &camera(SIZE, [0.0; 2]));
        assert_wall(&depths, |pixel| pixel);
        // In the middle of a pixel, it is exact.
        let at = (20 * SIZE[0] + 50) as usize;
        assert!((f64::from(depths.depths_m[at]) - depth_at([50.0, 20.0]).unwrap()).abs() < 1e-4);
    }
}

#[test]
fn behind_a_lens_a_pixel_has_the_depth_of_the_nearest_place() {
    let place = |[u, v]: [f64; 2]| {
        let (x, y) = ((u - CX) / F, (v - CY) / F);
        let scale = 1.0 + 0.2 * (x * x + y * y);
        [CX + F * x * scale, CY + F * y * scale]
    };
    let map = Arc::new(PixelMap::new(SIZE, |pixel| Some(place(pixel))).unwrap());
    let camera = camera(map.source_size_px(), map.source_origin_px().map(f64::from)).with_lens(map);
    for choice in [RendererChoice::Cpu, RendererChoice::Gpu] {
        assert_wall(&depths(choice, &camera), place);
    }
}
