//! The colours of a map's values in rviz's three schemes.
//!
//! Values are the bytes of the message: 0 to 100 are probabilities or costs, 255 (−1) is unknown, and the rest is
//! illegal, which all schemes but the raw one show in loud colours.

use std::sync::{Arc, OnceLock};

use rcs_rviz_config::MapPalette;

/// A colour for each value, red first.
pub(super) type Palette = Arc<[[u8; 4]; 256]>;

/// Colours of a scheme; shared, so that renderers recognise them.
pub(super) fn palette(scheme: MapPalette) -> Palette {
    static PALETTES: [OnceLock<Palette>; 3] = [const { OnceLock::new() }; 3];
    let (place, color): (usize, fn(u8) -> [u8; 4]) = match scheme {
        MapPalette::Map => (0, map_color),
        MapPalette::Costmap => (1, cost_color),
        MapPalette::Raw => (2, |value| [value, value, value, 255]),
    };
    PALETTES[place].get_or_init(|| Arc::new(std::array::from_fn(|value| color(value as u8)))).clone()
}

/// `true` if a scheme blends with the background at any opacity.
pub(super) fn always_blends(scheme: MapPalette) -> bool {
    scheme != MapPalette::Map
}

fn map_color(value: u8) -> [u8; 4] {
    match value {
        0..=100 => {
            let grey = 255 - share_of_255(value, 100);
            [grey, grey, grey, 255]
        }
        _ => other_color(value),
    }
}

fn cost_color(value: u8) -> [u8; 4] {
    match value {
        0 => [0; 4],
        1..=98 => {
            let red = share_of_255(value, 100);
            [red, 0, 255 - red, 255]
        }
        99 => [0, 255, 255, 255],
        100 => [255, 0, 255, 255],
        _ => other_color(value),
    }
}

/// Values that are no probability.
fn other_color(value: u8) -> [u8; 4] {
    match value {
        255 => [0x70, 0x89, 0x86, 255],
        128.. => [255, share_of_255(value - 128, 126), 0, 255],
        _ => [0, 255, 0, 255],
    }
}

fn share_of_255(value: u8, whole: u8) -> u8 {
    (255 * u16::from(value) / u16::from(whole)) as u8
}
