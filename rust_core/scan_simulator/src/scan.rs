//! Camera images of projected patterns.
//!
//! Direct light comes from tables of blurred stripes, or from any displayed image, for each ray of each pixel. Black
//! pixels leak, surfaces light each other, the camera's lens scatters, the room has ambient light; then the sensor
//! converts it to bytes.

use nalgebra::{Point2, Vector2};
use rayon::prelude::*;
use rcs_calibration::patterns::{Axis, Pattern};

use crate::bounce::Bounce;
use crate::projected_image::ProjectedImage;
use crate::sensor::Sensor;
use crate::stripes::{strength, BlurredStripes};
use crate::view::{Ray, RAYS};
use crate::{Conditions, Random, View};

/// Reach of blur at the edge of the projector's image, projector pixels.
const EDGE_PX: f32 = 24.0;

/// Ray with its direct light.
#[derive(Debug, Clone, Copy, Default)]
struct Lit {
    /// Place in the displayed image, pixels.
    place: [f32; 2],
    /// Blur along u and v: table numbers.
    blur: [u8; 2],
    /// Light when everything is white.
    light: f32,
}

/// Scan of a view under conditions.
#[derive(Debug, Clone)]
pub struct Scan<'a> {
    view: &'a View,
    conditions: Conditions,
    /// Four rays for each pixel.
    rays: Vec<Lit>,
    /// Blur strengths in use.
    is_used: Vec<bool>,
    /// Edges of the projector's image, across u and v.
    edges: [BlurredStripes; 2],
    bounce: Option<Bounce>,
    sensor: Sensor,
    /// Factor of the light.
    exposure: f32,
}

impl<'a> Scan<'a> {
    /// Prepares images and sets the exposure for a white image.
    pub fn new(view: &'a View, conditions: Conditions) -> Self {
        let rays = lit_rays(view, &conditions);
        let mut is_used = vec![false; BlurredStripes::strengths()];
        for blur in rays.iter().filter(|ray| ray.light > 0.0).flat_map(|ray| ray.blur) {
            is_used[usize::from(blur)] = true;
        }
        let size_px = view.rig().projector.size_px;
        let mut scan = Self {
            edges: Axis::ALL.map(|axis| BlurredStripes::new(&Pattern::White, axis, size_px, &is_used)),
            bounce: (conditions.interreflection > 0.0).then(|| Bounce::new(view)),
            sensor: Sensor::new(&conditions),
            exposure: 1.0,
            view,
            conditions,
            rays,
            is_used,
        };
        let mut brightest = scan.light(scan.direct(&Pattern::White));
        let rank = brightest.len() - 1 - brightest.len() / 200;
        let (_, level, _) = brightest.select_nth_unstable_by(rank, f32::total_cmp);
        scan.exposure = scan.conditions.exposure as f32 / level.max(1e-6);
        scan
    }

    /// Image of a pattern with its number in the scan: grey levels, row by row.
    pub fn capture(&self, pattern: &Pattern, image: u32) -> Vec<u8> {
        self.expose(&self.light(self.direct(pattern)), image)
    }

    /// Light of all camera pixels for a displayed image of grey levels, both row by row, for [`Self::expose`].
    pub fn light_of(&self, levels: &[u8]) -> Vec<f32> {
        let size_px = self.view.rig().projector.size_px;
        let image = ProjectedImage::new(levels, size_px, self.conditions.black_level as f32);
        let brightness = |ray: &Lit| if ray.light > 0.0 { ray.light * image.at(ray.place, ray.blur) } else { 0.0 };
        let mut light = vec![0.0; self.rays.len() / RAYS];
        light.par_iter_mut().zip(self.rays.par_chunks(RAYS)).for_each(|(light, rays)| {
            *light = rays.iter().map(brightness).sum();
        });
        self.light(light)
    }

    /// Image of light with its number in the scan: grey levels, row by row.
    pub fn expose(&self, light: &[f32], image: u32) -> Vec<u8> {
        let conditions = &self.conditions;
        let flicker = Random::new(&[conditions.seed, u64::from(image), 0x464c_4943]).normal();
        let drift = (1.0 + conditions.drift_per_image).powf(f64::from(image));
        let exposure = self.exposure * (drift * (1.0 + conditions.flicker * flicker)) as f32;
        let light: Vec<f32> = light.iter().map(|light| light * exposure).collect();
        let moved = conditions.motion.filter(|motion| image >= motion.from_image);
        let shift_px = moved.map_or_else(Vector2::zeros, |motion| motion.shift_px);
        self.sensor.expose(&light, self.width(), shift_px, image)
    }

    /// Images of all patterns, in their order.
    pub fn capture_all(&self, patterns: &[Pattern]) -> Vec<Vec<u8>> {
        patterns.par_iter().enumerate().map(|(image, pattern)| self.capture(pattern, image as u32)).collect()
    }

    fn width(&self) -> usize {
        self.view.size_px()[0] as usize
    }

    /// All light, from the direct light.
    fn light(&self, direct: Vec<f32>) -> Vec<f32> {
        let conditions = &self.conditions;
        let mean = direct.iter().sum::<f32>() / direct.len().max(1) as f32;
        let (ambient, scattered) = (conditions.ambient as f32, conditions.scatter as f32 * mean);
        let width = self.width();
        let gathered = self.bounce.as_ref().map(|bounce| bounce.gather(&direct, width));
        let strength = conditions.interreflection as f32;
        let mut light = direct;
        let rows = light.par_chunks_mut(width).zip(self.view.pixels().par_chunks(width));
        rows.enumerate().for_each(|(v, (light, pixels))| {
            for (light, pixel) in light.iter_mut().zip(pixels) {
                *light += pixel.ambient * ambient + scattered;
            }
            if let Some(gathered) = &gathered {
                for ((light, pixel), received) in light.iter_mut().zip(pixels).zip(gathered.row(v)) {
                    *light += pixel.albedo * strength * received;
                }
            }
        });
        light
    }

    /// Direct light of the projector.
    fn direct(&self, pattern: &Pattern) -> Vec<f32> {
        let axis = match pattern {
            Pattern::GrayCode(stripes) => stripes.axis,
            Pattern::White | Pattern::Black => Axis::X,
        };
        let (along, across) = (axis.index(), 1 - axis.index());
        let size_px = self.view.rig().projector.size_px;
        let stripes = BlurredStripes::new(pattern, axis, size_px, &self.is_used);
        let [edge_along, edge_across] = [along, across].map(|axis| (&self.edges[axis], axis, size_px[axis] as f32));
        let black = self.conditions.black_level as f32;
        let edge = |(edge, axis, size): (&BlurredStripes, usize, f32), ray: &Lit| {
            let place = ray.place[axis];
            if (EDGE_PX..size - EDGE_PX).contains(&place) {
                1.0
            } else {
                edge.at(place, ray.blur[axis])
            }
        };
        let brightness = |ray: &Lit| {
            if ray.light <= 0.0 {
                return 0.0;
            }
            let lit = stripes.at(ray.place[along], ray.blur[along]);
            ray.light * edge(edge_across, ray) * (black * edge(edge_along, ray) + (1.0 - black) * lit)
        };
        let mut light = vec![0.0; self.rays.len() / RAYS];
        let width = self.width();
        light.par_chunks_mut(width).zip(self.rays.par_chunks(width * RAYS)).for_each(|(light, rays)| {
            for (light, rays) in light.iter_mut().zip(rays.chunks(RAYS)) {
                *light = rays.iter().map(brightness).sum();
            }
        });
        light
    }
}

/// Rays of all pixels, with the projector's blur at their depth.
fn lit_rays(view: &View, conditions: &Conditions) -> Vec<Lit> {
    let lit = |ray: &Ray, extent_px: [f32; 2]| {
        let [u, v] = ray.lit_by.map(f64::from);
        let place = conditions.image_from_panel.transform_point(&Point2::new(u, v));
        let off_focus = 1.0 / f64::from(ray.depth_m) - 1.0 / conditions.focus_m;
        let squared = conditions.sharpest_px.powi(2) + (conditions.defocus_px * off_focus).powi(2);
        let blur = extent_px.map(|extent| strength((squared as f32 + extent * extent).sqrt()));
        Lit { place: [place.x as f32, place.y as f32], blur, light: ray.light }
    };
    let mut rays = vec![Lit::default(); view.pixels().len() * RAYS];
    rays.par_chunks_mut(RAYS).zip(view.pixels()).for_each(|(rays, pixel)| {
        for (ray, seen) in rays.iter_mut().zip(&pixel.rays).filter(|(_, seen)| seen.light > 0.0) {
            *ray = lit(seen, pixel.extent_px);
        }
    });
    rays
}

#[cfg(test)]
mod tests {
    use rcs_calibration::patterns::gray_code;

    use super::*;
    use crate::{Motion, Rig, Room};

    fn view() -> View {
        View::new(&Room::cluttered(5), &Rig::random(5))
    }

    #[test]
    fn images_follow_from_the_seed() {
        let view = view();
        let finest = gray_code([1280, 800])[22];
        let capture = |seed, image| Scan::new(&view, Conditions::random(seed)).capture(&finest, image);
        assert!(capture(1, 3) == capture(1, 3));
        assert!(capture(1, 3) != capture(1, 4) && capture(1, 3) != capture(2, 3));
        let still = Conditions { flicker: 0.0, full_well: f64::INFINITY, ..Conditions::random(1) };
        let moves = Motion { from_image: 4, shift_px: Vector2::new(2.0, 0.0) };
        let moving = Conditions { motion: Some(moves), ..still.clone() };
        let (still, moving) = (Scan::new(&view, still), Scan::new(&view, moving));
        assert!(still.capture(&finest, 3) == moving.capture(&finest, 3));
        assert!(still.capture(&finest, 4) != moving.capture(&finest, 4));
    }

    #[test]
    fn stripes_tell_the_truth_where_nothing_disturbs_them() {
        let view = view();
        let scan = Scan::new(&view, Conditions::ideal());
        let patterns = gray_code([1280, 800]);
        for pattern in [6, 12, 16, 26, 32, 36].map(|index: usize| &patterns[index]) {
            let Pattern::GrayCode(stripes) = pattern else { panic!("{pattern:?}") };
            let (lit, dark) = (scan.capture(pattern, 0), scan.capture(&Pattern::GrayCode(stripes.inverse()), 1));
            let (mut right, mut all) = (0, 0);
            for (index, (lit, dark)) in lit.iter().zip(&dark).enumerate() {
                let Some(truth) = view.truth(index as u32 % 640, index as u32 / 640) else { continue };
                let at = |axis: usize| truth[axis].round() as u32;
                all += 1;
                right += usize::from(pattern.is_lit(at(0), at(1)) == (lit > dark));
            }
            assert!(right as f64 > 0.93 * all as f64, "{pattern:?}: {right} of {all}");
        }
    }

    #[test]
    fn any_image_looks_like_the_pattern_that_it_is_of() {
        let view = view();
        let scan = Scan::new(&view, Conditions { full_well: f64::INFINITY, flicker: 0.0, ..Conditions::random(2) });
        let patterns = gray_code([1280, 800]);
        for pattern in [&Pattern::White, &patterns[8], &patterns[32]] {
            let expected = scan.capture(pattern, 0);
            let seen = scan.expose(&scan.light_of(&pattern.image([1280, 800])), 0);
            let far = expected.iter().zip(&seen).filter(|(one, other)| one.abs_diff(**other) > 2).count();
            assert!(far * 1000 < seen.len(), "{pattern:?}: {far}");
        }
    }

    #[test]
    fn edges_of_stripes_are_where_the_truth_says() {
        let view = View::new(&Room::wall(1.4, [0.2, -0.3]), &Rig::random(6));
        let scan = Scan::new(&view, Conditions { sharpest_px: 1.0, camera_blur_px: 0.5, ..Conditions::ideal() });
        let patterns = gray_code([1280, 800]);
        for (index, axis, step) in [(16, 0, [1, 0]), (36, 1, [0, 1])] {
            let Pattern::GrayCode(stripes) = patterns[index] else { panic!("{:?}", patterns[index]) };
            let width = stripes.width_px();
            let (lit, dark) = (scan.capture(&patterns[index], 0), scan.capture(&patterns[index + 1], 1));
            let difference = |u: u32, v: u32| {
                let at = (v * 640 + u) as usize;
                f64::from(lit[at]) - f64::from(dark[at])
            };
            let mut errors = Vec::new();
            for (u, v) in (1..478).flat_map(|v| (1..638).map(move |u| (u, v))) {
                let (next_u, next_v) = (u + step[0], v + step[1]);
                let (one, other) = (difference(u, v), difference(next_u, next_v));
                let (Some(here), Some(there)) = (view.truth(u, v), view.truth(next_u, next_v)) else { continue };
                if one * other < 0.0 {
                    let share = one / (one - other);
                    let edge = here[axis] + share * (there[axis] - here[axis]) + 0.5;
                    errors.push(edge - (edge / (0.5 * width)).round() * 0.5 * width);
                }
            }
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            let squares = errors.iter().map(|error| error * error).sum::<f64>();
            let rms = (squares / errors.len() as f64).sqrt();
            assert!(errors.len() > 3000 && mean.abs() < 0.02 && rms < 0.1, "{axis}: {mean} {rms} {}", errors.len());
        }
    }

    #[test]
    fn white_is_brighter_than_black_and_hardly_clips() {
        for seed in 0..3 {
            let view = View::new(&Room::cluttered(seed), &Rig::random(seed));
            let scan = Scan::new(&view, Conditions::random(seed));
            let (white, black) = (scan.capture(&Pattern::White, 0), scan.capture(&Pattern::Black, 1));
            let lit = |index: &usize| view.truth(*index as u32 % 640, *index as u32 / 640).is_some();
            let lit: Vec<usize> = (0..white.len()).filter(lit).collect();
            let brighter = lit.iter().filter(|index| white[**index] > black[**index]).count();
            assert!(brighter as f64 > 0.97 * lit.len() as f64, "seed {seed}: {brighter} of {}", lit.len());
            let clipped = white.iter().filter(|level| **level == 255).count();
            assert!(clipped * 100 < white.len(), "seed {seed}: {clipped}");
        }
    }
}
