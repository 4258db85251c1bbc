//! Light masks from images: from messages of a mask's topic, and from PNG files.

use std::path::Path;

use anyhow::{Context, Result};
use rcs_files::blend_file::BlendFile;
use rcs_messages::Image;
use rcs_node_support::user_file;
use rcs_render::LightMask;

/// Reads a mask from an image message.
///
/// # Errors
/// Another encoding, or too few bytes.
pub fn light_mask(image: &Image) -> Result<LightMask, String> {
    let size_px = [image.width, image.height];
    LightMask::new(size_px, grey_levels(image)?).ok_or_else(|| too_short(image))
}

/// The grey levels of a mono8 image, row by row.
///
/// # Errors
/// Another encoding, no pixels, or too few bytes.
pub(crate) fn grey_levels(image: &Image) -> Result<Vec<u8>, String> {
    if !matches!(image.encoding.as_str(), "mono8" | "8UC1") {
        return Err(format!("its encoding is {}, not mono8", image.encoding));
    }
    let (width, step) = (image.width as usize, image.step as usize);
    // Rows that overlap could be endlessly many in few bytes.
    if width == 0 || step < width {
        return Err(too_short(image));
    }
    let rows = (0..image.height as usize).map(|row| image.data().get(row.checked_mul(step)?..)?.get(..width));
    rows.collect::<Option<Vec<_>>>().map(|rows| rows.concat()).ok_or_else(|| too_short(image))
}

fn too_short(image: &Image) -> String {
    format!("{} bytes for {}x{} pixels, {} a row", image.data().len(), image.width, image.height, image.step)
}

/// Reads a mask from a PNG file. Transparent pixels are dark.
///
/// # Errors
/// A file that cannot be read, or no PNG.
pub(crate) fn painted_mask(path: &Path) -> Result<LightMask> {
    user_file::check(path)?;
    let BlendFile { size_px, weights, lifts } = BlendFile::read(path)?;
    let level = |(light, transparency): (u16, u16)| {
        let opaque = u32::from(light) * u32::from(u16::MAX - transparency) / u32::from(u16::MAX);
        (opaque >> 8) as u8
    };
    let mask = LightMask::new(size_px, weights.into_iter().zip(lifts).map(level).collect());
    mask.with_context(|| format!("{}: it has no pixels", path.display()))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rcs_messages::std_msgs::Header;

    use super::*;

    #[test]
    fn a_mask_is_a_mono8_image_with_rows_of_any_length() {
        let image = |encoding: &str, size_px, step, bytes: &[u8]| {
            light_mask(&Image::new(Header::default(), size_px, encoding, step, Arc::new(bytes.to_vec())))
        };
        assert_eq!(image("mono8", [2, 2], 3, &[1, 2, 0, 3, 4]), Ok(LightMask::new([2, 2], vec![1, 2, 3, 4]).unwrap()));
        assert_eq!(image("rgb8", [1, 1], 3, &[0; 3]), Err("its encoding is rgb8, not mono8".to_owned()));
        assert_eq!(image("mono8", [2, 2], 2, &[1, 2, 3]), Err("3 bytes for 2x2 pixels, 2 a row".to_owned()));
        assert!(image("8UC1", [0, 2], 2, &[]).is_err() && image("8UC1", [2, 0], 2, &[]).is_err());
        // In no time, and without memory for all those rows.
        assert!(image("mono8", [0, u32::MAX], 0, &[1]).is_err() && image("mono8", [1, u32::MAX], 0, &[1]).is_err());
        assert!(image("mono8", [1, u32::MAX], 1, &[1]).is_err());
    }

    proptest::proptest! {
        #[test]
        fn any_image_is_a_mask_of_its_size_or_none(
            size_px in (0_u32..6, 0_u32..6), step in 0_u32..8, bytes in proptest::collection::vec(0_u8.., 0..40),
        ) {
            let (width, height) = size_px;
            let has_all = width > 0 && height > 0 && step >= width && bytes.len() as u32 >= step * (height - 1) + width;
            let image = Image::new(Header::default(), [width, height], "mono8", step, Arc::new(bytes));
            proptest::prop_assert_eq!(light_mask(&image).is_ok(), has_all);
        }
    }

    #[test]
    fn a_painted_mask_is_dark_where_it_is_black_or_transparent() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mask.png");
        let (light, transparency) = ([1.0, 0.0, 1.0, 128.0 / 255.0], [0.0, 0.0, 1.0, 0.0]);
        BlendFile::new([4, 1], &light, &transparency).write(&path).unwrap();
        assert_eq!(painted_mask(&path).unwrap(), LightMask::new([4, 1], vec![255, 0, 0, 128]).unwrap());
    }
}
