//! Building blocks that several display classes share.

pub(crate) mod bounds;
pub(crate) mod cloud;
pub(crate) mod compressed_image;
pub(crate) mod covariance;
pub(crate) mod encoding;
pub(crate) mod gathering;
pub(crate) mod history;
pub(crate) mod pose_symbol;
pub(crate) mod robot_description;
pub(crate) mod screw;
pub(crate) mod shapes;
pub(crate) mod single_value;
pub(crate) mod solids;
pub(crate) mod trail;
