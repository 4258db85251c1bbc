//! The frames, the time and the files that displays draw with.

use nalgebra::Isometry3;
use rcs_messages::std_msgs::Header;
use rcs_messages::{stamp_nanos, PlainTransform};
use rcs_resources::MeshStore;
use rcs_transforms::{LookupError, Prediction, Time, TransformTree};

/// The frames, the time and the files that displays draw with.
///
/// ```
/// use rcs_displays::World;
/// use rcs_resources::{MeshStore, PackageIndex};
/// use rcs_transforms::{RawTransform, Time, TransformTree};
///
/// let mut transforms = TransformTree::new();
/// let (translation, rotation_xyzw) = ([0.0, 0.0, 1.5], [0.0, 0.0, 0.0, 1.0]);
/// let camera = RawTransform { parent: "map", child: "camera", stamp: Time::ZERO, translation, rotation_xyzw };
/// transforms.insert(&camera, true, "/static_transform_publisher").expect("a transform with finite numbers");
/// let meshes = MeshStore::new(PackageIndex::new([]));
/// let world = World::new(&transforms, "map", Time::ZERO, &meshes);
///
/// let fixed_from_camera = world.fixed_from("camera", Time::ZERO).expect("a frame of the tree");
/// assert_eq!(fixed_from_camera.translation.z, 1.5);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct World<'a> {
    /// Where frames are.
    pub transforms: &'a TransformTree,
    /// The frame in which the scene is built.
    pub fixed_frame: &'a str,
    /// ROS time now.
    pub now: Time,
    /// The time at which what follows moving frames is shown, if that is predicted.
    pub prediction: Option<Prediction>,
    /// How many markers a display places in one update at most, so that an array of very many does not hold up the
    /// pictures of other displays; those before it are shown until all are placed. `None`: all at once.
    pub step: Option<usize>,
    /// Meshes by their addresses.
    pub meshes: &'a MeshStore,
}

impl<'a> World<'a> {
    /// Without prediction, and in which all markers are placed at once.
    pub fn new(transforms: &'a TransformTree, fixed_frame: &'a str, now: Time, meshes: &'a MeshStore) -> Self {
        Self { transforms, fixed_frame, now, prediction: None, step: None, meshes }
    }

    /// Where a frame is in the fixed frame; time zero asks for the latest known place.
    ///
    /// # Errors
    /// See [`LookupError`].
    pub fn fixed_from(&self, frame: &str, time: Time) -> Result<Isometry3<f64>, LookupError> {
        self.transforms.lookup(self.fixed_frame, frame, time)
    }

    /// Where a frame that is followed is in the fixed frame: its latest known place, or a predicted one. What a message
    /// places once and for all is placed by [`fixed_from`](Self::fixed_from).
    ///
    /// # Errors
    /// See [`LookupError`].
    pub fn fixed_from_moving(&self, frame: &str) -> Result<Isometry3<f64>, LookupError> {
        match &self.prediction {
            Some(prediction) => self.transforms.predict(self.fixed_frame, frame, prediction),
            None => self.fixed_from(frame, Time::ZERO),
        }
    }

    /// Where a message's frame is in the fixed frame, at the message's stamp.
    ///
    /// # Errors
    /// See [`LookupError`].
    pub fn fixed_from_header(&self, header: &Header) -> Result<Isometry3<f64>, LookupError> {
        self.fixed_from(&header.frame_id, stamp(header))
    }
}

/// A message's stamp as a time of the frame tree.
pub fn time_from_stamp(stamp: rcs_messages::Time) -> Time {
    Time::from_nanos(stamp_nanos(stamp))
}

/// A header's time.
pub(crate) fn stamp(header: &Header) -> Time {
    time_from_stamp(header.stamp)
}

/// A pose as rviz reads it: the quaternion is normalised; one of zero length is no rotation.
///
/// `None` when a number is NaN or infinite.
pub(crate) fn isometry(pose: &PlainTransform) -> Option<Isometry3<f64>> {
    let [x, y, z, w] = pose.rotation_xyzw;
    if pose.translation.iter().chain(&pose.rotation_xyzw).any(|value| !value.is_finite()) {
        return None;
    }
    let rotation = nalgebra::UnitQuaternion::try_new(nalgebra::Quaternion::new(w, x, y, z), 1e-9).unwrap_or_default();
    Some(Isometry3::from_parts(pose.translation.into(), rotation))
}
