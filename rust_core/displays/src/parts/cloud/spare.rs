//! The memory of clouds that are not shown any more, for those that come.
//!
//! A cloud that was replaced may still be in a scene that somebody draws, and what renderers derive from a cloud goes by
//! its `Arc`. So a replaced cloud waits until nobody holds it any more, and then its vectors become part of another
//! cloud, in another `Arc`. That is mostly so when the next one is read, so that one cloud's memory is in use.

use std::sync::Arc;

use rcs_messages::BufferPool;
use rcs_scene::{Drawable, Geometry, PointBuffer, PointColors};

/// How many clouds of the present size may be spare: a whole one, the pieces of another, and what both have room for on
/// top.
const MAX_CLOUDS: usize = 3;

/// Vectors that clouds are made of, and what reading a cloud needs meanwhile.
#[derive(Debug, Default)]
pub(super) struct SparePoints {
    pub(super) positions: BufferPool<[f32; 3]>,
    pub(super) colors: BufferPool<[u8; 4]>,
    /// How many points are shown of each share of them.
    pub(super) shown: Vec<usize>,
    /// What points are coloured by.
    pub(super) values: Vec<f32>,
    /// Clouds that are not shown any more.
    retired: Vec<Arc<PointBuffer>>,
}

impl SparePoints {
    /// Takes note that these are not shown any more.
    pub(super) fn retire(&mut self, drawables: &[Drawable]) {
        self.retired.extend(drawables.iter().filter_map(|drawable| match &drawable.geometry {
            Geometry::Points(points) => Some(points.buffer.clone()),
            _ => None,
        }));
    }

    /// Takes back what nobody draws any more, before a cloud of so many points is read.
    pub(super) fn reclaim(&mut self, count: usize) {
        for buffer in std::mem::take(&mut self.retired) {
            match Arc::try_unwrap(buffer) {
                Ok(buffer) => self.give(buffer),
                Err(buffer) => self.retired.push(buffer),
            }
        }
        self.positions.limit_to(MAX_CLOUDS * count);
        self.colors.limit_to(MAX_CLOUDS * count);
    }

    /// Takes a cloud's memory.
    pub(super) fn give(&mut self, buffer: PointBuffer) {
        self.positions.give(buffer.positions);
        if let PointColors::PerPoint(colors) = buffer.colors {
            self.colors.give(colors);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix4, Point3};
    use rcs_scene::{PointStyle, Points, RenderGroup};

    use super::*;

    const COUNT: usize = 10_000;

    fn drawable(buffer: PointBuffer) -> Drawable {
        let style = PointStyle::Points { diameter_px: 1.0 };
        let points = Points { buffer: Arc::new(buffer), style, alpha: 1.0, blended: false, auto_size: false };
        Drawable {
            display: 0,
            fixed_from_object: Matrix4::identity(),
            sort_point: Point3::origin(),
            group: RenderGroup::Main,
            geometry: Geometry::Points(points),
        }
    }

    #[test]
    fn a_cloud_s_memory_is_taken_back_when_the_last_scene_with_it_is_gone() {
        let mut spare = SparePoints::default();
        let positions = spare.positions.take(COUNT);
        let address = positions.as_ptr();
        let shown = drawable(PointBuffer { positions, colors: PointColors::Uniform([0; 4]) });
        let scene = shown.clone();
        // As a renderer on the GPU holds it.
        let Geometry::Points(points) = &shown.geometry else { unreachable!() };
        let derived = Arc::downgrade(&points.buffer);
        spare.retire(&[shown]);
        spare.reclaim(COUNT);
        let other = spare.positions.take(COUNT);
        assert_ne!(other.as_ptr(), address, "it is still drawn");
        drop(scene);
        spare.reclaim(COUNT);
        let taken = spare.positions.take(COUNT);
        assert_eq!(taken.as_ptr(), address);
        assert!(derived.upgrade().is_none(), "for the renderer the cloud is gone");
    }

    #[test]
    fn of_many_clouds_that_go_at_once_only_some_memory_is_kept() {
        let mut spare = SparePoints::default();
        for _ in 0..10 {
            spare.give(PointBuffer { positions: Vec::with_capacity(COUNT), colors: PointColors::Uniform([0; 4]) });
        }
        spare.reclaim(COUNT);
        let kept = (0..10).filter(|_| spare.positions.take(COUNT).capacity() == COUNT).count();
        assert_eq!(kept, MAX_CLOUDS);
    }
}
