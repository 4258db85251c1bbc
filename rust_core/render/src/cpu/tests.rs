//! A renderer that has panicked, and how many threads draw an image.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Point3};
use rcs_scene::{
    Camera, DisplayMask, Drawable, Encoding, Geometry, Image, Intrinsics, Material, Mesh, RenderGroup, Scene, Vertex,
};

use super::CpuRenderer;
use crate::{Finished, RenderError, Renderer, View};

/// A triangle over the image's middle.
fn triangle() -> Scene {
    let vertices = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [0.0, 1.0, 2.0]].map(|at| Vertex::new(at, [0.0, 0.0, -1.0]));
    let mesh = Arc::new(Mesh { vertices: vertices.to_vec(), indices: vec![0, 2, 1, 0, 1, 2] });
    let material = Arc::new(Material::unlit(false));
    let geometry = Geometry::Mesh { mesh, material };
    let (fixed_from_object, sort_point) = (Matrix4::identity(), Point3::origin());
    let drawable = Drawable { display: 0, fixed_from_object, sort_point, group: RenderGroup::Main, geometry };
    Scene { drawables: vec![drawable], light: None }
}

fn camera() -> Camera {
    let p = [20.0, 0.0, 16.0, 0.0, 0.0, 20.0, 12.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    Camera::new(Intrinsics::from_p(32, 24, &p).unwrap(), &Isometry3::identity(), 0.01)
}

#[test]
fn a_small_image_wakes_no_threads() {
    let (scene, visible, camera) = (triangle(), DisplayMask::all(), camera());
    let view = View { scene: &scene, camera: &camera, visible: &visible, background: [9; 3], encoding: Encoding::Rgb8 };
    let draw = |mut renderer: CpuRenderer| {
        let mut image = Image::default();
        renderer.render(&view, &mut image).unwrap();
        (renderer, image)
    };
    let (all, of_all) = draw(CpuRenderer::with_threads(4));
    let (few, of_few) = draw(CpuRenderer::with_up_to(4));
    assert_eq!((all.active, few.active), (4, 1));
    assert_eq!(of_all.data, of_few.data);
    let few = CpuRenderer::with_up_to(16);
    assert_eq!([0, 1, 10, 1000].map(|jobs| few.paying_workers(jobs)), [1, 1, 4, 16]);
}

#[test]
fn a_panic_is_an_error_and_the_next_image_is_drawn() {
    for threads in [1, 2] {
        let (scene, visible, camera) = (triangle(), DisplayMask::all(), camera());
        let view =
            View { scene: &scene, camera: &camera, visible: &visible, background: [9; 3], encoding: Encoding::Rgb8 };
        let mut renderer = CpuRenderer::with_threads(threads);
        let (mut before, mut after) = (Image::default(), Image::default());
        renderer.render(&view, &mut before).unwrap();
        assert_ne!(before.data, [9].repeat(32 * 24 * 3));

        // One that was drawn before is still to be had.
        renderer.submit(&view).unwrap();
        renderer.panics_next = true;
        let error = renderer.submit(&view).unwrap_err();
        assert!(matches!(error, RenderError::Panicked { .. }));
        assert!(error.to_string().starts_with(&format!("cpu ({threads} thread")), "{error}");
        assert_eq!(renderer.finish(&mut after).unwrap(), Finished::Drawn);
        assert_eq!(after.data, before.data);
        assert_eq!(renderer.finish(&mut after).unwrap(), Finished::NoneInFlight);

        renderer.render(&view, &mut after).unwrap();
        assert_eq!(after.data, before.data);
    }
}
