//! Layout of colours in a pixel of 32 bits, by the masks of the root window's visual: eight bits each on most screens,
//! ten on screens of depth 30.

use x11rb::protocol::xproto::{Screen, VisualClass};

use crate::error::WindowError;

/// The bits of red, green and blue in a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PixelFormat {
    masks: [u32; 3],
}

impl PixelFormat {
    /// Eight bits each, `0x00RRGGBB`: the format of drawn pixels.
    const DRAWN: Self = Self { masks: [0x00ff_0000, 0x0000_ff00, 0x0000_00ff] };

    /// The format of a screen's root visual.
    ///
    /// # Errors
    /// The visual has no fixed colours, or a mask that is empty or not contiguous.
    pub(super) fn of(screen: &Screen) -> Result<Self, WindowError> {
        let visual = screen
            .allowed_depths
            .iter()
            .filter(|depth| depth.depth == screen.root_depth)
            .flat_map(|depth| &depth.visuals)
            .find(|visual| visual.visual_id == screen.root_visual)
            .ok_or_else(|| WindowError::NoDisplay("the X server does not describe its screen's visual".to_owned()))?;
        let masks = [visual.red_mask, visual.green_mask, visual.blue_mask];
        let has_fixed_colors = [VisualClass::TRUE_COLOR, VisualClass::DIRECT_COLOR].contains(&visual.class);
        Self::from_masks(masks).filter(|_| has_fixed_colors).ok_or_else(|| {
            let [red, green, blue] = masks;
            WindowError::NoDisplay(format!(
                "the X server's screen has a visual of class {:?} with the masks {red:#x}, {green:#x}, {blue:#x}; use a \
                 screen with TrueColor of depth 24 or 30",
                visual.class
            ))
        })
    }

    /// The format of these masks; `None` if one is empty or not contiguous.
    fn from_masks(masks: [u32; 3]) -> Option<Self> {
        let is_contiguous = |mask: u32| (mask >> mask.trailing_zeros().min(31)).trailing_ones() == mask.count_ones();
        masks.iter().all(|mask| *mask != 0 && is_contiguous(*mask)).then_some(Self { masks })
    }

    /// `true` if drawn pixels need no conversion.
    pub(super) fn is_drawn(self) -> bool {
        self == Self::DRAWN
    }

    /// A drawn pixel, `0x00RRGGBB`, in this format.
    pub(super) fn pixel(self, drawn: u32) -> u32 {
        let [_, red, green, blue] = drawn.to_be_bytes();
        let channels = [red, green, blue].into_iter().zip(self.masks);
        channels.fold(0, |pixel, (level, mask)| {
            let shift = mask.trailing_zeros();
            let greatest = u64::from(mask >> shift);
            // At most the greatest level, which fits the mask.
            let scaled = (u64::from(level) * greatest + 127) / 255;
            pixel | (scaled as u32) << shift
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_fill_the_masks_of_a_visual() {
        let format = |masks| PixelFormat::from_masks(masks).unwrap();
        let ten_bits = format([0x3ff0_0000, 0x000f_fc00, 0x0000_03ff]);
        assert_eq!(ten_bits.pixel(0x00ff_ffff), 0x3fff_ffff);
        assert_eq!(ten_bits.pixel(0x0000_0000), 0);
        assert_eq!(ten_bits.pixel(0x00ff_0080), 0x3ff0_0000 | 514);
        let swapped = format([0x0000_00ff, 0x0000_ff00, 0x00ff_0000]);
        assert_eq!(swapped.pixel(0x0012_3456), 0x0056_3412);
        let small = format([0xf800, 0x07e0, 0x001f]);
        assert_eq!((small.pixel(0x00ff_ffff), small.pixel(0x0080_8080)), (0xffff, 0x8410));
        let high = format([0xff00_0000, 0x00ff_0000, 0x0000_ff00]);
        assert_eq!(high.pixel(0x0012_3456), 0x1234_5600);
        for drawn in [0, 0x0012_3456, 0x00ff_ffff] {
            assert_eq!(PixelFormat::DRAWN.pixel(drawn), drawn);
        }
        assert!(PixelFormat::DRAWN.is_drawn() && !swapped.is_drawn());
    }

    #[test]
    fn masks_that_are_empty_or_in_pieces_are_refused() {
        for masks in [[0, 0xff00, 0xff], [0xff_0000, 0xf0f0, 0xff]] {
            assert_eq!(PixelFormat::from_masks(masks), None, "{masks:x?}");
        }
    }
}
