//! The mask of confirmed light as a `mono8` image: 255 where light is allowed, 0 where it is not.

use std::sync::Arc;

use rcs_messages::std_msgs::Header;
use rcs_messages::Image;
use rcs_render::Orientation;

use crate::safety::permit::Permit;

/// The mask of an image of this size, turned like the image; all dark where nothing may be lit. `None` where no light
/// has to be confirmed.
pub(super) fn confirmed_image(permit: &Permit, size_px: [u32; 2], header: Header) -> Option<Image> {
    let levels = match (&permit.post.confirmed, permit.is_lit) {
        (_, false) => vec![0; size_px[0] as usize * size_px[1] as usize],
        (None, true) => return None,
        (Some(mask), true) if permit.post.orientation == Orientation::default() => mask.levels().to_vec(),
        (Some(mask), true) => {
            let mut turned = Vec::new();
            permit.post.orientation.turn_cells(mask.size_px(), 1, mask.levels(), &mut turned);
            turned
        }
    };
    Some(Image::new(header, size_px, "mono8", size_px[0], Arc::new(levels)))
}

#[cfg(test)]
mod tests {
    use rcs_render::{LastStep, LightMask};

    use super::*;

    #[test]
    fn the_mask_is_turned_like_the_image_and_a_black_image_has_none_lit() {
        let mask = LightMask::new([2, 1], vec![255, 0]).map(Arc::new);
        let post = LastStep { confirmed: mask, orientation: "90".parse().unwrap(), ..LastStep::default() };
        let lit = Permit { is_lit: true, post: Arc::new(post), ..Permit::default() };
        let image = confirmed_image(&lit, [1, 2], Header::default()).unwrap();
        assert_eq!((image.width, image.height, image.step, image.data()), (1, 2, 1, [255, 0].as_slice()));
        let black = Permit { is_lit: false, ..lit };
        assert_eq!(confirmed_image(&black, [1, 2], Header::default()).unwrap().data(), [0, 0]);
        let unchecked = Permit { is_lit: true, ..Permit::default() };
        assert!(confirmed_image(&unchecked, [1, 2], Header::default()).is_none());
    }
}
