//! Collision objects of MoveIt's planning scene.
//!
//! Since moveit_msgs 0.11 (Noetic) an object has a pose that its shapes are relative to, and subframes;
//! [`MelodicCollisionObject`] is the type before. A subscriber of one does not accept the other.

use crate::fields::{fields_in_order, message_types, with_parts};
use crate::geometry_msgs::{Point, Pose};
use crate::std_msgs::Header;

fields_in_order! {
    /// `object_recognition_msgs/ObjectType`: key of an object in a database.
    ObjectType {
        /// Key.
        key: String,
        /// Parameters of the database.
        db: String,
    }
    /// `shape_msgs/SolidPrimitive`: a shape around its own origin.
    SolidPrimitive {
        /// Type, such as [`SolidPrimitive::CYLINDER`].
        r#type: u8,
        /// Dimensions, metres; of a cylinder its height and radius.
        dimensions: Vec<f64>,
    }
    /// `shape_msgs/MeshTriangle`
    MeshTriangle {
        /// Indices of three vertices.
        vertex_indices: [u32; 3],
    }
    /// `shape_msgs/Mesh`
    Mesh {
        /// Faces.
        triangles: Vec<MeshTriangle>,
        /// Vertices, metres.
        vertices: Vec<Point>,
    }
    /// `shape_msgs/Plane`: ax + by + cz + d = 0.
    Plane {
        /// Coefficients a, b, c, d.
        coef: [f64; 4],
    }
    /// `moveit_msgs/CollisionObject` of Noetic.
    CollisionObject {
        /// Frame of the poses.
        header: Header,
        /// Pose of the object, which the shapes' poses are relative to.
        pose: Pose,
        /// Name.
        id: String,
        /// Type in a database.
        r#type: ObjectType,
        /// Simple shapes.
        primitives: Vec<SolidPrimitive>,
        /// Poses of the shapes.
        primitive_poses: Vec<Pose>,
        /// Meshes.
        meshes: Vec<Mesh>,
        /// Poses of the meshes.
        mesh_poses: Vec<Pose>,
        /// Planes.
        planes: Vec<Plane>,
        /// Poses of the planes.
        plane_poses: Vec<Pose>,
        /// Names of the subframes.
        subframe_names: Vec<String>,
        /// Poses of the subframes.
        subframe_poses: Vec<Pose>,
        /// [`CollisionObject::ADD`] or [`CollisionObject::REMOVE`].
        operation: i8,
    }
    /// `moveit_msgs/CollisionObject` of Melodic and before.
    MelodicCollisionObject {
        /// Frame of the poses.
        header: Header,
        /// Name.
        id: String,
        /// Type in a database.
        r#type: ObjectType,
        /// Simple shapes.
        primitives: Vec<SolidPrimitive>,
        /// Poses of the shapes in the header's frame.
        primitive_poses: Vec<Pose>,
        /// Meshes.
        meshes: Vec<Mesh>,
        /// Poses of the meshes.
        mesh_poses: Vec<Pose>,
        /// Planes.
        planes: Vec<Plane>,
        /// Poses of the planes.
        plane_poses: Vec<Pose>,
        /// Operation, as in [`CollisionObject`].
        operation: i8,
    }
}

impl SolidPrimitive {
    /// A cylinder along z.
    pub const CYLINDER: u8 = 3;
}

impl CollisionObject {
    /// Adds the object, or replaces one of the same name.
    pub const ADD: i8 = 0;
    /// Removes the object.
    pub const REMOVE: i8 = 1;
}

/// Definitions of the parts, by name.
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

message_types! {
    CollisionObject: "moveit_msgs/CollisionObject", "dbba710596087da521c07564160dfccb", {
        let subframes = "string[] subframe_names\ngeometry_msgs/Pose[] subframe_poses\n";
        with_parts(&format!("Header header\ngeometry_msgs/Pose pose\n{SHAPES}{subframes}{OPERATIONS}"), &PARTS)
    };
    MelodicCollisionObject: "moveit_msgs/CollisionObject", "568a161b26dc46c54a5a07621ce82cf3",
        with_parts(&format!("Header header\n{SHAPES}{OPERATIONS}"), &PARTS);
}

impl From<CollisionObject> for MelodicCollisionObject {
    /// Converts an object whose `pose` is the identity; subframes are lost.
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
