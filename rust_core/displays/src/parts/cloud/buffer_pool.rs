//! A pool of the buffers of replaced clouds, which new clouds are read into.
//!
//! A replaced cloud may still be in a scene that is being drawn, and renderers tell clouds apart by their `Arc`s. So it
//! is kept until no one else holds it; then its vectors become part of another cloud, in another `Arc`. That is mostly
//! so when the next cloud is read, so that one cloud's memory is in use.

use std::sync::Arc;

use rcs_messages::BufferPool;
use rcs_scene::{Drawable, Geometry, PointBuffer, PointColors};

/// Capacity in clouds of the present size: a whole one, the pieces of another, and the slack of both.
const MAX_CLOUDS: usize = 3;

/// Vectors of clouds, and scratch buffers.
#[derive(Debug, Default)]
pub(super) struct CloudPool {
    pub(super) positions: BufferPool<[f32; 3]>,
    pub(super) colors: BufferPool<[u8; 4]>,
    /// Scratch: number of visible points of each share.
    pub(super) shown: Vec<usize>,
    /// Scratch: values by which points are coloured.
    pub(super) values: Vec<f32>,
    /// Clouds that may still be drawn.
    retired: Vec<Arc<PointBuffer>>,
}

impl CloudPool {
    /// Adds drawables that are not shown any more.
    pub(super) fn retire(&mut self, drawables: &[Drawable]) {
        self.retired.extend(drawables.iter().filter_map(|drawable| match &drawable.geometry {
            Geometry::Points(points) => Some(points.buffer.clone()),
            _ => None,
        }));
    }

    /// Reclaims clouds that are not drawn any more, before a cloud of `count` points is read.
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
        let mut pool = CloudPool::default();
        let positions = pool.positions.take(COUNT);
        let address = positions.as_ptr();
        let shown = drawable(PointBuffer { positions, colors: PointColors::Uniform([0; 4]) });
        let scene = shown.clone();
        // As a renderer on the GPU holds it.
        let Geometry::Points(points) = &shown.geometry else { unreachable!() };
        let derived = Arc::downgrade(&points.buffer);
        pool.retire(&[shown]);
        pool.reclaim(COUNT);
        let other = pool.positions.take(COUNT);
        assert_ne!(other.as_ptr(), address, "it is still drawn");
        drop(scene);
        pool.reclaim(COUNT);
        let taken = pool.positions.take(COUNT);
        assert_eq!(taken.as_ptr(), address);
        assert!(derived.upgrade().is_none(), "for the renderer the cloud is gone");
    }

    #[test]
    fn of_many_clouds_that_go_at_once_only_some_memory_is_kept() {
        let mut pool = CloudPool::default();
        for _ in 0..10 {
            pool.give(PointBuffer { positions: Vec::with_capacity(COUNT), colors: PointColors::Uniform([0; 4]) });
        }
        pool.reclaim(COUNT);
        let kept = (0..10).filter(|_| pool.positions.take(COUNT).capacity() == COUNT).count();
        assert_eq!(kept, MAX_CLOUDS);
    }
}
