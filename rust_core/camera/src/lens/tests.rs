//! Warped images, and equality of all ways of computing them.

use proptest::prelude::*;

use super::*;
use crate::simd_levels::levels;

fn drawn(width_px: u32, height_px: u32, color: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    let mut image = Image::default();
    image.reset(width_px, height_px, Encoding::Rgba8);
    let pixels = (0..height_px).flat_map(|y| (0..width_px).map(move |x| (x, y)));
    image.data = pixels.flat_map(|(x, y)| color(x, y)).collect();
    image
}

fn seen(map: &PixelMap, drawn: &Image, encoding: Encoding) -> Image {
    let mut image = Image::default();
    see_through(map, drawn, [1, 2, 3], encoding, &mut image);
    image
}

#[test]
fn colours_between_pixels_are_interpolated() {
    let map = PixelMap::new([20, 10], |[u, v]| Some([u + 0.25, v + 0.5])).unwrap();
    let [width, height] = map.source_size_px();
    let source = drawn(width, height, |x, y| [(4 * x) as u8, (10 * y) as u8, 200, 255]);
    let image = seen(&map, &source, Encoding::Rgb8);
    let [left, top] = map.source_origin_px();
    for (at, pixel) in image.data.as_chunks::<3>().0.iter().enumerate() {
        let (x, y) = ((at % 20) as i32 - left, (at / 20) as i32 - top);
        assert_eq!(*pixel, [(4 * x + 1) as u8, (10 * y + 5) as u8, 200]);
    }
}

#[test]
fn depths_are_those_of_the_nearest_pixel_and_never_between_two() {
    let map = PixelMap::new([20, 10], |[u, v]| (u < 15.0).then_some([u + 0.4, v + 0.6])).unwrap();
    let [width, height] = map.source_size_px();
    let mut drawn = DepthImage::default();
    drawn.reset(width, height);
    for (at, depth) in (0..).zip(&mut drawn.depths_m) {
        *depth = if (at % width + at / width) % 2 == 0 { 1.0 } else { 9.0 };
    }
    let mut seen = DepthImage::default();
    see_depth_through(&map, &drawn, &mut seen);
    let [left, top] = map.source_origin_px();
    for (at, depth) in seen.depths_m.iter().enumerate() {
        let (x, y) = ((at % 20) as i32 - left, (at / 20) as i32 + 1 - top);
        match at % 20 {
            0..15 => assert_eq!(*depth, if (x + y) % 2 == 0 { 1.0 } else { 9.0 }, "{at}"),
            _ => assert!(depth.is_nan()),
        }
    }
}

#[test]
fn an_even_surface_keeps_its_colour_and_the_rest_is_background() {
    let place = |[u, v]: [f64; 2]| (u < 12.0).then_some([1.1 * u, 0.93 * v + 0.37]);
    let map = PixelMap::new([33, 21], place).unwrap();
    let [width, height] = map.source_size_px();
    let source = drawn(width, height, |_, _| [10, 255, 99, 255]);
    for encoding in Encoding::ALL {
        let image = seen(&map, &source, encoding);
        assert_eq!((image.width_px, image.height_px), (33, 21));
        let cell = encoding.bytes_per_pixel();
        let mut colors = [vec![0; cell], vec![0; cell]];
        encoding.write_row(&[[10, 255, 99, 255]], &mut colors[0]);
        encoding.write_row(&[[1, 2, 3, 255]], &mut colors[1]);
        for (at, pixel) in image.data.chunks(cell).enumerate() {
            assert_eq!(pixel, colors[usize::from(at % 33 >= 12)], "{encoding:?}, {at}");
        }
    }
}

/// Runs that follow the source's pixels, and runs that leave out, repeat, mirror or turn them.
fn runs() -> impl Strategy<Value = MapRun> {
    let near = |middle: i32, off: i32| middle - off..middle + off;
    let step = prop_oneof![
        4 => [near(65536, 2000), near(0, 2000)],
        1 => [near(65536, 60000), near(0, 60000)],
        1 => [near(0, 90000), near(0, 90000)],
    ];
    // With seven steps of up to 90000 in each direction, all places are in a source of 40×24 pixels.
    let place = [10 << 16..28_i32 << 16, 11 << 16..13_i32 << 16];
    (place, step).prop_map(|(place, step)| MapRun { place, step })
}

/// Any pixels, and pixels of which most are as their neighbours.
fn sources() -> impl Strategy<Value = Vec<u8>> {
    const PIXELS: usize = 40 * 24;
    let noise = proptest::collection::vec(any::<[u8; 4]>(), PIXELS);
    let speckles = proptest::collection::vec(prop_oneof![9 => Just([0, 0, 0, 255]), 1 => any::<[u8; 4]>()], PIXELS);
    prop_oneof![noise, speckles].prop_map(|pixels| pixels.concat())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn eight_pixels_at_once_are_as_one_by_one(runs in proptest::collection::vec(runs(), 20), data in sources()) {
        let drawn = Image { width_px: 40, height_px: 24, encoding: Encoding::Rgba8, data };
        let source = Source::new(&drawn);
        for run in runs {
            let mut singly = [[0; 4]; MapRun::PIXELS];
            source.write_singly(run, &mut singly);
            for level in levels() {
                let mut at_once = [[0; 4]; MapRun::PIXELS];
                let written = dispatch!(level, simd => eight::write(simd, &source, run, &mut at_once));
                prop_assert!(written.is_some());
                prop_assert_eq!(at_once, singly, "{:?}, {:?}", level, run);
            }
        }
    }
}

#[test]
fn the_first_and_the_last_pixels_of_the_source_are_seen() {
    // A source that is as small as it can be: eight pixels beginning with its last ones do not fit.
    let map = PixelMap::new([19, 5], |[u, v]| Some([u * 0.6, v * 0.9 + 0.25])).unwrap();
    let [width, height] = map.source_size_px();
    let source = drawn(width, height, |x, y| [(10 * x) as u8, (20 * y) as u8, 0, 255]);
    let image = seen(&map, &source, Encoding::Rgba8);
    let [left, top] = map.source_origin_px().map(f64::from);
    for (at, pixel) in image.data.as_chunks::<4>().0.iter().enumerate() {
        let (u, v) = ((at % 19) as f64, (at / 19) as f64);
        let expected = [10.0 * (u * 0.6 - left), 20.0 * (v * 0.9 + 0.25 - top)];
        for (level, expected) in pixel.iter().zip(expected) {
            assert!((f64::from(*level) - expected).abs() < 1.0, "{pixel:?} instead of {expected:?} at {u}, {v}");
        }
    }
}
