//! The whole interface in tests small enough for Miri; `tests/c` has more, in C.

use std::ffi::c_char;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use crate::*;

const D: [f64; 5] = [-0.2, 0.03, 0.001, -0.002, 0.0];

/// A CameraInfo of 16×8 pixels with a lens.
fn info() -> RcsCameraInfo {
    RcsCameraInfo {
        width: 16,
        height: 8,
        distortion_model: c"plumb_bob".as_ptr(),
        d: D.as_ptr(),
        d_length: D.len(),
        k: [20.0, 0.0, 8.0, 0.0, 20.0, 4.0, 0.0, 0.0, 1.0],
        r: [0.0; 9],
        p: [20.0, 0.0, 8.0, 0.0, 0.0, 20.0, 4.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        binning_x: 0,
        binning_y: 0,
        roi_x_offset: 0,
        roi_y_offset: 0,
        roi_width: 0,
        roi_height: 0,
    }
}

/// A camera with that CameraInfo, and its view.
fn camera(undistort: bool) -> (Box<RcsCamera>, RcsView) {
    camera_of(&info(), RcsProjection::Rviz, undistort)
}

/// Like `camera`, with another CameraInfo.
fn camera_of(info: &RcsCameraInfo, projection: RcsProjection, undistort: bool) -> (Box<RcsCamera>, RcsView) {
    let mut camera = rcs_camera_new().unwrap();
    let view = set_info(&mut camera, info, ProjectionNumber(projection as u32), Flag(u8::from(undistort))).unwrap();
    (camera, view)
}

fn set_info(
    camera: &mut RcsCamera,
    info: &RcsCameraInfo,
    projection: ProjectionNumber,
    undistort: Flag,
) -> Result<RcsView, RcsResult> {
    let mut view = MaybeUninit::uninit();
    // SAFETY: all pointers are valid, and the view is read only where it was written.
    unsafe {
        match rcs_camera_set_info(Some(camera), Some(info), projection, undistort, 0.1, Some(&mut view)) {
            RcsResult::Ok => Ok(view.assume_init()),
            failed => Err(failed),
        }
    }
}

/// The published image in mono8, and the depths, of pixels and depths that are all different.
fn published(camera: &mut RcsCamera, view: &RcsView) -> (Vec<u8>, Vec<f32>) {
    let size = view.drawn_width as usize * view.drawn_height as usize;
    let data: Vec<u8> = (0..size).flat_map(|i| [i as u8; 4]).collect();
    let pixels = RcsPixels {
        data: data.as_ptr(),
        length: data.len(),
        width: view.drawn_width,
        height: view.drawn_height,
        row_bytes: 4 * view.drawn_width as usize,
        order: PixelOrderNumber(RcsPixelOrder::Rgba as u32),
        bottom_up: Flag(1),
    };
    let depths: Vec<f32> = (0..size).map(|i| i as f32 / (2 * size) as f32).collect();
    let (mut image, mut metres) = (vec![0; 16 * 8], vec![0.0; 16 * 8]);
    let (encoding, background) = (EncodingNumber(RcsEncoding::Mono8 as u32), [0_u8; 3]);
    // SAFETY: all pointers and lengths are valid.
    let results = unsafe {
        [
            rcs_camera_encode(
                Some(&mut *camera),
                Some(&pixels),
                encoding,
                background.as_ptr(),
                image.as_mut_ptr(),
                image.len(),
            ),
            rcs_camera_encode_depth(
                Some(camera),
                depths.as_ptr(),
                depths.len(),
                Flag(1),
                metres.as_mut_ptr(),
                metres.len(),
            ),
        ]
    };
    assert_eq!(results, [RcsResult::Ok; 2]);
    (image, metres)
}

/// Rows and columns exchanged as a mirror does.
fn flipped<T: Copy>(pixels: &[T], [is_left_right, is_up_down]: [bool; 2]) -> Vec<T> {
    let pixel = |row: usize, column: usize| {
        let row = if is_up_down { 7 - row } else { row };
        pixels[row * 16 + if is_left_right { 15 - column } else { column }]
    };
    (0..8).flat_map(|row| (0..16).map(move |column| pixel(row, column))).collect()
}

#[test]
fn a_mirrored_camera_info_is_drawn_without_the_mirror_and_published_with_it() {
    for undistort in [false, true] {
        let mut straight = camera_of(&info(), RcsProjection::Exact, undistort);
        let expected = published(&mut straight.0, &straight.1);
        for [is_left_right, is_up_down] in [[true, false], [false, true], [true, true]] {
            let mut mirrored = info();
            if is_left_right {
                (mirrored.p[0], mirrored.p[2]) = (-20.0, 7.0);
                (mirrored.k[0], mirrored.k[2]) = (-20.0, 7.0);
            }
            if is_up_down {
                (mirrored.p[5], mirrored.p[6]) = (-20.0, 3.0);
                (mirrored.k[4], mirrored.k[5]) = (-20.0, 3.0);
            }
            let (mut camera, view) = camera_of(&mirrored, RcsProjection::Exact, undistort);
            assert_eq!(view, straight.1, "{is_left_right} {is_up_down}");
            let (image, metres) = published(&mut camera, &view);
            assert_eq!(image, flipped(&expected.0, [is_left_right, is_up_down]));
            let bits = |metres: &[f32]| metres.iter().map(|metres| metres.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&metres), bits(&flipped(&expected.1, [is_left_right, is_up_down])));
        }
    }
}

#[test]
fn skew_scale_third_row_and_binning_are_followed_or_told_as_the_node_does() {
    let mut unusual = info();
    unusual.p[1] = 2.0;
    let (mut one, skewed) = camera_of(&unusual, RcsProjection::Exact, false);
    // u = 2 s y / W in clip coordinates, y up.
    assert_eq!(skewed.clip_from_view[1], -2.0 * 2.0 / 16.0);
    unusual.p = unusual.p.map(|value| value * 3.0);
    let (_, scaled) = camera_of(&unusual, RcsProjection::Exact, false);
    assert_eq!(scaled, skewed);
    unusual.binning_x = 4;
    let (three, as_rviz) = camera_of(&unusual, RcsProjection::Rviz, false);
    assert_eq!(as_rviz.clip_from_view[1], 0.0);
    // SAFETY: lengths are that of the buffer.
    let warning = text(|buffer, length| unsafe { rcs_camera_warning(Some(&*three), buffer, length) });
    for part in ["the third row of P is [0.0, 0.0, 3.0, 0.0]", "P[1] is 6 (a skew)", "binning 4x0 not applied"] {
        assert!(warning.contains(part), "{warning}");
    }
    unusual.p[10] = 0.0;
    let refused = set_info(&mut one, &unusual, ProjectionNumber(1), Flag(0));
    assert_eq!(refused, Err(RcsResult::BadCameraInfo));
    // SAFETY: lengths are that of the buffer.
    let error = text(|buffer, length| unsafe { rcs_last_error(buffer, length) });
    assert!(error.starts_with("the third row of P, P[8] to P[11], is [0.0, 0.0, 0.0, 0.0]"), "{error}");
}

/// The text that a function writes.
fn text(write: impl Fn(*mut c_char, usize) -> usize) -> String {
    let mut buffer = vec![b'#'; write(null_mut(), 0) + 1];
    let length = write(buffer.as_mut_ptr().cast(), buffer.len());
    assert_eq!(buffer.pop(), Some(0));
    assert_eq!(buffer.len(), length);
    String::from_utf8(buffer).unwrap()
}

#[test]
fn a_image_is_converted_with_and_without_a_lens() {
    for undistort in [false, true] {
        let (mut camera, view) = camera(undistort);
        let camera = Some(&mut *camera);
        assert_eq!((view.image_width, view.image_height), (16, 8));
        assert_eq!(view.drawn_width > 16, undistort);
        let data = [10, 20, 30, 40].repeat(view.drawn_width as usize * view.drawn_height as usize);
        let pixels = RcsPixels {
            data: data.as_ptr(),
            length: data.len(),
            width: view.drawn_width,
            height: view.drawn_height,
            row_bytes: 4 * view.drawn_width as usize,
            order: PixelOrderNumber(RcsPixelOrder::Bgra as u32),
            bottom_up: Flag(1),
        };
        let (mut out, background) = ([0; 16 * 8 * 3], [30_u8, 20, 10]);
        let encoding = EncodingNumber(RcsEncoding::Rgb8 as u32);
        // SAFETY: all pointers and lengths are valid.
        let result = unsafe {
            rcs_camera_encode(camera, Some(&pixels), encoding, background.as_ptr(), out.as_mut_ptr(), out.len())
        };
        assert_eq!(result, RcsResult::Ok);
        assert!(out.as_chunks::<3>().0.iter().all(|pixel| *pixel == [30, 20, 10]), "{out:?}");
    }
}

#[test]
fn depths_are_converted_with_and_without_a_lens() {
    for undistort in [false, true] {
        let (mut camera, view) = camera(undistort);
        let camera = Some(&mut *camera);
        let depth = vec![0.0; view.drawn_width as usize * view.drawn_height as usize];
        let mut out = [0.0; 16 * 8];
        // SAFETY: all pointers and lengths are valid.
        let result = unsafe {
            rcs_camera_encode_depth(camera, depth.as_ptr(), depth.len(), Flag(0), out.as_mut_ptr(), out.len())
        };
        assert_eq!(result, RcsResult::Ok);
        assert!(out.iter().all(|depth| (*depth - 0.1).abs() < 1e-6 || depth.is_nan()), "{out:?}");
    }
}

#[test]
fn nothing_is_read_or_written_behind_null() {
    rcs_camera_free(None);
    rcs_camera_clear_info(None);
    rcs_camera_trigger(None);
    assert!(!rcs_camera_due(None, 0, Flag(1)));
    assert_eq!(rcs_camera_record(None, None), RcsResult::NullPointer);
    // SAFETY: NULL is refused.
    unsafe {
        assert_eq!(
            rcs_camera_set_info(None, Some(&info()), ProjectionNumber(0), Flag(1), 0.1, None),
            RcsResult::NullPointer
        );
        assert_eq!(rcs_camera_statistics(None, 0, null_mut(), 0), 0);
        assert_eq!(rcs_encoding_from_name(null(), None), RcsResult::NullPointer);
    }
    // SAFETY: lengths are that of the buffer.
    assert_eq!(text(|buffer, length| unsafe { rcs_last_error(buffer, length) }), "name is NULL");
}

#[test]
fn images_are_paced_and_counted() {
    let mut camera = rcs_camera_new();
    rcs_camera_set_frame_rate(camera.as_deref_mut(), 10.0);
    assert!(rcs_camera_due(camera.as_deref_mut(), 0, Flag(1)));
    rcs_camera_begin(camera.as_deref_mut(), 0);
    assert!(!rcs_camera_due(camera.as_deref_mut(), 20_000_000, Flag(1)));
    rcs_camera_trigger(camera.as_deref_mut());
    assert!(rcs_camera_due(camera.as_deref_mut(), 21_000_000, Flag(0)));
    let times = RcsTimes { begun_ns: 0, drawn_ns: 1_000_000, read_ns: 3_000_000, published_ns: 6_000_000 };
    assert_eq!(rcs_camera_record(camera.as_deref_mut(), Some(&times)), RcsResult::Ok);
    // SAFETY: lengths are that of the buffer.
    let line = text(|buffer, length| unsafe { rcs_camera_statistics(camera.as_deref(), 7_000_000, buffer, length) });
    assert!(line.starts_with("- pictures/s; median / p95 ms of the last 1: draw 1.00 / 1.00"), "{line}");
    rcs_camera_free(camera);
}

#[test]
fn a_config_is_reported() {
    let yaml = "Visualization Manager: {Displays: [{Class: my/Own, Name: it, Enabled: true}]}";
    let mut report = [1_u8; 40];
    let mut problems = RcsText { buffer: report.as_mut_ptr().cast(), length: 40, needed: 0 };
    let mut launch_line = RcsText { buffer: null_mut(), length: 0, needed: 0 };
    // SAFETY: all pointers and lengths are valid.
    let result = unsafe {
        let (report, launch_line) = (Some(&mut problems), Some(&mut launch_line));
        rcs_config_report(yaml.as_ptr().cast(), yaml.len(), c"a".as_ptr(), report, launch_line)
    };
    assert_eq!((result, report[39]), (RcsResult::Ok, 0));
    assert!(problems.needed > 100 && launch_line.needed > 80 && report.starts_with(b"no CameraPub display"));
}

#[test]
fn bad_numbers_from_c_are_refused() {
    for number in [2, u32::MAX] {
        let result = set_info(&mut RcsCamera::default(), &info(), ProjectionNumber(number), Flag(0));
        assert_eq!(result, Err(RcsResult::BadValue));
    }
}

/// Miri has its own names for threads.
#[test]
#[cfg_attr(miri, ignore)]
fn the_threads_that_a_lens_starts_have_names() {
    let _camera = camera(true);
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let names = tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok());
    let names: Vec<String> = names.collect();
    assert!(names.iter().any(|name| name == "draw-0\n"), "{names:?}");
}
