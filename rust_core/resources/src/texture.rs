//! Textures of meshes, as Ogre loads them: rows from the top, repeated, filtered within the nearest mipmap level.

use std::{
    io::Cursor,
    panic::catch_unwind,
    path::Path,
    sync::{Arc, OnceLock},
};

use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use rcs_scene::{Filtering, Texture, Wrapping};

use crate::{ResourceError, ResourceOptions};

/// Largest side of an image, the limit of graphics cards.
const MAX_SIDE: u32 = 16384;
/// Most pixels of an image, 256 MB: a small file can announce any size.
const MAX_TEXELS: u64 = 8192 * 8192;
/// Most memory of a decoder.
const MAX_DECODED_BYTES: u64 = 512 << 20;

/// Reads an image file: PNG, JPEG, BMP, TGA, TIFF, GIF, PNM or WebP. The format is detected from its contents, else
/// from its name.
///
/// # Errors
/// [`ResourceError::BadImage`], and errors of reading the file.
pub(crate) fn load(options: &ResourceOptions, path: &Path) -> Result<Arc<Texture>, ResourceError> {
    from_bytes(&options.read(path)?, path)
}

/// Decodes an image file's contents; `path` gives the format of files without signature.
///
/// # Errors
/// [`ResourceError::BadImage`].
pub(crate) fn from_bytes(bytes: &[u8], path: &Path) -> Result<Arc<Texture>, ResourceError> {
    // Some damaged images make the decoder of JPEG panic; the mesh is drawn without them.
    let decoded = catch_unwind(|| decode(bytes, path)).unwrap_or_else(|_| Err("its decoder panicked".to_owned()));
    decoded.map(Arc::new).map_err(|reason| ResourceError::BadImage { path: path.to_owned(), reason })
}

fn decode(bytes: &[u8], path: &Path) -> Result<Texture, String> {
    let unreadable = |error: ImageError| error.to_string();
    let guessed = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let mut reader = guessed.map_err(|error| error.to_string())?;
    if reader.format().is_none() {
        // TGA has no signature.
        reader.set_format(ImageFormat::from_path(path).map_err(unreadable)?);
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_DECODED_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(unreadable)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > MAX_TEXELS {
        return Err(format!("{width} × {height} pixels are too many"));
    }
    let image = DynamicImage::from_decoder(decoder).map_err(unreadable)?.into_rgba8();
    let (width, height) = image.dimensions();
    if width == 0 || height == 0 {
        return Err("it has no pixels".to_owned());
    }
    let rgba = image.pixels().map(|pixel| pixel.0).collect();
    Ok(Texture { width, height, rgba, filtering: Filtering::BilinearMipmap, wrapping: Wrapping::Repeat })
}

/// Ogre's replacement for a texture that cannot be loaded: 8 × 8 texels of yellow and black diagonal stripes.
pub fn warning_texture() -> Arc<Texture> {
    static TEXTURE: OnceLock<Arc<Texture>> = OnceLock::new();
    let make = || {
        let texel = |i: u32| if (i % 8 + i / 8) % 8 < 4 { [0, 0, 0, 255] } else { [255, 255, 0, 255] };
        Arc::new(Texture {
            width: 8,
            height: 8,
            rgba: (0..64).map(texel).collect(),
            filtering: Filtering::BilinearMipmap,
            wrapping: Wrapping::Repeat,
        })
    };
    Arc::clone(TEXTURE.get_or_init(make))
}

/// The texture to the power of `times`. rviz adds the diffuse texture once for every texture of any kind (bump,
/// specular …) of a material, and the layers are multiplied.
pub(crate) fn layered(texture: &Arc<Texture>, times: usize) -> Arc<Texture> {
    if times < 2 {
        return Arc::clone(texture);
    }
    let exponent = i32::try_from(times).unwrap_or(i32::MAX);
    let table: Vec<u8> =
        (0..=255_u8).map(|value| ((f32::from(value) / 255.0).powi(exponent) * 255.0).round() as u8).collect();
    let power = |value: u8| table.get(usize::from(value)).copied().unwrap_or(value);
    Arc::new(Texture { rgba: texture.rgba.iter().map(|texel| texel.map(power)).collect(), ..Texture::clone(texture) })
}
