//! `rviz/RobotModel`: a robot's links where TF says that they are.
//!
//! The links follow TF at its latest time. One whose frame is unknown stays at its last place (at first: the fixed
//! frame's origin) and is drawn in plain white without light, as in rviz. Links appear as their meshes and textures are
//! loaded.

mod build;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::sync::Arc;
use std::time::Duration;

use nalgebra::{Isometry3, Matrix4, Vector3};
use rcs_resources::Retry;
use rcs_rviz_config::{LinkSettings, RobotModelSettings};
use rcs_scene::{DisplayId, Drawable, Geometry, Material};
use rcs_transforms::Time;

use crate::framework::display::Display;
use crate::parts::robot_description::{link_frame, RobotDescription, StatusTexts, STATUS};
use crate::parts::solids::{axes, axes_materials, drawable};
use crate::parts::trail::Trail;
use crate::{Level, StatusText, Statuses, World};
use rcs_robot::Robot;

use build::{Builder, LinkPart, LinkParts};

const STATUS_TEXTS: StatusTexts = StatusTexts { good: "URDF parsed OK", bad: "Failed to parse URDF model" };
/// Shortest interval; a shorter one is none.
const SHORTEST_INTERVAL_SECS: f32 = 0.0001;
/// rviz's length and diameter (which it calls radius) of a link's axes.
const AXES_M: (f64, f64) = (0.1, 0.01);
const TRAIL_COLOR: [u8; 4] = [0, 127, 127, 255];

#[derive(Debug)]
struct ShownLink {
    frame: String,
    settings: LinkSettings,
    parts: LinkParts,
    fixed_from_link: Isometry3<f64>,
    /// `true` if its frame is known; `None` before the first update.
    is_placed: Option<bool>,
    trail: Option<Trail>,
}

impl ShownLink {
    /// A link without geometry cannot be switched off.
    fn is_shown(&self) -> bool {
        self.settings.enabled || (self.parts.visuals.is_empty() && self.parts.collisions.is_empty())
    }

    fn drawn_parts<'a>(&'a self, settings: &'a RobotModelSettings) -> impl Iterator<Item = &'a LinkPart> {
        let is_shown = self.is_shown();
        let visuals = self.parts.visuals.iter().filter(move |_| is_shown && settings.visual_enabled);
        visuals.chain(self.parts.collisions.iter().filter(move |_| is_shown && settings.collision_enabled))
    }

    /// Follows its frame. Returns whether its place, or whether the frame is known, changed.
    fn follow(&mut self, settings: &RobotModelSettings, world: &World<'_>, statuses: &mut Statuses) -> bool {
        let has_axes_or_trail = self.is_shown() && (self.settings.show_axes || self.trail.is_some());
        let is_drawn = has_axes_or_trail || self.drawn_parts(settings).next().is_some();
        // A link that is not drawn has a status only.
        let place = if is_drawn { world.fixed_from_moving(&self.frame) } else { world.fixed_from_now(&self.frame) };
        let place = place.ok();
        let was_placed = self.is_placed.replace(place.is_some());
        if was_placed != self.is_placed {
            match place {
                Some(_) => statuses.set(Level::Ok, &self.frame, "Transform OK"),
                None => {
                    let text = format!("No transform from [{}] to [{}]", self.frame, world.fixed_frame);
                    statuses.set(Level::Error, &self.frame, StatusText::about_frame(text));
                }
            }
        }
        let moved = place.is_some_and(|place| place != self.fixed_from_link);
        self.fixed_from_link = place.unwrap_or(self.fixed_from_link);
        if let Some(trail) = &mut self.trail {
            if moved {
                trail.follow(self.fixed_from_link.translation.vector);
            }
        }
        moved || was_placed != self.is_placed
    }
}

#[derive(Debug)]
pub(crate) struct RobotModelDisplay {
    display: DisplayId,
    settings: RobotModelSettings,
    description: RobotDescription,
    links: Vec<ShownLink>,
    /// The robot, while files of it are loading or cannot be used.
    unfinished: Option<Robot>,
    /// Version of the meshes when the links were last built.
    meshes_version: u64,
    /// URLs of textures whose failure was logged.
    logged: BTreeSet<String>,
    axes_materials: [Arc<Material>; 3],
    unplaced_material: Arc<Material>,
    updated: Option<Time>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

pub(crate) fn create(display: DisplayId, settings: &RobotModelSettings) -> RobotModelDisplay {
    let mut statuses = Statuses::default();
    RobotModelDisplay {
        display,
        description: RobotDescription::new(&settings.robot_description, &mut statuses),
        settings: settings.clone(),
        links: Vec::new(),
        unfinished: None,
        meshes_version: 0,
        logged: BTreeSet::new(),
        axes_materials: axes_materials(1.0),
        unplaced_material: Arc::new(Material { vertex_colors: false, ..Material::unlit(false) }),
        updated: None,
        drawables: Vec::new(),
        statuses,
    }
}

impl RobotModelDisplay {
    fn load(&mut self, robot: Robot, world: &World<'_>) {
        for name in robot.links.keys() {
            let settings = self.settings.link(name).clone();
            self.links.push(ShownLink {
                frame: link_frame(&self.settings.tf_prefix, name),
                trail: settings.show_trail.then(trail_from_origin),
                settings,
                parts: LinkParts::default(),
                fixed_from_link: Isometry3::identity(),
                is_placed: None,
            });
        }
        self.build(robot, world, Retry::Yes);
    }

    /// Builds the parts of the links whose files are loaded.
    fn build(&mut self, robot: Robot, world: &World<'_>, retry: Retry) {
        self.meshes_version = world.meshes.version();
        let mut builder = Builder::new(&robot, world.meshes, retry, &mut self.logged);
        let mut faults = String::new();
        for (shown, (name, link)) in self.links.iter_mut().zip(&robot.links) {
            shown.parts = builder.link(link, self.settings.alpha * shown.settings.alpha);
            if !shown.parts.faults.is_empty() {
                // Writing to a text does not fail.
                let _ = write!(faults, "\n• for link '{name}':\n{}", shown.parts.faults.join("\n"));
            }
        }
        let loading = builder.loading();
        let (level, text) = match loading {
            _ if !faults.is_empty() => (Level::Error, format!("Errors loading geometries:{faults}")),
            0 => (Level::Ok, STATUS_TEXTS.good.to_owned()),
            _ => (Level::Ok, format!("Loading geometries: {loading} left")),
        };
        self.statuses.set(level, STATUS, text);
        self.unfinished = (loading > 0 || !faults.is_empty()).then_some(robot);
    }

    /// Rebuilds the links if files of them were loaded since the last call. Returns whether it did.
    fn build_loaded(&mut self, world: &World<'_>) -> bool {
        if world.meshes.version() == self.meshes_version {
            return false;
        }
        let Some(robot) = self.unfinished.take() else { return false };
        self.build(robot, world, Retry::No);
        true
    }

    fn interval(&self) -> Option<Duration> {
        let interval_secs = self.settings.update_interval_secs;
        (interval_secs >= SHORTEST_INTERVAL_SECS).then(|| Duration::try_from_secs_f32(interval_secs).ok()).flatten()
    }

    /// `true` if the links are to be moved. Those that were never placed are looked up every time.
    fn is_due(&self, now: Time) -> bool {
        let (Some(interval), Some(updated)) = (self.interval(), self.updated) else { return true };
        let unplaced = self.links.iter().any(|link| link.is_placed != Some(true));
        unplaced || now < updated || now >= updated.saturating_add(interval)
    }

    fn draw(&mut self) {
        self.drawables.clear();
        let (display, settings) = (self.display, &self.settings);
        for link in self.links.iter().filter(|link| link.is_shown()) {
            let fixed_from_link = link.fixed_from_link.to_homogeneous();
            let is_placed = link.is_placed == Some(true);
            self.drawables.extend(link.drawn_parts(settings).map(|part| {
                let material = if is_placed { &part.material } else { &self.unplaced_material };
                placed(display, &fixed_from_link, part, material)
            }));
            if link.settings.show_axes {
                let (length_m, diameter_m) = AXES_M;
                self.drawables.extend(axes(display, &fixed_from_link, length_m, diameter_m, &self.axes_materials));
            }
            self.drawables.extend(link.trail.as_ref().and_then(|trail| trail.drawable(display, TRAIL_COLOR)));
        }
    }
}

/// Start of a link's ribbon: when rviz reads its config it has no frames yet.
fn trail_from_origin() -> Trail {
    let mut trail = Trail::default();
    trail.follow(Vector3::zeros());
    trail
}

fn placed(display: DisplayId, fixed_from_link: &Matrix4<f64>, part: &LinkPart, material: &Arc<Material>) -> Drawable {
    let geometry = Geometry::Mesh { mesh: part.mesh.clone(), material: material.clone() };
    drawable(display, fixed_from_link * part.link_from_object, geometry)
}

impl Display for RobotModelDisplay {
    fn parameters(&self) -> Vec<String> {
        self.description.parameters()
    }

    fn take_parameter(&mut self, _name: &str, text: Option<&Arc<str>>, world: &World<'_>) {
        if let Some(robot) = self.description.take(text, &STATUS_TEXTS, &mut self.statuses) {
            self.load(robot, world);
        }
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        if self.links.is_empty() {
            return false;
        }
        let mut changed = self.build_loaded(world);
        // Links that are drawn from now on need a place from now on.
        if changed || self.is_due(world.now) {
            self.updated = Some(world.now);
            for link in &mut self.links {
                changed |= link.follow(&self.settings, world, &mut self.statuses);
            }
        }
        if changed {
            self.draw();
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn next_change(&self) -> Option<Time> {
        let interval = self.interval().filter(|_| !self.links.is_empty())?;
        Some(self.updated?.saturating_add(interval))
    }

    fn reset(&mut self) {
        // The robot stays, as in rviz, and its links are looked up again.
        self.updated = None;
        for link in &mut self.links {
            link.is_placed = None;
            if let Some(trail) = &mut link.trail {
                *trail = trail_from_origin();
            }
        }
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}

#[cfg(test)]
mod tests;
