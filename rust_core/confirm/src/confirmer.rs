//! Confirms the light of one camera.

use std::sync::Arc;
use std::time::Duration;

use nalgebra::Isometry3;
use rcs_render::LightMask;
use rcs_scene::Camera;

use crate::cells::{cells_of, CELL_PX};
use crate::comparison::{mask_levels, Comparison};
use crate::hold_times::HoldTimes;
use crate::image_cells::{image_px, is_as_drawn, ImageCells};
use crate::surface::{Bounds, Surface};
use crate::tiles::Tiles;
use crate::{ConfirmSettings, ObjectDepths, PointGrid, Shares};

/// Light that is confirmed.
#[derive(Clone, Debug)]
pub struct Confirmation {
    /// 255 where light is allowed, 0 where it is not; of the image's size. `None` for an image without pixels.
    pub mask: Option<Arc<LightMask>>,
    /// Shares of the pixels that the listed displays light.
    pub shares: Shares,
}

/// Confirms a camera's light by measured surfaces. One for each camera.
///
/// ```
/// use std::time::Duration;
///
/// use nalgebra::Isometry3;
/// use rcs_confirm::{ConfirmSettings, Confirmer, ObjectDepths, PointGrid};
/// use rcs_scene::{Camera, Intrinsics};
///
/// // A wall at 2 m, seen by a depth camera at the projector's place.
/// let rays: Vec<_> = (0..60 * 40).map(|i| [(i % 60) as f32 / 60.0 - 0.5, (i / 60) as f32 / 60.0 - 0.35]).collect();
/// let wall = PointGrid::from_depths([60, 40], &vec![2.0; rays.len()], &rays);
/// let p = [100.0, 0.0, 20.0, 0.0, 0.0, 100.0, 15.0, 0.0, 0.0, 0.0, 1.0, 0.0];
/// let camera = Camera::new(Intrinsics::exactly(40, 30, &p)?.0, &Isometry3::identity(), 0.01);
///
/// let mut confirmer = Confirmer::new(ConfirmSettings::default());
/// let objects = ObjectDepths { size_px: [40, 30], depths_m: &[2.01; 1200], is_strict: false };
/// // Light comes on when depth images have agreed for 0.3 s.
/// for (at_ms, level) in [(0, 0), (200, 0), (400, 255)] {
///     confirmer.observe(&camera, &Isometry3::identity(), &wall, Duration::from_millis(at_ms));
///     let confirmation = confirmer.confirm(&objects);
///     assert_eq!(confirmation.shares.confirmed, 1.0);
///     assert!(confirmation.mask.is_some_and(|mask| mask.levels() == [level; 1200]));
/// }
/// // The wall is not where this object is.
/// let elsewhere = ObjectDepths { depths_m: &[1.5; 1200], ..objects };
/// assert_eq!(confirmer.confirm(&elsewhere).shares.confirmed, 0.0);
/// # Ok::<(), rcs_scene::CameraError>(())
/// ```
#[derive(Debug)]
pub struct Confirmer {
    settings: ConfirmSettings,
    surface: Surface,
    /// Size of the finished image that has a surface.
    surface_px: Option<[u32; 2]>,
    /// Cells of the finished image, if it is not the drawn one.
    image_cells: Option<ImageCells>,
    /// Bounds in the finished image, and in the drawn one if that is another.
    bounds: Bounds,
    drawn_bounds: Bounds,
    /// Tiles with light in the finished image, and in the drawn one if that is another.
    lit: Tiles,
    drawn_lit: Tiles,
    comparison: Comparison,
    hold_times: HoldTimes,
    /// Time of the depth image until it is compared for the first time.
    uncompared: Option<Duration>,
}

impl Confirmer {
    /// A confirmer that knows no surface yet: all light of listed displays is dark.
    pub fn new(settings: ConfirmSettings) -> Self {
        Self {
            settings,
            surface: Surface::default(),
            surface_px: None,
            image_cells: None,
            bounds: Bounds::default(),
            drawn_bounds: Bounds::default(),
            lit: Tiles::default(),
            drawn_lit: Tiles::default(),
            comparison: Comparison::default(),
            hold_times: HoldTimes::new(0),
            uncompared: None,
        }
    }

    /// Takes a depth image: the closed surface as seen from the projector. `camera` is the projector's exact camera
    /// with lens and flip; its pose plays no part. `projector_from_sensor` maps the grid's points to the projector's
    /// optical frame at the depth image's stamp; `now` is monotonic. A grid with fewer points than pixels is no
    /// surface.
    pub fn observe(
        &mut self,
        camera: &Camera,
        projector_from_sensor: &Isometry3<f64>,
        grid: &PointGrid,
        now: Duration,
    ) {
        let [columns, rows] = grid.size_px.map(|side| side as usize);
        if columns.checked_mul(rows) != Some(grid.points.len()) {
            self.forget();
            return;
        }
        self.surface.take(camera.intrinsics(), projector_from_sensor, grid);
        let known = self.image_cells.take().filter(|cells| cells.are_of(camera));
        self.image_cells = known.or_else(|| (!is_as_drawn(camera)).then(|| ImageCells::new(camera)));
        self.surface_px = Some(image_px(camera));
        self.uncompared = Some(now);
    }

    /// Forgets the surface because it is stale: all light of listed displays is dark until enough new ones agree.
    pub fn forget(&mut self) {
        self.surface_px = None;
        self.hold_times.interrupt();
    }

    /// Compares the depths of the image that is to be shown with the surface. Light comes on only when a depth image is
    /// compared for the first time. It is dark while there is no surface, or one of another size, whatever the settings
    /// say about what is unseen.
    pub fn confirm(&mut self, objects: &ObjectDepths<'_>) -> Confirmation {
        let [columns, rows] = objects.size_px.map(|side| side as usize);
        self.hold_times.fit(cells_of(objects.size_px).iter().product());
        if self.surface_px != Some(objects.size_px) || objects.depths_m.len() != columns * rows {
            return self.without_surface(objects);
        }
        let margin = (self.settings.margin_px as usize).div_ceil(CELL_PX);
        self.comparison.take(objects);
        self.comparison.lit_tiles(margin, &mut self.lit);
        self.draw_bounds(objects.size_px);
        self.comparison.compare(&self.bounds, margin);
        let disagreements = self.comparison.disagreements(self.settings.unseen);
        self.hold_times.update(disagreements, self.uncompared.take(), self.settings.max_gap);
        let levels = mask_levels(objects, self.hold_times.waits());
        Confirmation { mask: LightMask::new(objects.size_px, levels).map(Arc::new), shares: self.comparison.shares() }
    }

    /// Brings the bounds up to date where there is light.
    fn draw_bounds(&mut self, size_px: [u32; 2]) {
        let tolerance_m = self.settings.tolerance_m;
        let Some(cells) = &self.image_cells else {
            self.surface.draw(&self.lit, tolerance_m, &mut self.bounds);
            return;
        };
        cells.see_tiles(&self.lit, &mut self.drawn_lit);
        if self.surface.draw(&self.drawn_lit, tolerance_m, &mut self.drawn_bounds) {
            cells.see(&self.drawn_bounds, size_px, &mut self.bounds);
        }
    }

    fn without_surface(&mut self, objects: &ObjectDepths<'_>) -> Confirmation {
        self.hold_times.interrupt();
        let count = objects.size_px[0] as usize * objects.size_px[1] as usize;
        let level = |depth: &f32| if depth.is_nan() && !objects.is_strict { 255 } else { 0 };
        let mut levels: Vec<u8> = objects.depths_m.iter().take(count).map(level).collect();
        levels.resize(count, 0);
        let is_any = objects.depths_m.iter().any(|depth| !depth.is_nan());
        let shares = Shares { unseen: if is_any { 1.0 } else { 0.0 }, ..Shares::default() };
        Confirmation { mask: LightMask::new(objects.size_px, levels).map(Arc::new), shares }
    }
}
