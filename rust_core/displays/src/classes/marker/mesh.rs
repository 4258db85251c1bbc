//! MESH_RESOURCE: a mesh from a file, in the marker's colour or in its own.
//!
//! With `mesh_use_embedded_materials` each part keeps the material of the file, takes the marker's alpha, and is drawn
//! once more in the marker's colour with at most half opacity: a tint. A colour of all zeros stands for no tint and the
//! file's own opacity, but only where the mesh is new: rviz does not check again when a later message changes the
//! colour, and then shows a mesh of alpha zero.
//!
//! A mesh may still be loading when its message comes, or its file may be broken and repaired later. The message's
//! content is kept, so that the marker can be built later.

use std::sync::Arc;
use std::task::Poll;

use nalgebra::Matrix4;
use rcs_messages::visualization_msgs::Marker;
use rcs_resources::{LoadedMesh, MeshMaterial, MeshStore, Retry};
use rcs_scene::{Blending, Lighting, Material, Rgba};

use super::message_fields::{rgba, scale};
use super::primitive::Primitive;
use crate::Level;

/// Largest opacity of a tint.
const MAX_TINT_ALPHA: f32 = 0.5;

/// State of a mesh marker between messages.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshMarker {
    shown: Option<MeshContent>,
}

#[derive(Clone, Debug)]
struct MeshContent {
    url: String,
    embedded: bool,
    mesh: MeshState,
    scale: [f64; 3],
    color: Rgba,
    /// Colour last set on the materials; `None` while they are as in the file.
    paint: Option<Rgba>,
}

#[derive(Clone, Debug)]
enum MeshState {
    Loading,
    Failed,
    Loaded(Arc<LoadedMesh>),
}

/// Reason why a valid marker shows nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum NotShown {
    Loading(String),
    /// The mesh cannot be shown; the text names its URL.
    Failed(String),
}

impl NotShown {
    pub(crate) fn status(self) -> (Level, String) {
        match self {
            Self::Loading(url) => (Level::Ok, format!("loading [{url}]")),
            Self::Failed(text) => (Level::Error, text),
        }
    }
}

impl MeshMarker {
    /// Primitives of a message.
    pub(super) fn primitives(&mut self, marker: &Marker, meshes: &MeshStore) -> Result<Vec<Primitive>, NotShown> {
        let (url, embedded, color) = (&marker.mesh_resource, marker.mesh_use_embedded_materials, rgba(&marker.color));
        let is_kept = |shown: &MeshContent| {
            shown.url == *url && shown.embedded == embedded && !matches!(shown.mesh, MeshState::Failed)
        };
        let mut shown = match self.shown.take().filter(is_kept) {
            Some(shown) => {
                MeshContent { paint: if color == shown.color { shown.paint } else { Some(color) }, color, ..shown }
            }
            None => {
                let own_colors = embedded && color == Rgba::TRANSPARENT;
                let paint = (!own_colors).then_some(color);
                MeshContent { url: url.clone(), embedded, mesh: MeshState::Loading, scale: [0.0; 3], color, paint }
            }
        };
        shown.scale = scale(marker);
        let parts = shown.primitives(meshes, Retry::Yes);
        self.shown = Some(shown);
        parts
    }

    /// `true` if the mesh of the last message is loading or cannot be shown.
    pub(super) fn is_missing(&self) -> bool {
        self.shown.as_ref().is_some_and(|shown| !matches!(shown.mesh, MeshState::Loaded(_)))
    }

    /// Primitives of the last message, whose mesh may be loaded now.
    pub(super) fn rebuild(&mut self, meshes: &MeshStore) -> Result<Vec<Primitive>, NotShown> {
        self.shown.as_mut().map_or_else(|| Ok(Vec::new()), |shown| shown.primitives(meshes, Retry::No))
    }
}

impl MeshContent {
    fn primitives(&mut self, meshes: &MeshStore, retry: Retry) -> Result<Vec<Primitive>, NotShown> {
        let mesh = match &self.mesh {
            MeshState::Loaded(mesh) => mesh.clone(),
            MeshState::Loading | MeshState::Failed => match meshes.mesh(&self.url, retry) {
                Poll::Ready(Ok(mesh)) => mesh,
                Poll::Ready(Err(error)) => {
                    self.mesh = MeshState::Failed;
                    return Err(NotShown::Failed(format!("could not load [{}]: {error}", self.url)));
                }
                Poll::Pending => return Err(NotShown::Loading(self.url.clone())),
            },
        };
        let marker_from_mesh = Matrix4::new_nonuniform_scaling(&self.scale.into());
        let mut parts = Vec::new();
        for part in &mesh.parts {
            for material in materials(&part.material, self.embedded, self.paint) {
                parts.push(Primitive::mesh(marker_from_mesh, part.mesh.clone(), material));
            }
        }
        self.mesh = MeshState::Loaded(mesh);
        Ok(parts)
    }
}

/// Materials of a part, which is drawn once for each.
fn materials(own: &MeshMaterial, embedded: bool, paint: Option<Rgba>) -> Vec<Material> {
    let has_own = embedded && own.embedded;
    let plain = if has_own { own.to_scene() } else { Material::lit(Rgba::WHITE) };
    let Some(paint) = paint else { return vec![plain] };
    let is_translucent = paint.a < Material::OPAQUE_FROM_ALPHA;
    let tint = paint.with_alpha(paint.a.min(MAX_TINT_ALPHA));
    if !has_own {
        // Where there is a tint and nothing to tint, the marker's colour is drawn with the tint's alpha.
        let color = if embedded { tint } else { paint };
        return vec![Material::lit(color).translucent(is_translucent)];
    }
    let mut plain = plain.translucent(is_translucent);
    if let Lighting::Lit { diffuse, .. } = &mut plain.lighting {
        diffuse.a = paint.a;
    }
    // On an opaque part the tint is drawn with the opaque drawables, at the depth of the part.
    let tint = Material { blending: Blending::Alpha, depth_write: !is_translucent, ..Material::lit(tint) };
    vec![plain, tint]
}
