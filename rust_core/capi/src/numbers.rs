//! Unchecked numbers from C. The header calls each by its `enum`, or `bool`.

use rcs_camera::Projection;
use rcs_scene::{Encoding, PixelOrder};

use crate::fault::{Fault, RcsResult};

/// A `bool` of C: every number except 0 is true.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct Flag(pub u8);

/// An `RcsProjection`, unchecked.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct ProjectionNumber(pub u32);

/// An `RcsEncoding`, unchecked.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct EncodingNumber(pub u32);

/// An `RcsPixelOrder`, unchecked.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct PixelOrderNumber(pub u32);

impl Flag {
    pub(crate) fn is_set(self) -> bool {
        self.0 != 0
    }
}

impl ProjectionNumber {
    pub(crate) fn checked(self) -> Result<Projection, Fault> {
        known(&[Projection::Rviz, Projection::Exact], self.0, "RcsProjection")
    }
}

impl EncodingNumber {
    pub(crate) fn checked(self) -> Result<Encoding, Fault> {
        known(&Encoding::ALL, self.0, "RcsEncoding")
    }
}

impl PixelOrderNumber {
    pub(crate) fn checked(self) -> Result<PixelOrder, Fault> {
        known(&[PixelOrder::Rgba, PixelOrder::Bgra], self.0, "RcsPixelOrder")
    }
}

/// The value of a number of C's `enum`, whose values are in that order.
fn known<T: Copy>(values: &[T], number: u32, name: &str) -> Result<T, Fault> {
    let unknown = || Fault::new(RcsResult::BadValue, format_args!("{number} is no {name}"));
    values.get(number as usize).copied().ok_or_else(unknown)
}
