//! The frames, the time and the files that displays draw with.

use nalgebra::Isometry3;
use rcs_messages::std_msgs::Header;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{stamp_nanos, PlainTransform};
use rcs_resources::MeshStore;
use rcs_transforms::{LookupError, Prediction, RawTransform, Time, TransformTree};

use crate::framework::lookups::Lookups;

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
    /// The frame tree.
    pub transforms: &'a TransformTree,
    /// The frame in which the scene is built.
    pub fixed_frame: &'a str,
    /// ROS time now.
    pub now: Time,
    /// Time for which moving frames are predicted, if they are.
    pub prediction: Option<Prediction>,
    /// Largest number of markers that a display places in one update, so that a large array does not hold up other
    /// displays; the old ones are shown until all are placed. `None`: all at once.
    pub step: Option<usize>,
    /// `true` if the renderer decodes points by itself, see [`rcs_scene::PackedPoints`].
    pub packs_points: bool,
    /// Meshes by URL.
    pub meshes: &'a MeshStore,
    lookups: Option<&'a Lookups>,
}

impl<'a> World<'a> {
    /// A world without prediction, and in which all markers are placed at once.
    pub fn new(transforms: &'a TransformTree, fixed_frame: &'a str, now: Time, meshes: &'a MeshStore) -> Self {
        Self { transforms, fixed_frame, now, prediction: None, step: None, packs_points: false, meshes, lookups: None }
    }

    /// Copy for one display, whose lookups are recorded.
    pub(crate) fn recording<'b>(&self, lookups: &'b Lookups) -> World<'b>
    where
        'a: 'b,
    {
        World { lookups: Some(lookups), ..*self }
    }

    /// Pose of a frame in the fixed frame, for drawables that are placed once; time zero asks for the latest one.
    ///
    /// # Errors
    /// See [`LookupError`].
    pub fn fixed_from(&self, frame: &str, time: Time) -> Result<Isometry3<f64>, LookupError> {
        let (place, stamp) = self.transforms.lookup_stamped(self.fixed_frame, frame, time)?;
        if let Some(lookups) = self.lookups.filter(|_| time.is_zero() && !self.is_fixed(frame)) {
            lookups.place_at(stamp);
        }
        Ok(place)
    }

    /// Pose of a followed frame in the fixed frame: the latest or a predicted one. A display asks for it in each
    /// update; its drawables are as old as the frame's transforms, and too old while there are none.
    ///
    /// # Errors
    /// See [`LookupError`].
    pub fn fixed_from_moving(&self, frame: &str) -> Result<Isometry3<f64>, LookupError> {
        self.follow(frame);
        self.latest(frame)
    }

    /// Like [`fixed_from_moving`](Self::fixed_from_moving), for drawables that disappear while their frame is unknown.
    pub(crate) fn fixed_from_moving_if_known(&self, frame: &str) -> Result<Isometry3<f64>, LookupError> {
        self.latest(frame).inspect(|_| self.follow(frame))
    }

    /// Like [`fixed_from_moving`](Self::fixed_from_moving), for a display of all frames, which drops old ones singly.
    pub(crate) fn fixed_from_each(&self, frame: &str) -> Result<Isometry3<f64>, LookupError> {
        self.lookups.into_iter().for_each(Lookups::follow_all);
        self.latest(frame)
    }

    /// Like [`fixed_from_moving`](Self::fixed_from_moving), for poses that are not followed.
    pub(crate) fn fixed_from_now(&self, frame: &str) -> Result<Isometry3<f64>, LookupError> {
        let latest = self.fixed_from(frame, Time::ZERO)?;
        self.prediction.map_or(Ok(latest), |_| self.latest(frame))
    }

    fn latest(&self, frame: &str) -> Result<Isometry3<f64>, LookupError> {
        match &self.prediction {
            Some(prediction) => self.transforms.predict(self.fixed_frame, frame, prediction),
            None => self.transforms.lookup(self.fixed_frame, frame, Time::ZERO),
        }
    }

    /// Records a followed frame; the fixed frame does not age.
    fn follow(&self, frame: &str) {
        if let Some(lookups) = self.lookups.filter(|_| !self.is_fixed(frame)) {
            lookups.follow(frame);
        }
    }

    fn is_fixed(&self, frame: &str) -> bool {
        frame.trim_start_matches('/') == self.fixed_frame.trim_start_matches('/')
    }

    /// Pose of a message's frame in the fixed frame, at the message's stamp.
    ///
    /// # Errors
    /// See [`LookupError`].
    pub(crate) fn fixed_from_header(&self, header: &Header) -> Result<Isometry3<f64>, LookupError> {
        self.fixed_from(&header.frame_id, stamp(header))
    }
}

/// Converts a message's stamp.
pub fn time_from_stamp(stamp: rcs_messages::Time) -> Time {
    Time::from_nanos(stamp_nanos(stamp))
}

pub(crate) fn stamp(header: &Header) -> Time {
    time_from_stamp(header.stamp)
}

/// Transforms of a message, unchecked.
pub fn raw_transforms(message: &TFMessage) -> impl Iterator<Item = RawTransform<'_>> {
    message.transforms.iter().map(|stamped| {
        let PlainTransform { translation, rotation_xyzw } = (&stamped.transform).into();
        let stamp = time_from_stamp(stamped.header.stamp);
        RawTransform {
            parent: &stamped.header.frame_id,
            child: &stamped.child_frame_id,
            stamp,
            translation,
            rotation_xyzw,
        }
    })
}

/// `true` if none is NaN or, in single precision, infinite: as rviz's `validateFloats` takes them.
pub(crate) fn all_finite(values: &[f64]) -> bool {
    values.iter().all(|&value| (value as f32).is_finite())
}

/// A pose as rviz reads it: the quaternion is normalised; one of zero length is no rotation.
///
/// `None` unless all numbers are [finite](all_finite).
pub(crate) fn isometry(pose: &PlainTransform) -> Option<Isometry3<f64>> {
    let [x, y, z, w] = pose.rotation_xyzw;
    if !all_finite(&pose.translation) || !all_finite(&pose.rotation_xyzw) {
        return None;
    }
    let rotation = nalgebra::UnitQuaternion::try_new(nalgebra::Quaternion::new(w, x, y, z), 1e-9).unwrap_or_default();
    Some(Isometry3::from_parts(pose.translation.into(), rotation))
}
