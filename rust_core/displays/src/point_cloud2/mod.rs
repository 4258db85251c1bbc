//! `rviz/PointCloud2`: a cloud's points in one of five styles, coloured by one of six transformers.
//!
//! A cloud stands where its frame was at its stamp. It is decoded and coloured once, when it is placed; drawing it
//! again costs no decoding. Without a decay time the newest cloud replaces the one before it.

mod color;
mod fields;
mod points;

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use rcs_messages::{AnyMessage, MessageKind, PointCloud2};
use rcs_rviz_config::{PointCloud2Settings, PointStyle as StyleSetting};
use rcs_scene::{DisplayId, Drawable, Geometry, Material, PointBuffer, PointStyle, Points, RenderGroup};
use rcs_transforms::Time;

use crate::bounds::middle;
use crate::display::{Display, TopicRequest};
use crate::placed::Incoming;
use crate::{Level, Statuses, World};
use fields::Layout;

/// The largest point that Mesa and Intel's drivers draw, in pixels; rviz's larger ones come out at this size.
const MAX_POINT_PX: f32 = 255.0;

/// A PointCloud2 display.
#[derive(Debug)]
pub(crate) struct PointCloud2Display {
    display: DisplayId,
    settings: PointCloud2Settings,
    incoming: Incoming<PointCloud2>,
    clouds: VecDeque<Cloud>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

/// A cloud that is shown.
#[derive(Debug)]
struct Cloud {
    received: Time,
    drawable: Drawable,
}

impl PointCloud2Display {
    pub(crate) fn new(display: DisplayId, settings: PointCloud2Settings) -> Self {
        Self {
            display,
            incoming: Incoming::new(settings.queue_size),
            settings,
            clouds: VecDeque::new(),
            drawables: Vec::new(),
            statuses: Statuses::default(),
        }
    }

    /// The cloud as a drawable; `None`, with a status that says why, where it cannot be shown.
    fn place(&mut self, cloud: &PointCloud2, fixed_from_cloud: &Isometry3<f64>) -> Option<Drawable> {
        let layout = match Layout::of(cloud) {
            Ok(layout) => layout,
            Err(error) => {
                self.statuses.set(Level::Error, "Message", format!("{error}. Dropping message."));
                return None;
            }
        };
        let transformer = layout.fitting_transformer(self.settings.color_transformer);
        self.settings.color_transformer = Some(transformer);
        let buffer = points::read(cloud, &layout, &color::Coloring::new(&self.settings, transformer, fixed_from_cloud));
        self.statuses.set(Level::Ok, "Points", format!("Showing {} points", buffer.positions.len()));
        self.statuses.remove("Message");
        Some(self.drawable(buffer, layout.has_point_alpha(), fixed_from_cloud))
    }

    fn drawable(&self, buffer: PointBuffer, has_point_alpha: bool, fixed_from_cloud: &Isometry3<f64>) -> Drawable {
        let settings = &self.settings;
        let size_m = settings.size_m;
        let style = match settings.style {
            StyleSetting::Points => PointStyle::Points { diameter_px: settings.size_px.min(MAX_POINT_PX) },
            StyleSetting::Squares => PointStyle::Squares { size_m: [size_m; 2] },
            StyleSetting::FlatSquares => PointStyle::FlatSquares { side_m: size_m },
            StyleSetting::Spheres => PointStyle::Spheres { size_m: [size_m; 2] },
            StyleSetting::Boxes => PointStyle::Boxes { size_m: [size_m; 3] },
        };
        // Ogre sorts translucent clouds by the middle of their box in their own frame, as if that were the fixed one.
        let sort_point = middle(buffer.positions.iter().copied());
        let points = Points {
            buffer: Arc::new(buffer),
            style,
            alpha: settings.alpha,
            blended: settings.alpha < Material::OPAQUE_FROM_ALPHA || has_point_alpha,
            auto_size: false,
        };
        Drawable {
            display: self.display,
            fixed_from_object: fixed_from_cloud.to_homogeneous(),
            sort_point: Point3::from(sort_point).cast(),
            group: RenderGroup::Main,
            geometry: Geometry::Points(points),
        }
    }

    /// Takes away the clouds that are too old. Without a decay time that is all of them, but only once there is a new
    /// one.
    fn expire(&mut self, now: Time, new_cloud: bool) -> bool {
        let decay_secs = f64::from(self.settings.decay_time_secs);
        let before = self.clouds.len();
        if decay_secs > 0.0 || new_cloud {
            while self.clouds.front().is_some_and(|cloud| now.secs_since(cloud.received) >= decay_secs) {
                self.clouds.pop_front();
            }
        }
        self.clouds.len() != before
    }
}

impl Display for PointCloud2Display {
    fn topics(&self) -> Vec<TopicRequest> {
        let settings = &self.settings;
        TopicRequest::new(&settings.topic, MessageKind::PointCloud2, settings.queue_size).into_iter().collect()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        if let AnyMessage::PointCloud2(cloud) = message {
            self.incoming.push(&cloud.header, cloud.clone(), &mut self.statuses);
        }
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        let mut ready = self.incoming.take_ready(world, &mut self.statuses);
        if self.settings.decay_time_secs <= 0.0 {
            // Only the newest that can be shown would be seen.
            ready.reverse();
        }
        let mut placed = Vec::new();
        for cloud in ready {
            let Ok(fixed_from_cloud) = world.fixed_from_header(&cloud.header) else { continue };
            placed.extend(self.place(&cloud, &fixed_from_cloud));
            if self.settings.decay_time_secs <= 0.0 && !placed.is_empty() {
                break;
            }
        }
        let mut changed = self.expire(world.now, !placed.is_empty());
        changed |= !placed.is_empty();
        self.clouds.extend(placed.into_iter().map(|drawable| Cloud { received: world.now, drawable }));
        if changed {
            self.drawables.clear();
            self.drawables.extend(self.clouds.iter().map(|cloud| cloud.drawable.clone()));
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn next_change(&self) -> Option<Time> {
        let decay = std::time::Duration::try_from_secs_f32(self.settings.decay_time_secs).ok()?;
        let oldest = self.clouds.front().filter(|_| !decay.is_zero())?;
        Some(oldest.received.saturating_add(decay))
    }

    fn reset(&mut self) {
        self.incoming.clear();
        self.clouds.clear();
        self.drawables.clear();
        self.statuses.clear();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
