//! MoveIt's collision objects, by which a planning scene learns of things that an arm is to keep clear of.
//!
//! They are types of our own, so that nothing of MoveIt need be installed. The message has changed: since moveit_msgs
//! 0.11 (Noetic) an object has a pose that its shapes are relative to, and subframes; [`MelodicCollisionObject`] is the
//! one before. A subscriber of one does not take the other.

use crate::fields::{fields_in_order, with_parts};
use crate::geometry_msgs::{Point, Pose};
use crate::std_msgs::Header;
use rosrust::Message;

fields_in_order! {
    /// `object_recognition_msgs/ObjectType`: what an object is, by a database.
    ObjectType {
        /// The object's key.
        key: String,
        /// The database's parameters.
        db: String,
    }
    /// `shape_msgs/SolidPrimitive`: a shape around its own origin.
    SolidPrimitive {
        /// Such as [`SolidPrimitive::CYLINDER`].
        r#type: u8,
        /// Metres; of a cylinder along z its height and its radius.
        dimensions: Vec<f64>,
    }
    /// `shape_msgs/MeshTriangle`
    MeshTriangle {
        /// Three of the mesh's vertices.
        vertex_indices: [u32; 3],
    }
    /// `shape_msgs/Mesh`
    Mesh {
        /// The faces.
        triangles: Vec<MeshTriangle>,
        /// The corners, metres.
        vertices: Vec<Point>,
    }
    /// `shape_msgs/Plane`: ax + by + cz + d = 0.
    Plane {
        /// a, b, c, d.
        coef: [f64; 4],
    }
    /// `moveit_msgs/CollisionObject` of Noetic.
    CollisionObject {
        /// The frame of the poses.
        header: Header,
        /// The object's pose, which the shapes' poses are relative to.
        pose: Pose,
        /// The object's name.
        id: String,
        /// What it is.
        r#type: ObjectType,
        /// Simple shapes.
        primitives: Vec<SolidPrimitive>,
        /// Where they are.
        primitive_poses: Vec<Pose>,
        /// Meshes.
        meshes: Vec<Mesh>,
        /// Where they are.
        mesh_poses: Vec<Pose>,
        /// Planes.
        planes: Vec<Plane>,
        /// Where they are.
        plane_poses: Vec<Pose>,
        /// Names of places on the object.
        subframe_names: Vec<String>,
        /// Where they are.
        subframe_poses: Vec<Pose>,
        /// [`CollisionObject::ADD`] or [`CollisionObject::REMOVE`].
        operation: i8,
    }
    /// `moveit_msgs/CollisionObject` of Melodic and before.
    MelodicCollisionObject {
        /// The frame of the poses.
        header: Header,
        /// The object's name.
        id: String,
        /// What it is.
        r#type: ObjectType,
        /// Simple shapes.
        primitives: Vec<SolidPrimitive>,
        /// Where they are in the header's frame.
        primitive_poses: Vec<Pose>,
        /// Meshes.
        meshes: Vec<Mesh>,
        /// Where they are.
        mesh_poses: Vec<Pose>,
        /// Planes.
        planes: Vec<Plane>,
        /// Where they are.
        plane_poses: Vec<Pose>,
        /// As in [`CollisionObject`].
        operation: i8,
    }
}

impl SolidPrimitive {
    /// A cylinder along z.
    pub const CYLINDER: u8 = 3;
}

impl CollisionObject {
    /// Puts the object into the scene, in the place of one of the same name.
    pub const ADD: i8 = 0;
    /// Takes the object out of the scene.
    pub const REMOVE: i8 = 1;
}

/// The definitions that both are made of, by name.
const PARTS: [(&str, &str); 9] = [
    ("std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id\n"),
    ("geometry_msgs/Pose", "Point position\nQuaternion orientation\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"),
    ("object_recognition_msgs/ObjectType", "string key\nstring db\n"),
    (
        "shape_msgs/SolidPrimitive",
        "uint8 BOX=1\nuint8 SPHERE=2\nuint8 CYLINDER=3\nuint8 CONE=4\nuint8 type\nfloat64[] dimensions\n\
         uint8 BOX_X=0\nuint8 BOX_Y=1\nuint8 BOX_Z=2\nuint8 SPHERE_RADIUS=0\nuint8 CYLINDER_HEIGHT=0\n\
         uint8 CYLINDER_RADIUS=1\nuint8 CONE_HEIGHT=0\nuint8 CONE_RADIUS=1\n",
    ),
    ("shape_msgs/Mesh", "MeshTriangle[] triangles\ngeometry_msgs/Point[] vertices\n"),
    ("shape_msgs/MeshTriangle", "uint32[3] vertex_indices\n"),
    ("shape_msgs/Plane", "float64[4] coef\n"),
];

const SHAPES: &str = "string id\nobject_recognition_msgs/ObjectType type\nshape_msgs/SolidPrimitive[] primitives\n\
     geometry_msgs/Pose[] primitive_poses\nshape_msgs/Mesh[] meshes\ngeometry_msgs/Pose[] mesh_poses\n\
     shape_msgs/Plane[] planes\ngeometry_msgs/Pose[] plane_poses\n";
const OPERATIONS: &str = "byte ADD=0\nbyte REMOVE=1\nbyte APPEND=2\nbyte MOVE=3\nbyte operation\n";

impl Message for CollisionObject {
    fn msg_definition() -> String {
        let subframes = "string[] subframe_names\ngeometry_msgs/Pose[] subframe_poses\n";
        with_parts(&format!("Header header\ngeometry_msgs/Pose pose\n{SHAPES}{subframes}{OPERATIONS}"), &PARTS)
    }

    fn md5sum() -> String {
        "dbba710596087da521c07564160dfccb".to_owned()
    }

    fn msg_type() -> String {
        "moveit_msgs/CollisionObject".to_owned()
    }
}

impl Message for MelodicCollisionObject {
    fn msg_definition() -> String {
        with_parts(&format!("Header header\n{SHAPES}{OPERATIONS}"), &PARTS)
    }

    fn md5sum() -> String {
        "568a161b26dc46c54a5a07621ce82cf3".to_owned()
    }

    fn msg_type() -> String {
        CollisionObject::msg_type()
    }
}

impl From<CollisionObject> for MelodicCollisionObject {
    /// The same object; `pose` must be the identity, and subframes are lost.
    fn from(object: CollisionObject) -> Self {
        Self {
            header: object.header,
            id: object.id,
            r#type: object.r#type,
            primitives: object.primitives,
            primitive_poses: object.primitive_poses,
            meshes: object.meshes,
            mesh_poses: object.mesh_poses,
            planes: object.planes,
            plane_poses: object.plane_poses,
            operation: object.operation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn object() -> CollisionObject {
        CollisionObject {
            header: Header { frame_id: "map".to_owned(), ..Header::default() },
            id: "beam".to_owned(),
            primitives: vec![SolidPrimitive { r#type: SolidPrimitive::CYLINDER, dimensions: vec![1.5, 0.05] }],
            primitive_poses: vec![Pose::default()],
            operation: CollisionObject::REMOVE,
            ..CollisionObject::default()
        }
    }

    #[test]
    fn an_object_comes_back_as_it_was() {
        let bytes = crate::encode(&object());
        assert_eq!(crate::decode::<CollisionObject>(&bytes).unwrap(), object());
        let older = MelodicCollisionObject::from(object());
        let shorter = crate::encode(&older);
        assert_eq!(crate::decode::<MelodicCollisionObject>(&shorter).unwrap(), older);
        // A pose and two empty lists less.
        assert_eq!(shorter.len(), bytes.len() - 56 - 8);
    }
}
