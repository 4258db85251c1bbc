//! Order of a scan's images, by the decoded field and by the code's own edges.
//!
//! Camera and projector see the same side of a surface, so the determinant of d(u, v)/d(x, y) is positive wherever a
//! surface is decoded. It is negative where images are mirrored or the axes swapped, and where a bit of a Gray code is
//! wrong, because that mirrors all finer bits. White that is darker than black is out of order, too.
//!
//! At an edge of a bit of a Gray code the next finer bit is lit. Where it is dark, bits are exchanged.

use super::channels::AxisChannels;
use super::light_images::LightImages;
use super::wrong_images::ImageCheck;
use super::DecodedPixel;

/// Distance of the pixels between which coordinates are compared, camera pixels.
const REACH: usize = 2;
/// Maximum change of a coordinate over this distance on one surface, projector pixels.
const SURFACE_STEP_PX: f32 = 24.0;
/// Minimum determinant whose sign is certain, standard deviations.
const CERTAIN_SIGMAS: f32 = 3.0;
/// Minimum number of such places.
const LEAST_PLACES: usize = 100;
/// Minimum width of the next finer bit's stripes at an edge, projector pixels.
const CLEAR_EDGE_PX: f64 = 8.0;
/// Minimum number of places at a bit's edges.
const LEAST_EDGES: usize = 20;
/// Minimum mean by which white is darker than black, levels.
const DARKER_LEVELS: u64 = 1;

/// Share of the decoded places at which coordinates run backwards; 1 if white is darker than black.
pub(super) fn reversed_share(light: &LightImages<'_>, pixels: &[DecodedPixel]) -> f64 {
    let sum = |image: usize| light.images.levels[image].iter().map(|level| u64::from(*level)).sum::<u64>();
    if sum(light.channels.black) > sum(light.channels.white) + DARKER_LEVELS * pixels.len() as u64 {
        return 1.0;
    }
    reversed(pixels, light.images.size_px[0] as usize)
}

/// Maximum over the bits of the share of their edges at which the next finer bit is dark.
pub(super) fn dark_edges_share(check: &ImageCheck<'_>) -> f64 {
    let axes = &check.light.channels.axes;
    axes.iter().map(|axis| dark_edges_share_along(check, axis)).fold(0.0, f64::max)
}

fn dark_edges_share_along(check: &ImageCheck<'_>, axis: &AxisChannels) -> f64 {
    let width = check.light.images.size_px[0] as usize;
    let bits: Vec<_> = axis.all[..axis.code_bits].iter().collect();
    let signs: Vec<[u64; 2]> = (0..check.noise.len()).map(|pixel| check.clear_signs(&bits, pixel)).collect();
    let mut edges = [[0_usize; 2]; u64::BITS as usize];
    for (index, here) in signs.iter().enumerate() {
        let right = (index % width + REACH < width).then_some(1);
        let below = (index + REACH * width < signs.len()).then_some(width);
        for step in right.into_iter().chain(below) {
            let other = &signs[index + REACH * step];
            let [lit, dark] = [here[0] & other[0], here[1] & other[1]];
            let bit = (lit | dark).trailing_ones();
            let is_edge = (here[0] & other[1] | here[1] & other[0]) >> bit & 1 == 1;
            // Where stripes are as fine as the camera's pixels, a lit one may be between two dark pixels.
            let dark = dark & signs[index + REACH / 2 * step][1];
            let next = [lit, dark].map(|signs| signs >> (bit + 1) & 1 == 1);
            if is_edge && (next[0] || next[1]) && bits[bit as usize + 1].stripes.width_px() >= CLEAR_EDGE_PX {
                edges[bit as usize][usize::from(next[1])] += 1;
            }
        }
    }
    let seen = edges.iter().filter(|[lit, dark]| lit + dark >= LEAST_EDGES);
    seen.map(|[lit, dark]| *dark as f64 / (lit + dark) as f64).fold(0.0, f64::max)
}

fn reversed(pixels: &[DecodedPixel], width: usize) -> f64 {
    let (mut places, mut negative) = (0_usize, 0_usize);
    for index in (0..pixels.len().saturating_sub(REACH * width)).filter(|index| index % width + REACH < width) {
        let sign = sign(pixels[index], pixels[index + REACH], pixels[index + REACH * width]);
        places += usize::from(sign != 0);
        negative += usize::from(sign < 0);
    }
    if places < LEAST_PLACES {
        return 0.0;
    }
    negative as f64 / places as f64
}

/// Sign of the determinant between a pixel and those to its right and below; 0 if it is uncertain.
fn sign(here: DecodedPixel, right: DecodedPixel, below: DecodedPixel) -> i8 {
    let [[u_right, v_right], [u_below, v_below]] =
        [right, below].map(|other| [0, 1].map(|axis| other.at[axis] - here.at[axis]));
    let is_surface = [u_right, v_right, u_below, v_below].iter().all(|step| step.abs() < SURFACE_STEP_PX);
    let determinant = u_right * v_below - u_below * v_right;
    let [sigma_u, sigma_v] =
        [0, 1].map(|axis| (here.sigma[axis].powi(2) + right.sigma[axis].powi(2) + below.sigma[axis].powi(2)).sqrt());
    let sigma = (sigma_u * v_right.hypot(v_below)).hypot(sigma_v * u_right.hypot(u_below));
    // Comparisons with the NaN of pixels that are not decoded are false.
    match (is_surface, determinant.abs() > CERTAIN_SIGMAS * sigma) {
        (true, true) if determinant < 0.0 => -1,
        (true, true) => 1,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 40;

    fn share(at: impl Fn(f32, f32) -> [f32; 2]) -> f64 {
        let pixel = |index: usize| {
            let at = at((index % SIDE) as f32, (index / SIDE) as f32);
            DecodedPixel { at, sigma: [0.1; 2] }
        };
        reversed(&(0..SIDE * SIDE).map(pixel).collect::<Vec<_>>(), SIDE)
    }

    #[test]
    fn coordinates_run_backwards_where_axes_are_swapped_or_images_mirrored() {
        let right = |x: f32, y: f32| [100.0 + 2.0 * x + 0.3 * y, 50.0 + 1.5 * y - 0.2 * x];
        let swapped = |[u, v]: [f32; 2]| [v, u];
        assert_eq!(share(right), 0.0);
        // A camera or a projector that hangs upside down, or on its side.
        assert_eq!(share(|x, y| right(39.0 - x, 39.0 - y)), 0.0);
        assert_eq!(share(|x, y| right(y, 39.0 - x)), 0.0);
        assert_eq!(share(|x, y| swapped(right(x, y))), 1.0);
        assert_eq!(share(|x, y| right(39.0 - x, y)), 1.0);
        assert_eq!(share(|x, y| right(x, 39.0 - y)), 1.0);
        // A wrong bit mirrors half of the columns.
        let folded = share(|x, y| [if x < 20.0 { x } else { 40.0 - x }, y]);
        assert!((0.4..0.6).contains(&folded), "{folded}");
    }

    #[test]
    fn a_share_of_uncertain_or_few_places_says_nothing() {
        assert_eq!(share(|x, y| [0.05 * y, 0.05 * x]), 0.0);
        assert_eq!(share(|x, y| if y < 4.0 && x < 20.0 { [y, x] } else { [f32::NAN; 2] }), 0.0);
    }
}
