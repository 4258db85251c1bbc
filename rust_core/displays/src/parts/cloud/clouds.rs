//! Clouds of a display, decoded, coloured and kept for their decay time.

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use rcs_messages::sensor_msgs::PointField;
use rcs_messages::std_msgs::Header;
use rcs_messages::PointCloud2;
use rcs_rviz_config::{CloudSettings, ColorTransformer};
use rcs_scene::{
    DisplayId, Drawable, Geometry, Material, PackedPoints, PointBuffer, PointLook, PointStyle, MAX_POINT_SIZE_PX,
};
use rcs_transforms::Time;

use crate::framework::frame;
use crate::parts::bounds::middle;
use crate::parts::solids::drawable;
use crate::{Level, StatusText, Statuses, World};

use super::fields::CloudLayout;
use super::points::NonFinite;
use super::{color, pieces, points};

/// Field of a cloud: name, offset in a point, and datatype (see [`PointField`]).
pub(crate) type Field<'a> = (&'a str, u32, u8);

/// Makes a cloud of one row, from the little-endian bytes of its points.
pub(crate) fn one_row(header: &Header, fields: &[Field<'_>], point_step: u32, data: Vec<u8>) -> PointCloud2 {
    let field =
        |&(name, offset, datatype): &Field<'_>| PointField { name: name.to_owned(), offset, datatype, count: 1 };
    let mut cloud = PointCloud2::default();
    cloud.header = header.clone();
    cloud.fields = fields.iter().map(field).collect();
    cloud.height = 1;
    cloud.width = data.len().checked_div(point_step as usize).unwrap_or(0) as u32;
    cloud.point_step = point_step;
    cloud.row_step = data.len() as u32;
    cloud.with_data(data)
}

#[derive(Clone, Debug)]
pub(crate) struct PlacedCloud {
    pub(crate) cloud: Arc<PointCloud2>,
    pub(crate) fixed_from_cloud: Isometry3<f64>,
}

impl PlacedCloud {
    /// Places a cloud by its frame at its stamp.
    pub(crate) fn at_stamp(cloud: Arc<PointCloud2>, world: &World<'_>) -> Result<Self, StatusText> {
        match world.fixed_from_header(&cloud.header) {
            Ok(fixed_from_cloud) => Ok(Self { cloud, fixed_from_cloud }),
            Err(_) => Err(frame::transform_failed(&cloud.header.frame_id, world)),
        }
    }
}

#[derive(Debug)]
pub(crate) struct Clouds {
    display: DisplayId,
    settings: CloudSettings,
    non_finite: NonFinite,
    /// Sizes are multiplied by each point's z.
    auto_size: bool,
    /// `true` if the renderer decodes points by itself.
    pub(crate) packs_points: bool,
    shown: VecDeque<ReceivedCloud>,
    drawables: Vec<Drawable>,
}

#[derive(Debug)]
pub(crate) struct Decoded {
    drawables: Vec<Drawable>,
    transformer: ColorTransformer,
    /// Kept if the cloud may be coloured again.
    source: Option<PlacedCloud>,
}

#[derive(Debug)]
struct ReceivedCloud {
    received: Time,
    decoded: Decoded,
}

impl Clouds {
    pub(crate) fn new(display: DisplayId, settings: CloudSettings, non_finite: NonFinite) -> Self {
        Self {
            display,
            settings,
            non_finite,
            auto_size: false,
            packs_points: false,
            shown: VecDeque::new(),
            drawables: Vec::new(),
        }
    }

    pub(crate) fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    /// Scales points by their z from now on: a size in metres for each metre of z.
    pub(crate) fn set_auto_size(&mut self, size_m: f32) {
        (self.auto_size, self.settings.style) = (true, self.settings.style.with_side(size_m));
    }

    /// `true` if only the newest cloud is shown.
    pub(crate) fn keeps_one(&self) -> bool {
        self.settings.decay_time_secs <= 0.0
    }

    /// Makes the drawables of a cloud, for [`update`](Self::update); `None`, with a status, for an invalid one. Where
    /// only one is shown, the one before is removed.
    pub(crate) fn decode(&mut self, placed: PlacedCloud, statuses: &mut Statuses) -> Option<Decoded> {
        let (layout, transformer) = match CloudLayout::colored(&placed.cloud, &self.settings) {
            Ok(colored) => colored,
            Err(error) => {
                statuses.set(Level::Error, "Message", format!("{error}. Dropping message."));
                return None;
            }
        };
        if self.keeps_one() {
            self.clear();
        }
        if let Some(before) = self.settings.color_transformer.replace(transformer).filter(|one| *one != transformer) {
            let (before, now) = (before.name(), transformer.name());
            let text =
                format!("{before} does not fit the fields of a message. {now} is used from then on, as by rviz.");
            statuses.set(Level::Warn, "Color Transformer", text);
        }
        let (drawables, non_finite_count) = self.draw(&placed, &layout, transformer);
        let shown_count = layout.point_count - non_finite_count;
        let left_out = match non_finite_count {
            0 => String::new(),
            _ => format!(", {non_finite_count} without a finite position left out"),
        };
        let level = if shown_count == 0 && non_finite_count > 0 { Level::Warn } else { Level::Ok };
        statuses.set(level, "Points", format!("Showing {shown_count} points{left_out}"));
        if placed.cloud.is_bigendian {
            let text = "is_bigendian is set, but the numbers are read as little endian, as by rviz";
            statuses.set(Level::Warn, "Message", text);
        } else {
            statuses.remove("Message");
        }
        let source = (!self.keeps_one()).then_some(placed);
        Some(Decoded { drawables, transformer, source })
    }

    /// Drawables of a cloud, and the number of its points without a finite position.
    fn draw(
        &mut self,
        placed: &PlacedCloud,
        layout: &CloudLayout,
        transformer: ColorTransformer,
    ) -> (Vec<Drawable>, usize) {
        let settings = &self.settings;
        let coloring = color::Coloring::new(settings, transformer, &placed.fixed_from_cloud);
        let style = match settings.style {
            PointStyle::Points { diameter_px } => {
                PointStyle::Points { diameter_px: diameter_px.min(MAX_POINT_SIZE_PX) }
            }
            style => style,
        };
        let blended = settings.alpha < Material::OPAQUE_FROM_ALPHA || layout.has_point_alpha();
        let look = PointLook { style, alpha: settings.alpha, blended, auto_size: self.auto_size };
        let at_cloud = |geometry| drawable(self.display, placed.fixed_from_cloud.to_homogeneous(), geometry);
        if self.packs_points && !blended && self.non_finite == NonFinite::LeftOut {
            let positions = layout.positions();
            let pack = |colors| PackedPoints::new(placed.cloud.clone(), layout.point_step, positions, colors, look);
            if let Some(packed) = coloring.packed_colors(layout).and_then(pack) {
                let non_finite_count = packed.count() - packed.finite_count();
                return (vec![at_cloud(Geometry::Packed(Arc::new(packed)))], non_finite_count);
            }
        }
        let (buffer, non_finite_count) = points::read(&placed.cloud, layout, &coloring, self.non_finite);
        // The order of the pieces is visible only where they blend.
        let buffers = if blended { pieces::cut(buffer, &style) } else { vec![buffer] };
        let piece = |buffer: PointBuffer| {
            // Ogre sorts translucent clouds by the middle of their box in their own frame, as if that were the fixed
            // one. Opaque ones are not sorted.
            let sort_point = if blended { middle(buffer.positions.iter().copied()) } else { [0.0; 3] };
            let points = look.of(Arc::new(buffer));
            Drawable { sort_point: Point3::from(sort_point).cast(), ..at_cloud(Geometry::Points(points)) }
        };
        (buffers.into_iter().map(piece).collect(), non_finite_count)
    }

    /// Adds new clouds, oldest first, and removes expired ones. Returns whether anything changed.
    pub(crate) fn update(&mut self, new: Vec<Decoded>, now: Time) -> bool {
        let changed = self.expire(now, !new.is_empty()) || !new.is_empty();
        self.shown.extend(new.into_iter().map(|decoded| ReceivedCloud { received: now, decoded }));
        if changed {
            self.recolor();
            self.drawables.clear();
            self.drawables.extend(self.shown.iter().flat_map(|shown| &shown.decoded.drawables).cloned());
        }
        changed
    }

    /// Colours clouds of another transformer again: a cloud that does not fit the transformer changes it for those
    /// before as well.
    fn recolor(&mut self) {
        let Some(transformer) = self.settings.color_transformer else { return };
        let mut shown = std::mem::take(&mut self.shown);
        for ReceivedCloud { decoded, .. } in &mut shown {
            let Some(source) = decoded.source.as_ref().filter(|_| decoded.transformer != transformer) else { continue };
            let Ok((layout, fitting)) = CloudLayout::colored(&source.cloud, &self.settings) else { continue };
            if fitting == transformer {
                decoded.drawables = self.draw(source, &layout, transformer).0;
                decoded.transformer = transformer;
            }
        }
        self.shown = shown;
    }

    /// Removes expired clouds. Without a decay time those are all, but only once there is a new one.
    fn expire(&mut self, now: Time, is_followed: bool) -> bool {
        let decay_secs = f64::from(self.settings.decay_time_secs);
        let before = self.shown.len();
        if decay_secs > 0.0 || is_followed {
            while self.shown.front().is_some_and(|shown| now.secs_since(shown.received) >= decay_secs) {
                self.shown.pop_front();
            }
        }
        self.shown.len() != before
    }

    /// Time at which the oldest cloud expires.
    pub(crate) fn next_change(&self) -> Option<Time> {
        let decay = std::time::Duration::try_from_secs_f32(self.settings.decay_time_secs).ok()?;
        let oldest = self.shown.front().filter(|_| !decay.is_zero())?;
        Some(oldest.received.saturating_add(decay))
    }

    pub(crate) fn clear(&mut self) {
        self.shown.clear();
        self.drawables.clear();
    }
}
