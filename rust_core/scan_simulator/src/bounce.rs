//! Interreflections with one bounce: a gather between coarse patches of the image.
//!
//! A patch of 16×16 camera pixels represents the surface at its centre. The light at a patch is the sum over all
//! visible others by their form factors, interpolated between the patches' centres. Surfaces outside of the image
//! contribute nothing.

use rayon::prelude::*;

use crate::View;

/// Side of a patch, camera pixels.
const PATCH_PX: usize = 16;

/// Form factors between the patches of a view.
#[derive(Debug, Clone)]
pub(crate) struct Bounce {
    columns: usize,
    rows: usize,
    /// Form factors from each patch to all others.
    factors: Vec<Vec<f32>>,
}

impl Bounce {
    pub(crate) fn new(view: &View) -> Self {
        let [width, height] = view.size_px().map(|size| size as usize);
        let (columns, rows) = (width.div_ceil(PATCH_PX), height.div_ceil(PATCH_PX));
        let rig = view.rig();
        let focal_px = rig.camera.focal_px;
        let patches: Vec<_> = (0..columns * rows)
            .map(|index| {
                let middle = |patch: usize, size: usize| (patch * PATCH_PX + PATCH_PX / 2).min(size - 1) as u32;
                let sight = view.sight(middle(index % columns, width), middle(index / columns, height))?;
                // The patch's area; at grazing angles it is hardly ever one surface.
                let facing = -sight.normal.dot(&sight.point.coords.normalize());
                let pixel_m2 = sight.point.z.powi(2) / (focal_px.x * focal_px.y);
                let area_m2 = pixel_m2 * (PATCH_PX * PATCH_PX) as f64 / facing.max(0.2);
                Some((rig.room_from_camera * sight.point, rig.room_from_camera * sight.normal, area_m2))
            })
            .collect();
        let received = |at: usize| {
            let Some((point, normal, _)) = patches[at] else { return vec![0.0; patches.len()] };
            let from = |other: usize| {
                let Some((source, source_normal, area_m2)) = patches[other].filter(|_| other != at) else { return 0.0 };
                let towards = source - point;
                let squared = towards.norm_squared();
                let cosines = normal.dot(&towards).max(0.0) * source_normal.dot(&-towards).max(0.0) / squared;
                // Factors below 1e-5 together contribute less than noise.
                let factor = cosines * area_m2 / (std::f64::consts::PI * squared + area_m2);
                if factor < 1e-5 || view.room().is_blocked(&point, &source) {
                    return 0.0;
                }
                factor as f32
            };
            (0..patches.len()).map(from).collect()
        };
        Self { columns, rows, factors: (0..patches.len()).into_par_iter().map(received).collect() }
    }

    /// Light that arrives at each patch for an image of light, row by row; in the same unit.
    pub(crate) fn gather(&self, image: &[f32], width_px: usize) -> Gathered<'_> {
        let mut sums = vec![(0.0_f32, 0.0_f32); self.columns * self.rows];
        for (v, row) in image.chunks(width_px).enumerate() {
            for (patch, pixels) in row.chunks(PATCH_PX).enumerate() {
                let sum = &mut sums[v / PATCH_PX * self.columns + patch];
                sum.0 += pixels.iter().sum::<f32>();
                sum.1 += pixels.len() as f32;
            }
        }
        let means: Vec<f32> = sums.into_iter().map(|(sum, count)| sum / count.max(1.0)).collect();
        let received = |factors: &Vec<f32>| factors.iter().zip(&means).map(|(factor, light)| factor * light).sum();
        Gathered { bounce: self, light: self.factors.par_iter().map(received).collect() }
    }
}

/// Light that arrives at the patches.
pub(crate) struct Gathered<'a> {
    bounce: &'a Bounce,
    light: Vec<f32>,
}

impl Gathered<'_> {
    /// Light that arrives at the pixels of a row, from left to right.
    pub(crate) fn row(&self, v: usize) -> impl Iterator<Item = f32> + '_ {
        let columns = self.bounce.columns;
        let (upper, lower, down) = neighbours(v, self.bounce.rows);
        let column = move |patch: usize| {
            let (one, other) = (self.light[upper * columns + patch], self.light[lower * columns + patch]);
            one + (other - one) * down
        };
        (0..).map(move |u| {
            let (left, right, across) = neighbours(u, columns);
            let (one, other) = (column(left), column(right));
            one + (other - one) * across
        })
    }
}

/// Patches whose centres are before and after a pixel, and the weight of the latter.
fn neighbours(pixel: usize, patches: usize) -> (usize, usize, f32) {
    let place = ((pixel as f32 + 0.5) / PATCH_PX as f32 - 0.5).clamp(0.0, (patches - 1) as f32);
    let before = place as usize;
    (before, (before + 1).min(patches - 1), place - before as f32)
}
