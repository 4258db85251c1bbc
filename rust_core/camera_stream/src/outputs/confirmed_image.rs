//! The mask of confirmed light as a `mono8` image: 255 where light is allowed, 0 where it is not.

use std::sync::Arc;

use rcs_messages::std_msgs::Header;
use rcs_messages::Image;
use rcs_render::{Orientation, PostProcess};

/// The mask of an image of this size, turned like the image, from its post-processing; all dark where nothing may be
/// lit and so without one. `None` where no light has to be confirmed.
pub(super) fn confirmed_image(post: Option<&PostProcess>, size_px: [u32; 2], header: Header) -> Option<Image> {
    let levels = match post.map(|post| (&post.confirmed, post.orientation)) {
        None => vec![0; size_px[0] as usize * size_px[1] as usize],
        Some((None, _)) => return None,
        Some((Some(mask), orientation)) if orientation == Orientation::default() => mask.levels().to_vec(),
        Some((Some(mask), orientation)) => {
            let mut turned = Vec::new();
            orientation.turn_cells(mask.size_px(), 1, mask.levels(), &mut turned);
            turned
        }
    };
    Some(Image::new(header, size_px, "mono8", size_px[0], Arc::new(levels)))
}

#[cfg(test)]
mod tests {
    use rcs_render::LightMask;

    use super::*;

    #[test]
    fn the_mask_is_turned_like_the_image_and_a_black_image_has_none_lit() {
        let mask = LightMask::new([2, 1], vec![255, 0]).map(Arc::new);
        let post = PostProcess { confirmed: mask, orientation: "90".parse().unwrap(), ..PostProcess::default() };
        let image = confirmed_image(Some(&post), [1, 2], Header::default()).unwrap();
        assert_eq!((image.width, image.height, image.step, image.data()), (1, 2, 1, [255, 0].as_slice()));
        assert_eq!(confirmed_image(None, [1, 2], Header::default()).unwrap().data(), [0, 0]);
        assert!(confirmed_image(Some(&PostProcess::default()), [1, 2], Header::default()).is_none());
    }
}
