//! Decoding: from the images of a scan to the projector pixel that lights each camera pixel.
//!
//! - [`exposure`]: compensates changes of the exposure.
//! - [`response`]: the camera's gamma and noise, from the capture itself.
//! - [`quality`]: clipping, motion and exposure of the scan.
//! - [`wrong_images`]: detects images of other patterns than listed, [`order`]: coordinates that run backwards.
//! - [`light_images`]: the images in linear light.
//! - [`blur`]: the blur of the stripes in each tile.
//! - [`search`]: each pixel's coordinate along an axis, by comparing its levels with blurred stripes.
//! - [`bleeding`]: the pull of the camera's blur towards the light.
//! - [`neighbours`]: predictions from a surface's pixels; [`axis`] searches again near the prediction where a pixel
//!   contradicts it, or drops the pixel.
//! - [`margins`]: drops pixels that see two surfaces or stray light.

mod axis;
mod bleeding;
mod blur;
pub(crate) mod channels;
mod exposure;
mod images;
mod light_images;
mod margins;
mod neighbours;
mod order;
mod quality;
pub(crate) mod response;
mod search;
mod wrong_images;

pub use images::{DecodeError, DecodedPixel, Images};
pub use quality::{Quality, ScanProblem};
pub use wrong_images::{ImageFault, WrongImage};

use axis::{contradicted_share, AxisDecoder};
use bleeding::Gradients;
use blur::Tables;
use channels::Channels;
use light_images::LightImages;
use margins::{without_bleeding, without_margins};
use response::Response;
use wrong_images::ImageCheck;

/// Decoded scan.
#[derive(Debug, Clone)]
pub struct Decoded {
    /// Width and height of the camera's images, pixels.
    pub size_px: [u32; 2],
    /// Camera pixels, row by row.
    pub pixels: Vec<DecodedPixel>,
    /// Number of camera pixels that the projector lights.
    pub lit: usize,
    /// Quality of the scan.
    pub quality: Quality,
}

impl Decoded {
    /// Number of decoded pixels.
    pub fn count(&self) -> usize {
        self.pixels.iter().filter(|pixel| pixel.is_decoded()).count()
    }

    /// Decoded pixels as a share of the lit ones.
    pub fn share(&self) -> f64 {
        self.count() as f64 / self.lit.max(1) as f64
    }
}

/// Decodes a scan of a projector of this size.
///
/// # Errors
/// [`DecodeError`]: images are missing or differ in size.
pub fn decode(images: &Images<'_>, projector_px: [u32; 2]) -> Result<Decoded, DecodeError> {
    let expected = images.size_px[0] as usize * images.size_px[1] as usize;
    if images.levels.len() != images.patterns.len() {
        return Err(DecodeError::Count(images.levels.len(), images.patterns.len()));
    }
    if let Some(index) = images.levels.iter().position(|levels| levels.len() != expected) {
        return Err(DecodeError::Size { index, count: images.levels[index].len(), expected });
    }
    let channels = Channels::new(images.patterns)?;
    channels.check_size(projector_px)?;
    let steadied = exposure::steadied(images, &channels);
    let steady_images = steadied.as_ref().map(|steadied| steadied.images(images));
    let images = steady_images.as_ref().unwrap_or(images);
    let response = Response::find(images, &channels);
    let light = LightImages { images, channels: &channels, response: &response };
    let noise = light.noise();
    let mut quality = Quality::measure(&ImageCheck { light: &light, noise: &noise });
    quality.exposure_change = quality.exposure_change.max(steadied.as_ref().map_or(0.0, |steadied| steadied.change));
    quality.beyond = [0, 1].map(|axis| light.share_beyond(&channels.axes[axis], projector_px[axis], &noise));
    let lit = noise.iter().filter(|noise| noise.is_finite()).count();
    let amplitudes = light.amplitudes();
    let width = images.size_px[0] as usize;
    let gradients = Gradients::new(&amplitudes, width);
    let tables = [0, 1].map(|axis| Tables::new(&channels.axes[axis], projector_px[axis]));
    let decoders = [0, 1].map(|axis| AxisDecoder {
        light: &light,
        noise: &noise,
        channels: &channels.axes[axis],
        tables: &tables[axis],
    });
    let mut single = decoders.each_ref().map(AxisDecoder::decode_single);
    single.iter_mut().for_each(|single| single.compensate(&gradients.pulls(&single.field)));
    let [along_x, along_y] = [0, 1].map(|axis| decoders[axis].decode_together(&single[axis]));
    let pixels: Vec<DecodedPixel> = (0..expected)
        .map(|pixel| {
            let sigma = [along_x.sigma[pixel], along_y.sigma[pixel]];
            if sigma.iter().all(|sigma| sigma.is_finite()) {
                DecodedPixel { at: [along_x.at[pixel], along_y.at[pixel]], sigma }
            } else {
                DecodedPixel::NONE
            }
        })
        .collect();
    quality.contradicted = contradicted_share(&single, &noise);
    let pixels = without_margins(&pixels, width);
    let pixels = without_bleeding(&pixels, &amplitudes, width);
    quality.reversed = order::reversed_share(&light, &pixels);
    quality.dark_edges = order::dark_edges_share(&ImageCheck { light: &light, noise: &noise });
    Ok(Decoded { size_px: images.size_px, pixels, lit, quality })
}
