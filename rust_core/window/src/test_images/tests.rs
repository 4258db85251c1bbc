//! The test images, pixel by pixel.

use super::canvas::{BLACK, WHITE};
use super::marks::{orientation_marks, OrientationMark};
use super::*;

const SIZES_PX: [[u32; 2]; 9] =
    [[1280, 800], [1024, 768], [1920, 1080], [3840, 2160], [854, 480], [320, 240], [800, 1280], [7, 3], [1, 1]];

fn at(image: &Image, u: u32, v: u32) -> u8 {
    image.data[(v * image.width_px + u) as usize]
}

#[test]
fn each_image_can_be_drawn_in_any_size() {
    for size_px in SIZES_PX {
        for test_image in TestImage::ALL {
            let image = test_image.draw(size_px, "a monitor with a name that is rather long");
            assert_eq!([image.width_px, image.height_px], size_px);
            assert_eq!(image.data.len(), (size_px[0] * size_px[1]) as usize, "{test_image:?} {size_px:?}");
        }
    }
}

#[test]
fn names_are_read_back_and_no_others() {
    for image in TestImage::ALL {
        assert_eq!(image.name().parse(), Ok(image));
    }
    assert_eq!("moire".parse::<TestImage>().unwrap_err().to_string(), "there is no test picture 'moire'");
}

#[test]
fn the_border_is_the_outermost_pixels_and_nothing_beside_them() {
    for size_px in [[1280, 800], [1024, 768], [641, 479]] {
        let image = TestImage::Border.draw(size_px, "");
        let [right, bottom] = size_px.map(|side| side - 1);
        for u in 0..=right {
            assert_eq!([at(&image, u, 0), at(&image, u, bottom)], [WHITE; 2]);
        }
        for v in 0..=bottom {
            assert_eq!([at(&image, 0, v), at(&image, right, v)], [WHITE; 2]);
        }
        for u in 1..right {
            assert_eq!([at(&image, u, 1), at(&image, u, bottom - 1)], [BLACK; 2]);
        }
        for v in 1..bottom {
            assert_eq!([at(&image, 1, v), at(&image, right - 1, v)], [BLACK; 2]);
        }
    }
}

#[test]
fn the_grids_lines_are_at_round_coordinates() {
    let image = TestImage::Grid.draw([1280, 800], "");
    for (u, v) in [(0, 0), (100, 100), (1200, 700), (1279, 799), (500, 333), (777, 300)] {
        assert!(at(&image, u, v) > 0, "{u} {v}");
    }
    // Between the lines, away from scales and labels.
    for (u, v) in [(90, 77), (1255, 680), (333, 272)] {
        assert_eq!(at(&image, u, v), BLACK, "{u} {v}");
    }
}

#[test]
fn the_squares_of_the_checkerboard_are_whole_where_they_can_be() {
    for (size_px, side) in [([1280, 800], 80), ([1024, 768], 64), ([1920, 1080], 120)] {
        let image = TestImage::Checkerboard.draw(size_px, "");
        assert_eq!((at(&image, side - 1, 0), at(&image, side, 0)), (WHITE, BLACK));
        assert_eq!((at(&image, 0, side - 1), at(&image, 0, side)), (WHITE, BLACK));
        let lit = image.data.iter().filter(|grey| **grey == WHITE).count();
        let rows_and_columns = (size_px[0] / side) * (size_px[1] / side);
        assert_eq!(lit as u32, rows_and_columns.div_ceil(2) * side * side);
    }
}

#[test]
fn the_crosshair_is_in_the_middle() {
    let image = TestImage::Crosshair.draw([1280, 800], "");
    let lit = |u| at(&image, u, 3) == WHITE;
    assert_eq!((600..680).filter(|u| lit(*u)).collect::<Vec<_>>(), [639, 640]);
    let odd = TestImage::Crosshair.draw([641, 479], "");
    assert_eq!((300..340).filter(|u| at(&odd, *u, 3) == WHITE).collect::<Vec<_>>(), [320]);
    // Drawn from the middle, it is the same from both sides where there are no labels.
    assert_eq!(at(&image, 539, 390), at(&image, 740, 390));
}

#[test]
fn the_ramp_has_all_levels_in_their_order() {
    let image = TestImage::Ramp.draw([1280, 800], "");
    let row: Vec<u8> = image.data[..1280].to_vec();
    assert!(row.is_sorted() && (0..=255).all(|level| row.contains(&level)));
}

/// The share of white pixels in a quarter of the orientation marks' corner, of the image as it was turned.
fn dots(image: &Image, mark: &OrientationMark) -> usize {
    let inside = |point: &[f64; 2]| at(image, point[0].round() as u32, point[1].round() as u32) == BLACK;
    mark.dots_px().iter().filter(|dot| inside(dot)).count()
}

#[test]
fn the_marks_are_apart_and_differ_in_their_dots() {
    for size_px in [[1280, 800], [1024, 768], [640, 360], [480, 854]] {
        let image = TestImage::Orientation.draw(size_px, "");
        let marks = orientation_marks(size_px);
        for (index, mark) in marks.iter().enumerate() {
            assert_eq!(mark.dots as usize, index + 1);
            assert_eq!(dots(&image, mark), index + 1, "{size_px:?}");
            let [u, v] = mark.center_px;
            // Between dots and edge it is white; the disc is within the image.
            let white = [u + 0.85 * mark.radius_px, v].map(|place| place.round() as u32);
            assert_eq!(at(&image, white[0], white[1]), WHITE);
            assert!((0..2).all(|axis| {
                let place = mark.center_px[axis];
                place > mark.radius_px && place < f64::from(size_px[axis]) - mark.radius_px
            }));
            let dots_px = mark.dots_px();
            for (one, other) in dots_px.iter().zip(dots_px.iter().skip(1)) {
                let apart = (one[0] - other[0]).hypot(one[1] - other[1]);
                assert!(apart > 3.0 * mark.dot_radius_px, "{apart} {mark:?}");
            }
        }
        let reversed: Vec<u8> = image.data.iter().rev().copied().collect();
        assert_ne!(reversed, image.data, "turned by half a turn it is another picture");
    }
}

#[test]
fn the_name_is_on_the_image() {
    let lit =
        |name: &str| -> u64 { TestImage::Name.draw([1280, 800], name).data.iter().map(|grey| u64::from(*grey)).sum() };
    assert!(lit("HDMI-1") > lit("-") + 1_000_000);
}
