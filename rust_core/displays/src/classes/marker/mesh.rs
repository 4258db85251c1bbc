//! MESH_RESOURCE: a mesh from a file, in the marker's colour or in its own.
//!
//! With `mesh_use_embedded_materials` each part keeps the material of the file, takes the marker's alpha, and is drawn
//! once more in the marker's colour with at most half opacity: a tint. A colour of all zeros stands for no tint and the
//! file's own opacity, but only where the mesh is new: rviz does not check again when a later message changes the
//! colour, and then shows a mesh of alpha zero.

use std::sync::Arc;

use nalgebra::Matrix4;
use rcs_messages::visualization_msgs::Marker;
use rcs_resources::{LoadedMesh, MeshMaterial, MeshStore};
use rcs_scene::{Blending, Lighting, Material, Rgba};

use super::message_fields::{rgba, scale};
use super::primitive::Primitive;

/// The most opaque that a tint can be.
const MAX_TINT_ALPHA: f32 = 0.5;

/// A mesh marker from message to message.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshMarker {
    shown: Option<Shown>,
}

#[derive(Clone, Debug)]
struct Shown {
    url: String,
    embedded: bool,
    mesh: Arc<LoadedMesh>,
    color: Rgba,
    /// The colour that was last set on the materials; `None` while they are as the file has them.
    paint: Option<Rgba>,
}

impl MeshMarker {
    /// The parts of the mesh.
    ///
    /// # Errors
    /// Why the mesh cannot be shown, with its address.
    pub(super) fn primitives(&mut self, marker: &Marker, meshes: &MeshStore) -> Result<Vec<Primitive>, String> {
        let (url, embedded, color) = (&marker.mesh_resource, marker.mesh_use_embedded_materials, rgba(&marker.color));
        let shown = match self.shown.take().filter(|shown| shown.url == *url && shown.embedded == embedded) {
            Some(shown) => {
                Shown { paint: if color == shown.color { shown.paint } else { Some(color) }, color, ..shown }
            }
            None => {
                let mesh = meshes.get(url).map_err(|error| format!("could not load [{url}]: {error}"))?;
                let own_colors = embedded && color == Rgba::TRANSPARENT;
                Shown { url: url.clone(), embedded, mesh, color, paint: (!own_colors).then_some(color) }
            }
        };
        let marker_from_mesh = Matrix4::new_nonuniform_scaling(&scale(marker).into());
        let mut parts = Vec::new();
        for part in &shown.mesh.parts {
            for material in materials(&part.material, embedded, shown.paint) {
                parts.push(Primitive::mesh(marker_from_mesh, part.mesh.clone(), material));
            }
        }
        self.shown = Some(shown);
        Ok(parts)
    }
}

/// How a part is drawn, once for each material.
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
    // On an opaque part the tint belongs to the opaque things, at the very depth of the part.
    let tint = Material { blending: Blending::Alpha, depth_write: !is_translucent, ..Material::lit(tint) };
    vec![plain, tint]
}
