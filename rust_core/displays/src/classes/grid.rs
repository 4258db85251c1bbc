//! `rviz/Grid`: a square grid of lines, or several above one another.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Matrix4, Point3, Vector3};
use rcs_rviz_config::{GridPlane, GridSettings, LineStyle};
use rcs_scene::{Blending, DisplayId, Drawable, Geometry, LineTopology, Lines, Material, Rgba, RibbonElement, Ribbons};

use crate::framework::display::Display;
use crate::framework::frame;
use crate::parts::solids::drawable;
use crate::{Level, Statuses, World};

/// Largest number of lines, in up to 50 MB. rviz draws any number, until its memory is used up.
const MAX_LINES: u64 = 500_000;

#[derive(Debug)]
pub(crate) struct GridDisplay {
    display: DisplayId,
    settings: GridSettings,
    /// `None` for too many lines.
    geometry: Option<Geometry>,
    place: Option<Isometry3<f64>>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

pub(crate) fn create(display: DisplayId, settings: &GridSettings) -> GridDisplay {
    let count = line_count(settings);
    let geometry = (count <= MAX_LINES).then(|| geometry(settings));
    let mut statuses = Statuses::default();
    if geometry.is_none() {
        statuses.set(Level::Error, "Grid", format!("{count} lines are too many, at most {MAX_LINES} are drawn"));
    }
    GridDisplay { display, settings: settings.clone(), geometry, place: None, drawables: Vec::new(), statuses }
}

impl Display for GridDisplay {
    fn update(&mut self, world: &World<'_>) -> bool {
        let reference_frame = self.settings.reference_frame.as_deref();
        let place = frame::follow(reference_frame, world, self.place, &mut self.statuses);
        if self.place == Some(place) && !self.drawables.is_empty() {
            return false;
        }
        self.place = Some(place);
        let Some(geometry) = &self.geometry else { return false };
        let fixed_from_grid = place.to_homogeneous() * frame_from_grid(&self.settings);
        let mut grid = drawable(self.display, fixed_from_grid, geometry.clone());
        if let Geometry::Ribbons(_) = geometry {
            // Ogre sorts chains by the middle of their box in their own frame, which is a grid's origin.
            grid.sort_point = Point3::origin();
        }
        self.drawables = vec![grid];
        true
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}

/// The grid is built in its own x–z plane and turned into the chosen one.
fn frame_from_grid(settings: &GridSettings) -> Matrix4<f64> {
    #[rustfmt::skip]
    let turn = match settings.plane {
        GridPlane::Xy => Matrix3::new(
            1.0, 0.0, 0.0,
            0.0, 0.0, 1.0,
            0.0, -1.0, 0.0,
        ),
        GridPlane::Xz => Matrix3::identity(),
        GridPlane::Yz => Matrix3::new(
            0.0, -1.0, 0.0,
            0.0, 0.0, -1.0,
            1.0, 0.0, 0.0,
        ),
    };
    Matrix4::new_translation(&Vector3::from(settings.offset_m).cast::<f64>()) * turn.to_homogeneous()
}

fn geometry(settings: &GridSettings) -> Geometry {
    let color = Rgba::from_rgb8(settings.color, settings.alpha);
    let blending = if color.a < Material::OPAQUE_FROM_ALPHA { Blending::Alpha } else { Blending::Replace };
    let color = color.to_rgba8();
    let segments = segments(settings);
    match settings.line_style {
        LineStyle::Lines => Geometry::Lines(Arc::new(Lines {
            positions: segments.into_iter().flatten().collect(),
            colors: vec![color],
            topology: LineTopology::List,
            blending,
        })),
        LineStyle::Billboards => Geometry::Ribbons(Arc::new(Ribbons {
            chains: segments
                .into_iter()
                .map(|segment| segment.map(|position| RibbonElement { position, color }).to_vec())
                .collect(),
            width_m: settings.line_width_m,
            blending,
        })),
    }
}

fn line_count(settings: &GridSettings) -> u64 {
    let (sides, layers) = (u64::from(settings.plane_cell_count.max(1)) + 1, u64::from(settings.normal_cell_count));
    let posts = if layers > 0 { sides.saturating_mul(sides) } else { 0 };
    (layers + 1).saturating_mul(2 * sides).saturating_add(posts)
}

/// All lines, each by its two ends, in rviz's order.
fn segments(settings: &GridSettings) -> Vec<[[f32; 3]; 2]> {
    let (cells, layers) = (settings.plane_cell_count.max(1), settings.normal_cell_count);
    let cell_m = settings.cell_size_m;
    let extent = (f64::from(cell_m) * f64::from(cells) / 2.0) as f32;
    let mut segments = Vec::with_capacity(line_count(settings) as usize);
    for layer in 0..=layers {
        let height = (layers as f32 / 2.0 - layer as f32) * cell_m;
        for i in 0..=cells {
            let at = extent - i as f32 * cell_m;
            segments.push([[at, height, -extent], [at, height, extent]]);
            segments.push([[-extent, height, at], [extent, height, at]]);
        }
    }
    if layers > 0 {
        let top = layers as f32 / 2.0 * cell_m;
        for i in 0..=cells {
            for j in 0..=cells {
                let (x, z) = (extent - i as f32 * cell_m, extent - j as f32 * cell_m);
                segments.push([[x, -top, z], [x, top, z]]);
            }
        }
    }
    segments
}

#[cfg(test)]
mod tests {
    use rcs_transforms::Time;

    use super::*;
    use crate::framework::test_world::TestWorld;

    #[test]
    fn a_grid_with_height_has_posts() {
        let settings = GridSettings { plane_cell_count: 2, normal_cell_count: 3, ..GridSettings::default() };
        assert_eq!(segments(&settings).len(), 4 * 6 + 9);
        assert_eq!(line_count(&settings), 4 * 6 + 9);
        assert_eq!(line_count(&GridSettings::default()), segments(&GridSettings::default()).len() as u64);
    }

    #[test]
    fn a_grid_of_more_lines_than_memory_is_an_error_status() {
        let world = TestWorld::at(Time::ZERO);
        for (plane_cell_count, normal_cell_count) in
            [(u32::MAX, 0), (i32::MAX as u32, i32::MAX as u32), (10, 85_788), (2000, 1)]
        {
            let settings = GridSettings { plane_cell_count, normal_cell_count, ..GridSettings::default() };
            let mut display = create(0, &settings);
            assert!(!display.update(&world.get()) && display.drawables().is_empty());
            let status = display.statuses().get("Grid").unwrap();
            assert!(status.level == Level::Error && status.text.contains("too many"), "{}", status.text);
        }
    }
}
