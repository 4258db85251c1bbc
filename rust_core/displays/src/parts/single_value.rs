//! Displays of messages of a single value: one point where the sensor is, coloured by what it measured.

use std::marker::PhantomData;
use std::sync::Arc;

use rcs_messages::sensor_msgs::PointField;
use rcs_messages::TypedMessage;

use crate::parts::cloud::{one_row, CloudDisplay, CloudSource, NonFinite, PlacedCloud};
use crate::{StatusText, World};

pub(crate) trait SingleValue: TypedMessage {
    /// Name of the channel by which the point is coloured.
    const CHANNEL: &'static str;

    fn value(&self) -> f64;
}

pub(crate) type SingleValueDisplay<M> = CloudDisplay<SingleValueSource<M>>;

/// A message of a single value as a cloud of one point.
#[derive(Debug)]
pub(crate) struct SingleValueSource<M>(PhantomData<M>);

impl<M: SingleValue> CloudSource for SingleValueSource<M> {
    type Message = M;
    const NON_FINITE: NonFinite = NonFinite::FarAway;

    fn place(message: &Arc<M>, world: &World<'_>) -> Result<PlacedCloud, StatusText> {
        let fields = [
            ("x", 0, PointField::FLOAT32),
            ("y", 4, PointField::FLOAT32),
            ("z", 8, PointField::FLOAT32),
            (M::CHANNEL, 12, PointField::FLOAT64),
        ];
        let mut data = vec![0; 12];
        data.extend(message.value().to_le_bytes());
        let header = message.header().cloned().unwrap_or_default();
        PlacedCloud::at_stamp(Arc::new(one_row(&header, &fields, 20, data)), world)
    }
}
