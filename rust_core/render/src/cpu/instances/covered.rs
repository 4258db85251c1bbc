//! The triangles of a small solid that cover a pixel, found several at once.

use fearless_simd::dispatch;

use super::corners::{InstanceScratch, Source};
use super::lit::PlainLight;
use super::shape::Shape;
use crate::cpu::cover::Cover;
use crate::cpu::lanes::LANES;
use crate::cpu::occlusion::Area;
use crate::cpu::screen::Screen;
use crate::cpu::triangles::Corner;

/// Passes on those of a solid's triangles that cover pixels of an area, in their order: the corners, the triangle's
/// number, and each row that it covers with the first pixel and the one after the last.
///
/// The solid is one with a small [`Footprint`](super::reach::Footprint), whose vertices were placed.
pub(super) fn for_covered(
    (shape, numbers): (&Shape, impl Iterator<Item = u32>),
    (source, area, screen): (&Source<'_>, Area, &Screen),
    scratch: &mut InstanceScratch,
    cover: &mut Cover,
    mut draw: impl FnMut([&Corner; 3], u32, &mut dyn Iterator<Item = (i32, i32, i32)>),
) {
    let light = PlainLight::of(shape, source);
    let mut is_lit = false;
    if light.is_none() {
        scratch.begin();
    }
    let mut numbers = numbers.peekable();
    while numbers.peek().is_some() {
        let mut triangles = [0; LANES];
        for (lane, triangle) in triangles.iter_mut().enumerate() {
            let next = numbers.next();
            let places = next.and_then(|number| shape.places.get(number as usize)).copied();
            match places {
                Some([a, b, c]) => cover.set(lane, [scratch.place_of(a), scratch.place_of(b), scratch.place_of(c)]),
                None => cover.clear(lane),
            }
            *triangle = next.unwrap_or_default();
        }
        let mut covering = dispatch!(screen.simd_level, simd => cover.find(simd, area));
        while covering != 0 {
            let lane = covering.trailing_zeros() as usize % LANES;
            covering &= covering - 1;
            let number = triangles[lane] as usize;
            if let Some(light) = &light {
                let (normals, places) = (shape.triangle_normals.get(number), shape.places.get(number));
                let (Some(normals), Some(places)) = (normals, places) else { continue };
                if !std::mem::replace(&mut is_lit, true) {
                    dispatch!(screen.simd_level, simd => light.light(simd, shape, scratch));
                }
                let corner = |i: usize| scratch.lit_corner(normals[i], places[i], light.alpha());
                draw([&corner(0), &corner(1), &corner(2)], triangles[lane], &mut cover.rows(lane));
                continue;
            }
            let Some(&corners) = shape.triangles.get(number) else { continue };
            let mut place = |key| scratch.corner(key, source, screen, true);
            if let [Some((a, _)), Some((b, _)), Some((c, _))] = corners.map(&mut place) {
                draw([&a, &b, &c], triangles[lane], &mut cover.rows(lane));
            }
        }
    }
}
