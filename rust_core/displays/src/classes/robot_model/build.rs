//! Drawable parts of a robot's links: shapes, meshes and their materials.
//!
//! Materials follow rviz's rule. A mesh keeps the materials of its file, each multiplied with the link's opacity; every
//! other part has the last material that the link's visuals named before, in the order of the file and with the
//! collision shapes at the end. Before any was named that is plain red.
//!
//! While meshes and textures are loading their parts are left out; the robot is then built again.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;
use std::task::Poll;

use nalgebra::{Isometry3, Matrix4};
use rcs_resources::{warning_texture, LoadedMesh, MeshStore, Retry};
use rcs_scene::{Lighting, Material, Mesh, Rgba, Texture};

use crate::SolidShape;
use rcs_robot::{Link, Robot, UrdfMaterial, UrdfShape};

#[derive(Clone, Debug)]
pub(super) struct LinkPart {
    pub(super) link_from_object: Matrix4<f64>,
    pub(super) mesh: Arc<Mesh>,
    pub(super) material: Arc<Material>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct LinkParts {
    pub(super) visuals: Vec<LinkPart>,
    pub(super) collisions: Vec<LinkPart>,
    /// Messages about parts that cannot be shown.
    pub(super) faults: Vec<String>,
}

#[derive(Clone, Copy)]
struct LinkShape<'a> {
    shape: &'a UrdfShape,
    link_from_shape: &'a Isometry3<f64>,
    material: Option<&'a UrdfMaterial>,
}

/// Material of a link before opacities.
#[derive(Clone, Debug)]
struct LinkMaterial {
    color: Rgba,
    texture: Option<Arc<Texture>>,
    is_loading: bool,
}

enum MissingShape {
    Loading,
    Failed(String),
}

/// rviz's material for links without one.
const UNNAMED: Rgba = Rgba::new(1.0, 0.0, 0.0, 1.0);

/// Rotation of a solid's y axis, the axis of rviz's cylinder, to z. In whole numbers, so that edges stay straight.
#[rustfmt::skip]
const UPRIGHT: Matrix4<f64> = Matrix4::new(
    1.0, 0.0, 0.0, 0.0,
    0.0, 0.0, -1.0, 0.0,
    0.0, 1.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 1.0,
);

pub(super) struct Builder<'a> {
    meshes: &'a MeshStore,
    retry: Retry,
    textures: HashMap<String, Poll<Arc<Texture>>>,
    /// URLs of textures whose failure was logged.
    logged: &'a mut BTreeSet<String>,
    loading: BTreeSet<String>,
}

impl<'a> Builder<'a> {
    /// Starts to load all meshes of a robot.
    pub(super) fn new(robot: &Robot, meshes: &'a MeshStore, retry: Retry, logged: &'a mut BTreeSet<String>) -> Self {
        let shapes = robot.links.values().flat_map(|link| {
            let visuals = link.visuals.iter().map(|visual| &visual.shape);
            visuals.chain(link.collisions.iter().map(|collision| &collision.shape))
        });
        let urls = shapes.filter_map(|shape| match shape {
            UrdfShape::Mesh { url, .. } if !url.is_empty() => Some(url.as_str()),
            _ => None,
        });
        meshes.load_all(urls, retry);
        // From now on all of them are known or being loaded.
        Self { meshes, retry, textures: HashMap::new(), logged, loading: BTreeSet::new() }
    }

    pub(super) fn loading(&self) -> usize {
        self.loading.len()
    }

    /// Parts of a link; `alpha` is the product of the display's and the link's opacity.
    pub(super) fn link(&mut self, link: &Link, alpha: f32) -> LinkParts {
        let mut parts = LinkParts::default();
        let mut current = None;
        for visual in &link.visuals {
            let (shape, link_from_shape) = (&visual.shape, &visual.link_from_shape);
            let source = LinkShape { shape, link_from_shape, material: visual.material.as_deref() };
            add(self.shape_parts(&source, link, &mut current, alpha), &mut parts.visuals, &mut parts.faults);
        }
        for collision in &link.collisions {
            let (shape, link_from_shape) = (&collision.shape, &collision.link_from_shape);
            let source = LinkShape { shape, link_from_shape, material: None };
            add(self.shape_parts(&source, link, &mut current, alpha), &mut parts.collisions, &mut parts.faults);
        }
        parts
    }

    /// Parts of a shape. `current` is the link's last material.
    fn shape_parts(
        &mut self,
        source: &LinkShape<'_>,
        link: &Link,
        current: &mut Option<LinkMaterial>,
        alpha: f32,
    ) -> Result<Vec<LinkPart>, MissingShape> {
        let LinkShape { shape, link_from_shape, material } = *source;
        let (mesh, shape_from_object) = match shape {
            UrdfShape::Mesh { url, .. } if url.is_empty() => return Ok(Vec::new()),
            UrdfShape::Mesh { url, scale } => match self.meshes.mesh(url, Retry::No) {
                Poll::Ready(Ok(mesh)) => (Some(mesh), scaling(*scale)),
                Poll::Ready(Err(error)) => {
                    return Err(MissingShape::Failed(format!("Could not load mesh resource '{url}': {error}")));
                }
                Poll::Pending => {
                    self.loading.insert(url.clone());
                    return Err(MissingShape::Loading);
                }
            },
            UrdfShape::Sphere { radius_m } => (None, scaling([radius_m * 2.0; 3])),
            UrdfShape::Box { size_m } => (None, scaling(*size_m)),
            UrdfShape::Cylinder { radius_m, length_m } => {
                (None, UPRIGHT * scaling([radius_m * 2.0, *length_m, radius_m * 2.0]))
            }
        };
        if current.is_none() || material.is_some() {
            let first = link.visuals.first().filter(|_| link.has_first_visual);
            let material = material.or_else(|| first?.material.as_deref());
            *current = Some(self.link_material(material));
        }
        let current = current.as_ref();
        if current.is_some_and(|material| material.is_loading) {
            return Err(MissingShape::Loading);
        }
        let plain = || current.map_or_else(|| Material::lit(UNNAMED), LinkMaterial::material);
        let link_from_object = link_from_shape.to_homogeneous() * shape_from_object;
        let part = |mesh: Arc<Mesh>, material: Material| LinkPart {
            link_from_object,
            mesh,
            material: Arc::new(faded(material, alpha)),
        };
        Ok(match mesh {
            Some(mesh) => mesh_parts(&mesh, &plain).map(|(mesh, material)| part(mesh, material)).collect(),
            None => vec![part(solid(shape).mesh(), plain())],
        })
    }

    fn link_material(&mut self, material: Option<&UrdfMaterial>) -> LinkMaterial {
        match material {
            None => LinkMaterial { color: UNNAMED, texture: None, is_loading: false },
            Some(material) if material.texture.is_empty() => {
                LinkMaterial { color: material.rgba.into(), texture: None, is_loading: false }
            }
            Some(material) => match self.texture(&material.texture) {
                Poll::Ready(texture) => LinkMaterial { color: Rgba::WHITE, texture: Some(texture), is_loading: false },
                Poll::Pending => LinkMaterial { color: Rgba::WHITE, texture: None, is_loading: true },
            },
        }
    }

    /// Texture at a URL; where it cannot be read, Ogre's warning texture.
    fn texture(&mut self, url: &str) -> Poll<Arc<Texture>> {
        if let Some(known) = self.textures.get(url) {
            return known.clone();
        }
        let texture = match self.meshes.texture(url, self.retry) {
            Poll::Ready(Ok(texture)) => Poll::Ready(texture),
            Poll::Ready(Err(error)) => {
                if self.logged.insert(url.to_owned()) {
                    log::warn!("texture {url} of a robot's link: {error}");
                }
                Poll::Ready(warning_texture())
            }
            Poll::Pending => {
                self.loading.insert(url.to_owned());
                Poll::Pending
            }
        };
        self.textures.insert(url.to_owned(), texture.clone());
        texture
    }
}

impl LinkMaterial {
    fn material(&self) -> Material {
        Material { texture: self.texture.clone(), ..Material::lit(self.color) }
    }
}

fn add(made: Result<Vec<LinkPart>, MissingShape>, parts: &mut Vec<LinkPart>, faults: &mut Vec<String>) {
    match made {
        Ok(made) => parts.extend(made),
        Err(MissingShape::Loading) => {}
        Err(MissingShape::Failed(fault)) => faults.push(fault),
    }
}

fn scaling(scale: [f64; 3]) -> Matrix4<f64> {
    Matrix4::new_nonuniform_scaling(&scale.into())
}

fn solid(shape: &UrdfShape) -> SolidShape {
    match shape {
        UrdfShape::Sphere { .. } => SolidShape::Sphere,
        UrdfShape::Cylinder { .. } => SolidShape::Cylinder,
        UrdfShape::Box { .. } | UrdfShape::Mesh { .. } => SolidShape::Cube,
    }
}

/// Parts of a mesh, those without a material of their own with the link's. The last comes first, which is visible in
/// translucent ones: Ogre sorts them by distance, which is the same for all, and then by the address of their material.
fn mesh_parts<'a>(
    mesh: &'a LoadedMesh,
    plain: &'a impl Fn() -> Material,
) -> impl Iterator<Item = (Arc<Mesh>, Material)> + 'a {
    mesh.parts.iter().rev().map(|part| {
        let material = if part.material.embedded { part.material.to_scene() } else { plain() };
        (part.mesh.clone(), material)
    })
}

fn faded(mut material: Material, alpha: f32) -> Material {
    let mut opacity = alpha;
    if let Lighting::Lit { diffuse, .. } = &mut material.lighting {
        diffuse.a *= alpha;
        opacity = diffuse.a;
    }
    material.translucent(opacity < Material::OPAQUE_FROM_ALPHA)
}
