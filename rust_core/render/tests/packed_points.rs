//! Packed points look like the same points decoded, on both renderers.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::sync::Arc;

use common::{at, camera, draw, scene};
use nalgebra::{Isometry3, Vector3};
use rcs_render::{CpuRenderer, Finished, GpuRenderer, Renderer, View};
use rcs_scene::{
    AxisRainbow, DisplayMask, Encoding, Geometry, Image, PackedColors, PackedPoints, PointLook, PointStyle,
    PositionLayout,
};

/// Offsets of x and of the colour in these points.
const POSITION: usize = 4;
const COLOR: usize = 16;

/// Points of a wavy surface, a few of them without a finite position or out of view.
fn bytes(count: usize, stride: usize) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(count * stride);
    for i in 0..count {
        let (x, y) = ((i % 61) as f32 / 61.0 - 0.5, (i / 61 % 47) as f32 / 47.0 - 0.5);
        let mut position = [x, y, 0.2 * (9.0 * x).sin()];
        match i % 97 {
            0 => position[i % 3] = f32::NAN,
            1 => position[i % 3] = f32::NEG_INFINITY,
            2 => position[i % 3] = 1e9,
            _ => {}
        }
        let mut point = vec![0xee; stride];
        point[POSITION..POSITION + 12].copy_from_slice(bytemuck::cast_slice(&position.map(f32::to_le_bytes)));
        let color = (i as u32).wrapping_mul(0x9e37_79b1).to_le_bytes();
        point[COLOR..COLOR + 4].copy_from_slice(&color);
        bytes.extend(point);
    }
    bytes
}

fn packed(count: usize, stride: usize, colors: PackedColors, style: PointStyle) -> Arc<PackedPoints> {
    let look = PointLook { style, alpha: 1.0, blended: false, auto_size: false };
    let positions = PositionLayout::new([POSITION, POSITION + 4, POSITION + 8]);
    Arc::new(PackedPoints::new(Arc::new(bytes(count, stride)), stride, positions, colors, look).unwrap())
}

/// Images of packed points and of the same points decoded.
fn images(renderer: &mut dyn Renderer, packed: &Arc<PackedPoints>) -> [Image; 2] {
    let geometries = [Geometry::Packed(packed.clone()), Geometry::Points(packed.points().clone())];
    geometries.map(|geometry| draw(renderer, &scene([at(0.1, 0.0, 1.5, geometry)]), &camera(160, 120, 150.0)))
}

fn styles() -> [PointStyle; 6] {
    [
        PointStyle::Points { diameter_px: 3.0 },
        PointStyle::Squares { size_m: [0.02; 2] },
        PointStyle::FlatSquares { side_m: 0.02 },
        PointStyle::Spheres { size_m: [0.02; 2] },
        PointStyle::Boxes { size_m: [0.02; 3] },
        PointStyle::Tiles { size_m: [0.02; 2], normal: [0.0, 0.6, 0.8], up: [1.0, 0.0, 0.0] },
    ]
}

fn renderers() -> [Box<dyn Renderer>; 2] {
    [Box::new(CpuRenderer::with_threads(2)), Box::new(GpuRenderer::new(false).unwrap())]
}

#[test]
fn packed_points_look_like_decoded_ones() {
    let colors = [PackedColors::Uniform([250, 7, 130, 255]), PackedColors::Rgb { offset: COLOR }];
    for mut renderer in renderers() {
        for (i, style) in styles().into_iter().enumerate() {
            for (stride, colors) in [20, 32, 252].into_iter().flat_map(|stride| colors.map(|colors| (stride, colors))) {
                let [packed, decoded] = images(renderer.as_mut(), &packed(3000, stride, colors, style));
                assert!(packed.data.chunks_exact(4).filter(|pixel| pixel[..3] != [0; 3]).count() > 1000);
                // Drivers may round one colour for all points otherwise than a point's own.
                let most =
                    u8::from(matches!(colors, PackedColors::Uniform(_)) && !renderer.describe().starts_with("cpu"));
                let levels = packed.data.iter().zip(&decoded.data).map(|(a, b)| a.abs_diff(*b));
                assert!(
                    levels.max().unwrap() <= most,
                    "{}, style {i}, stride {stride}, {colors:?}",
                    renderer.describe()
                );
            }
        }
    }
}

#[test]
fn a_rainbow_on_the_gpu_differs_by_a_level_at_most() {
    let turned = Isometry3::new(Vector3::new(0.3, -0.2, 0.1), Vector3::new(0.4, 0.5, -0.6)).cast::<f32>();
    for (axis, fixed_from_object) in [(0, None), (2, None), (1, Some(turned))] {
        let colors = PackedColors::Axis(AxisRainbow::new(axis, fixed_from_object).between(-0.3, 0.4));
        let packed = packed(3000, 20, colors, PointStyle::Points { diameter_px: 2.0 });
        for mut renderer in renderers() {
            let [packed, decoded] = images(renderer.as_mut(), &packed);
            let levels = packed.data.iter().zip(&decoded.data).map(|(a, b)| a.abs_diff(*b));
            assert!(levels.max().unwrap() <= 1, "{}, axis {axis}", renderer.describe());
        }
    }
}

#[test]
fn a_cloud_of_several_buffers_is_whole() {
    let style = PointStyle::Points { diameter_px: 1.0 };
    let packed = packed(540_000, 252, PackedColors::Rgb { offset: COLOR }, style);
    assert!(packed.bytes().len() > 128 << 20);
    let mut gpu = GpuRenderer::new(false).unwrap();
    let [whole, decoded] = images(&mut gpu, &packed);
    assert!(whole == decoded);
}

#[test]
fn a_cloud_that_was_uploaded_while_another_is_drawn_is_not_uploaded_again() {
    let clouds = [[250, 7, 130, 255], [9, 200, 9, 255]].map(|color| {
        let packed = packed(3000, 20, PackedColors::Uniform(color), PointStyle::Points { diameter_px: 3.0 });
        scene([at(0.1, 0.0, 1.5, Geometry::Packed(packed))])
    });
    let (camera, visible) = (camera(160, 120, 150.0), DisplayMask::all());
    let view =
        |scene| View { scene, camera: &camera, visible: &visible, background: [0; 3], encoding: Encoding::Rgba8 };
    let mut gpu = GpuRenderer::new(false).unwrap();
    let expected = clouds.each_ref().map(|cloud| draw(&mut GpuRenderer::new(false).unwrap(), cloud, &camera));
    let mut image = Image::default();
    assert!(!gpu.can_upload(), "nothing is in flight");
    gpu.submit(&view(&clouds[0])).unwrap();
    assert!(gpu.can_upload());
    gpu.upload(&clouds[1], &visible);
    let uploads = gpu.stats().uploads;
    assert_eq!(gpu.finish(&mut image).unwrap(), Finished::Drawn);
    assert!(image == expected[0]);
    gpu.render(&view(&clouds[1]), &mut image).unwrap();
    assert!(image == expected[1]);
    assert_eq!(gpu.stats().uploads, uploads);
}
