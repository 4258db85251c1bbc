//! A robot's links as pieces to draw: shapes, meshes and their materials.
//!
//! Which material a piece gets is rviz's rule. A mesh keeps the materials of its file, each with the link's opacity on
//! top of its own; everything else has the last material that the link's visuals named before, in the order of the file
//! and with the collision shapes at the end. Before any was named that is plain red.
//!
//! While meshes and textures are loading the pieces that need them are left out; the robot is then built again.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;
use std::task::Poll;

use nalgebra::{Isometry3, Matrix4};
use rcs_resources::{warning_texture, LoadedMesh, MeshStore, Retry};
use rcs_scene::{Lighting, Material, Mesh, Rgba, Texture};

use crate::Shape;
use rcs_robot::{Link, Robot, UrdfMaterial, UrdfShape};

/// Something with one material.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub(super) link_from_object: Matrix4<f64>,
    pub(super) mesh: Arc<Mesh>,
    pub(super) material: Arc<Material>,
}

/// What a link is drawn with.
#[derive(Clone, Debug, Default)]
pub(super) struct LinkPieces {
    pub(super) visuals: Vec<Piece>,
    pub(super) collisions: Vec<Piece>,
    /// What cannot be shown.
    pub(super) faults: Vec<String>,
}

/// How a surface looks before opacities.
#[derive(Clone, Debug)]
struct Look {
    color: Rgba,
    texture: Option<Arc<Texture>>,
    /// The texture is not there yet.
    is_loading: bool,
}

/// Why a shape has no pieces.
enum Missing {
    /// A file of it is being loaded.
    Loading,
    /// What is wrong.
    Failed(String),
}

/// rviz's material for links without one.
const UNNAMED: Rgba = Rgba::new(1.0, 0.0, 0.0, 1.0);

/// Turns a solid's y axis, along which rviz's cylinder stands, to z. In whole numbers, so that edges stay straight.
#[rustfmt::skip]
const UPRIGHT: Matrix4<f64> = Matrix4::new(
    1.0, 0.0, 0.0, 0.0,
    0.0, 0.0, -1.0, 0.0,
    0.0, 1.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 1.0,
);

/// Makes the links of a robot, each with `alpha` for its opacity.
pub(super) struct Builder<'a> {
    meshes: &'a MeshStore,
    retry: Retry,
    textures: HashMap<String, Poll<Arc<Texture>>>,
    /// The addresses of textures whose failure was logged.
    logged: &'a mut BTreeSet<String>,
    /// The addresses of files that are being loaded.
    loading: BTreeSet<String>,
}

impl<'a> Builder<'a> {
    /// Has all meshes of a robot loaded at once.
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
        // What they are asked for from now on is known, or being loaded.
        Self { meshes, retry, textures: HashMap::new(), logged, loading: BTreeSet::new() }
    }

    /// How many files are being loaded that links need.
    pub(super) fn loading(&self) -> usize {
        self.loading.len()
    }

    /// The pieces of a link; `alpha` is the display's and the link's opacity together.
    pub(super) fn link(&mut self, link: &Link, alpha: f32) -> LinkPieces {
        let mut pieces = LinkPieces::default();
        let mut look = None;
        for visual in &link.visuals {
            let material = visual.material.as_deref();
            let made = self.pieces(&visual.shape, &visual.link_from_shape, material, link, &mut look, alpha);
            add(made, &mut pieces.visuals, &mut pieces.faults);
        }
        for collision in &link.collisions {
            let made = self.pieces(&collision.shape, &collision.link_from_shape, None, link, &mut look, alpha);
            add(made, &mut pieces.collisions, &mut pieces.faults);
        }
        pieces
    }

    /// The pieces of a shape. `look` is the link's latest.
    fn pieces(
        &mut self,
        shape: &UrdfShape,
        link_from_shape: &Isometry3<f64>,
        material: Option<&UrdfMaterial>,
        link: &Link,
        look: &mut Option<Look>,
        alpha: f32,
    ) -> Result<Vec<Piece>, Missing> {
        let (mesh, shape_from_object) = match shape {
            UrdfShape::Mesh { url, .. } if url.is_empty() => return Ok(Vec::new()),
            UrdfShape::Mesh { url, scale } => match self.meshes.mesh(url, Retry::No) {
                Poll::Ready(Ok(mesh)) => (Some(mesh), scaling(*scale)),
                Poll::Ready(Err(error)) => {
                    return Err(Missing::Failed(format!("Could not load mesh resource '{url}': {error}")));
                }
                Poll::Pending => {
                    self.loading.insert(url.clone());
                    return Err(Missing::Loading);
                }
            },
            UrdfShape::Sphere { radius_m } => (None, scaling([radius_m * 2.0; 3])),
            UrdfShape::Box { size_m } => (None, scaling(*size_m)),
            UrdfShape::Cylinder { radius_m, length_m } => {
                (None, UPRIGHT * scaling([radius_m * 2.0, *length_m, radius_m * 2.0]))
            }
        };
        if look.is_none() || material.is_some() {
            let first = link.visuals.first().filter(|_| link.has_first_visual);
            let material = material.or_else(|| first?.material.as_deref());
            *look = Some(self.look(material));
        }
        let look = look.as_ref();
        if look.is_some_and(|look| look.is_loading) {
            return Err(Missing::Loading);
        }
        let plain = || look.map_or_else(|| Material::lit(UNNAMED), Look::material);
        let link_from_object = link_from_shape.to_homogeneous() * shape_from_object;
        let piece = |mesh: Arc<Mesh>, material: Material| Piece {
            link_from_object,
            mesh,
            material: Arc::new(faded(material, alpha)),
        };
        Ok(match mesh {
            Some(mesh) => mesh_parts(&mesh, &plain).map(|(mesh, material)| piece(mesh, material)).collect(),
            None => vec![piece(solid(shape).mesh(), plain())],
        })
    }

    fn look(&mut self, material: Option<&UrdfMaterial>) -> Look {
        match material {
            None => Look { color: UNNAMED, texture: None, is_loading: false },
            Some(material) if material.texture.is_empty() => {
                Look { color: material.rgba.into(), texture: None, is_loading: false }
            }
            Some(material) => match self.texture(&material.texture) {
                Poll::Ready(texture) => Look { color: Rgba::WHITE, texture: Some(texture), is_loading: false },
                Poll::Pending => Look { color: Rgba::WHITE, texture: None, is_loading: true },
            },
        }
    }

    /// The image at an address; where it cannot be read, the one that Ogre shows then.
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

impl Look {
    fn material(&self) -> Material {
        Material { texture: self.texture.clone(), ..Material::lit(self.color) }
    }
}

fn add(made: Result<Vec<Piece>, Missing>, pieces: &mut Vec<Piece>, faults: &mut Vec<String>) {
    match made {
        Ok(made) => pieces.extend(made),
        Err(Missing::Loading) => {}
        Err(Missing::Failed(fault)) => faults.push(fault),
    }
}

fn scaling(scale: [f64; 3]) -> Matrix4<f64> {
    Matrix4::new_nonuniform_scaling(&scale.into())
}

fn solid(shape: &UrdfShape) -> Shape {
    match shape {
        UrdfShape::Sphere { .. } => Shape::Sphere,
        UrdfShape::Cylinder { .. } => Shape::Cylinder,
        UrdfShape::Box { .. } | UrdfShape::Mesh { .. } => Shape::Cube,
    }
}

/// The parts of a mesh, those without a material of their own with the link's. The last comes first, which shows where
/// they are translucent: Ogre sorts them by distance, which is the same for all, and then by where in memory their
/// materials are.
fn mesh_parts<'a>(
    mesh: &'a LoadedMesh,
    plain: &'a impl Fn() -> Material,
) -> impl Iterator<Item = (Arc<Mesh>, Material)> + 'a {
    mesh.parts.iter().rev().map(|part| {
        let material = if part.material.embedded { part.material.to_scene() } else { plain() };
        (part.mesh.clone(), material)
    })
}

/// A material with an opacity on top of its own.
fn faded(mut material: Material, alpha: f32) -> Material {
    let mut opacity = alpha;
    if let Lighting::Lit { diffuse, .. } = &mut material.lighting {
        diffuse.a *= alpha;
        opacity = diffuse.a;
    }
    material.translucent(opacity < Material::OPAQUE_FROM_ALPHA)
}
