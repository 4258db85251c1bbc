//! A depth camera's cloud of any number of points: the wavy surface of `./bench`.

use nalgebra::{Matrix4, Point3, Vector3};
use rcs_messages::sensor_msgs::PointField;
use rcs_messages::PointCloud2;
use rcs_scene::{Drawable, Geometry, PointBuffer, PointColors, PointStyle, Points, RenderGroup};

/// Points of a depth camera's cloud.
pub const DEPTH_CAMERA_POINTS: usize = 640 * 480;

/// Side of a point in metres that covers about four pixels of a [`projector`](super::rendering::projector).
pub const SIDE_M: f32 = 0.004;

/// Bytes of a point in a [`message`]: x, y, z and rgb.
pub const POINT_STEP: u32 = 16;

/// Every style in the size of the benchmarks, with its name.
pub const STYLES: [(&str, PointStyle); 6] = [
    ("points", PointStyle::Points { diameter_px: 3.0 }),
    ("squares", PointStyle::Squares { size_m: [SIDE_M; 2] }),
    ("flat_squares", PointStyle::FlatSquares { side_m: SIDE_M }),
    ("spheres", PointStyle::Spheres { size_m: [SIDE_M; 2] }),
    ("boxes", PointStyle::Boxes { size_m: [SIDE_M; 3] }),
    ("tiles", PointStyle::Tiles { size_m: [SIDE_M; 2], normal: [0.0, 0.0, -1.0], up: [0.0, -1.0, 0.0] }),
];

/// `count` points row by row, the last row not always full, 1.5 m away and 1.7 m wide, in the depth camera's optical
/// frame.
pub fn positions(count: usize) -> Vec<[f32; 3]> {
    let columns = ((count as f64 * 4.0 / 3.0).sqrt().round() as usize).max(1);
    let rows = count.div_ceil(columns);
    let share = |i: usize, of: usize| (i as f64 + 0.5) / of as f64 - 0.5;
    let point = |row: usize, column: usize| {
        let (u, v) = (share(column, columns), share(row, rows));
        let z = 1.5 + 0.1 * (16.0 * u).sin() * (16.0 * v).cos();
        [(1.12 * u * z) as f32, (0.84 * v * z) as f32, z as f32]
    };
    (0..rows).flat_map(|row| (0..columns).map(move |column| point(row, column))).take(count).collect()
}

/// A colour that differs from point to point and from cloud to cloud.
fn color(point: usize, cloud: usize) -> [u8; 4] {
    [(point % 251) as u8, (point / 640 % 256) as u8, (90 + 40 * cloud) as u8, 255]
}

/// The points in the order of the camera's rows.
pub fn in_rows(count: usize) -> PointBuffer {
    let positions = positions(count);
    let colors = (0..positions.len()).map(|i| color(i, 0)).collect();
    PointBuffer { positions, colors: PointColors::PerPoint(colors) }
}

/// The same points in an order that is independent of where they are.
pub fn shuffled(count: usize) -> PointBuffer {
    let buffer = in_rows(count);
    let count = buffer.positions.len();
    // A step that shares no factor with the count visits every point once.
    let order = (0..count).map(|i| (i * 100_003) % count);
    PointBuffer {
        positions: order.clone().filter_map(|i| buffer.positions.get(i).copied()).collect(),
        colors: PointColors::PerPoint(order.map(|i| buffer.colors.get(i)).collect()),
    }
}

/// The cloud as a message, in a frame. Clouds of different `number` have points of different colors, and another one in
/// 64 of them is NaN, as where a depth camera measures nothing.
pub fn message(frame: &str, count: usize, number: usize) -> PointCloud2 {
    let mut positions = positions(count);
    for position in positions.iter_mut().skip(number % 64).step_by(64) {
        *position = [f32::NAN; 3];
    }
    let point = |(i, [x, y, z]): (usize, &[f32; 3])| {
        let [r, g, b, _] = color(i, number);
        [x.to_le_bytes(), y.to_le_bytes(), z.to_le_bytes(), [b, g, r, 0]].concat()
    };
    let data: Vec<u8> = positions.iter().enumerate().flat_map(point).collect();
    let mut cloud = PointCloud2::default();
    cloud.header.frame_id = frame.to_owned();
    (cloud.height, cloud.width) = (1, positions.len() as u32);
    (cloud.point_step, cloud.row_step) = (POINT_STEP, data.len() as u32);
    cloud.fields = (0..)
        .zip(["x", "y", "z", "rgb"])
        .map(|(i, name)| PointField { name: name.to_owned(), offset: 4 * i, datatype: PointField::FLOAT32, count: 1 })
        .collect();
    cloud.with_data(data)
}

/// A cloud as a display makes it, five centimetres to the left of the camera.
pub fn drawable(buffer: PointBuffer, style: PointStyle) -> Drawable {
    let points = Points { buffer: buffer.into(), style, alpha: 1.0, blended: false, auto_size: false };
    Drawable {
        display: 0,
        fixed_from_object: Matrix4::new_translation(&Vector3::new(-0.05, 0.0, 0.0)),
        sort_point: Point3::origin(),
        group: RenderGroup::Main,
        geometry: Geometry::Points(points),
    }
}
