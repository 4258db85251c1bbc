//! The visual scene: instances of geometries with their materials.

use std::collections::{BTreeMap, HashMap};

use nalgebra::{Matrix4, Vector3};

use super::{
    dom::{attribute, fault, floats, reference, Node},
    effect::Materials,
    geometry::Geometries,
};
use crate::{
    import::{
        imported::{check_count, Imported, MaterialSpec, PlacedMesh, MAX_MESHES},
        lenient_float::leading_f32,
    },
    MeshFault,
};

/// Nodes nest no deeper than this, instances included, or they contain themselves.
const MAX_DEPTH: usize = 200;
/// Most nodes after instancing.
const MAX_NODES: usize = 200_000;

/// A node with its meshes.
struct SceneNode {
    parent_from_node: Matrix4<f32>,
    meshes: Vec<usize>,
    children: Vec<SceneNode>,
}

struct SceneBuilder<'a> {
    geometries: &'a Geometries,
    /// Geometry ids by the id of the controller that skins them.
    skinned: HashMap<&'a str, &'a str>,
    materials: &'a Materials,
    /// `library_nodes` and visual scenes by id.
    library: HashMap<&'a str, Node<'a>>,
    root: Node<'a>,
    /// Indices of meshes by geometry, group and material id; each is made once.
    made: HashMap<(&'a str, usize, &'a str), usize>,
    imported: Imported,
    corners: usize,
    max_corners: usize,
    nodes: usize,
    /// Number of instances.
    placings: usize,
}

/// Builds the meshes and instances of the scene that the file instances.
pub(super) fn build(
    root: Node<'_>,
    geometries: &Geometries,
    materials: Materials,
    max_corners: usize,
) -> Result<Imported, MeshFault> {
    let mut library = HashMap::new();
    for group in root.elements.iter() {
        let name = match group.name {
            "library_nodes" => "node",
            "library_visual_scenes" => "visual_scene",
            _ => continue,
        };
        library.extend(group.children(name).map(|node| (attribute(node, "id"), node)));
    }
    let instance = root
        .child("scene")
        .and_then(|scene| scene.child("instance_visual_scene"))
        .ok_or_else(|| fault(root, "it has no <scene> with an <instance_visual_scene>"))?;
    let url = reference(instance, "url")?;
    let scene = *library.get(url).ok_or_else(|| fault(instance, format!("there is no visual scene {url:?}")))?;

    let mut builder = SceneBuilder {
        geometries,
        skinned: skinned(root),
        materials: &materials,
        library,
        root: scene,
        made: HashMap::new(),
        imported: Imported::default(),
        corners: 0,
        max_corners,
        nodes: 0,
        placings: 0,
    };
    let mut placing = builder.node(scene, 0)?;
    // Assimp turns the root by the up axis too, but rviz takes only its scale and place.
    placing.parent_from_node = Matrix4::new_scaling(unit_metres(root));
    let mut imported = builder.imported;
    flatten(&placing, &Matrix4::identity(), &mut imported.placed);
    imported.materials = materials.specs;
    if imported.materials.is_empty() {
        imported.materials.push(MaterialSpec::DEFAULT);
    }
    Ok(imported)
}

/// Metres in a unit of the file.
fn unit_metres(root: Node<'_>) -> f32 {
    let unit = root.children("asset").flat_map(|asset| asset.children("unit")).last();
    let metres = unit.and_then(|unit| unit.attribute("meter")).and_then(leading_f32);
    metres.filter(|metres| metres.is_finite()).unwrap_or(1.0)
}

/// Geometry ids by the ids of controllers' skins; rviz draws the geometry undeformed.
fn skinned<'a>(root: Node<'a>) -> HashMap<&'a str, &'a str> {
    let controllers = root
        .children("library_controllers")
        .flat_map(|library| library.elements.iter().filter(|controller| controller.name == "controller"));
    let skin = |controller: Node<'a>| {
        let skin = controller.elements.iter().find(|node| node.name == "skin")?;
        let source = skin.attribute("source")?.trim_start_matches('#');
        Some((controller.attribute("id")?, source))
    };
    controllers.filter_map(skin).collect()
}

/// Lists a node's meshes, then its children's.
fn flatten(placing: &SceneNode, root_from_parent: &Matrix4<f32>, placed: &mut Vec<PlacedMesh>) {
    let object_from_mesh = root_from_parent * placing.parent_from_node;
    placed.extend(placing.meshes.iter().map(|&mesh| PlacedMesh { mesh, object_from_mesh, is_turned: false }));
    for child in &placing.children {
        flatten(child, &object_from_mesh, placed);
    }
}

impl<'a> SceneBuilder<'a> {
    fn node(&mut self, node: Node<'a>, depth: usize) -> Result<SceneNode, MeshFault> {
        self.nodes += 1;
        check_count(self.nodes, MAX_NODES, "nodes")?;
        if depth > MAX_DEPTH {
            return Err(fault(node, "nodes nest too deeply, or contain themselves"));
        }
        let mut placing = SceneNode { parent_from_node: Matrix4::identity(), meshes: Vec::new(), children: Vec::new() };
        for element in node.elements.iter() {
            if let Some(step) = transform_step(element) {
                placing.parent_from_node *= step;
            }
        }
        // Children before instanced nodes before own meshes: the order in which Assimp makes meshes.
        for element in node.children("node") {
            placing.children.push(self.node(element, depth + 1)?);
        }
        for element in node.children("instance_node") {
            let url = reference(element, "url")?;
            match self.library.get(url).copied().or_else(|| find_node(self.root, url)) {
                Some(target) => placing.children.push(self.node(target, depth + 1)?),
                None => log::debug!("COLLADA node {url:?} does not exist, its instance is skipped"),
            }
        }
        for element in node.elements.iter() {
            if matches!(element.name, "instance_geometry" | "instance_controller") {
                self.instance(element, &mut placing.meshes)?;
            }
        }
        Ok(placing)
    }

    /// Makes the meshes of a geometry's instance, one for each group.
    fn instance(&mut self, element: Node<'a>, meshes: &mut Vec<usize>) -> Result<(), MeshFault> {
        let url = reference(element, "url")?;
        let mut id = url;
        let mut hops = 0;
        while !self.geometries.contains_key(id) && hops <= self.skinned.len() {
            match self.skinned.get(id) {
                Some(source) => id = source,
                None => break,
            }
            hops += 1;
        }
        let Some(geometry) = self.geometries.get(id) else {
            log::debug!("COLLADA geometry {url:?} does not exist, its instance is skipped");
            return Ok(());
        };
        let bound = bound_materials(element);
        let (mut first_face, mut first_corner) = (0, 0);
        for (number, group) in geometry.groups.iter().enumerate().filter(|(_, group)| group.faces > 0) {
            self.placings += 1;
            check_count(self.placings, MAX_MESHES, "meshes")?;
            // An unbound symbol takes the first bound material.
            let material_id =
                bound.get(group.symbol.as_str()).or_else(|| bound.values().next()).copied().unwrap_or_default();
            let key = (url, number, material_id);
            if let Some(&made) = self.made.get(&key) {
                // Assimp advances only past groups that it makes, so the next new group of this instance is cut from
                // the wrong place, in rviz too.
                meshes.push(made);
                continue;
            }
            let by_id = |id: &str| self.materials.by_id.get(id).copied();
            let Some(mut polygons) = geometry.slice(first_face, first_corner, group.faces) else { continue };
            // A symbol that is itself a material's id means that material.
            polygons.material = by_id(&group.symbol).or_else(|| by_id(material_id)).unwrap_or(0);
            first_face += group.faces;
            first_corner += polygons.positions.len();
            self.corners += polygons.positions.len();
            check_count(self.corners, self.max_corners, "corners")?;
            self.made.insert(key, self.imported.meshes.len());
            meshes.push(self.imported.meshes.len());
            self.imported.meshes.push(polygons);
        }
        Ok(())
    }
}

/// Material ids by symbol, in the order of the symbols.
fn bound_materials<'a>(instance: Node<'a>) -> BTreeMap<&'a str, &'a str> {
    instance
        .children("bind_material")
        .filter_map(|bind| bind.elements.iter().find(|node| node.name == "technique_common"))
        .flat_map(|technique| technique.elements.iter().filter(|node| node.name == "instance_material"))
        .map(|material| (attribute(material, "symbol"), attribute(material, "target").trim_start_matches('#')))
        .collect()
}

/// Finds a node of the scene by id or name.
fn find_node<'a>(scene: Node<'a>, name: &str) -> Option<Node<'a>> {
    scene.descendants().find(|node| {
        matches!(node.name, "node" | "visual_scene")
            && (attribute(node, "id") == name || attribute(node, "name") == name)
    })
}

/// A transform element's matrix; `None` for other elements, and for `skew`, which Assimp ignores.
fn transform_step(element: Node<'_>) -> Option<Matrix4<f32>> {
    let mut numbers = floats(element);
    let mut vector = || Some(Vector3::new(numbers.next()?, numbers.next()?, numbers.next()?));
    match element.name {
        "translate" => Some(Matrix4::new_translation(&vector()?)),
        "scale" => Some(Matrix4::new_nonuniform_scaling(&vector()?)),
        "rotate" => {
            let axis = vector()?;
            Some(rotation(axis, numbers.next()?.to_radians()))
        }
        "matrix" => {
            let values: Vec<f32> = numbers.take(16).collect();
            (values.len() == 16).then(|| Matrix4::from_row_slice(&values))
        }
        "lookat" => {
            let (eye, target, up) = (vector()?, vector()?, vector()?);
            let unit = |v: Vector3<f32>| v.try_normalize(0.0).unwrap_or(v);
            let (up, forward) = (unit(up), unit(target - eye));
            let right = unit(forward.cross(&up));
            Some(Matrix4::from_columns(&[right.push(0.0), up.push(0.0), (-forward).push(0.0), eye.push(1.0)]))
        }
        _ => None,
    }
}

/// Rodrigues' formula. The axis is not normalized, so one of another length scales too, as in Assimp.
fn rotation(axis: Vector3<f32>, angle: f32) -> Matrix4<f32> {
    let (sin, cos) = angle.sin_cos();
    let cross = axis.cross_matrix();
    let outer = axis * axis.transpose();
    (nalgebra::Matrix3::identity() * cos + cross * sin + outer * (1.0 - cos)).to_homogeneous()
}
