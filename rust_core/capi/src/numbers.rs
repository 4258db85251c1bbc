//! Numbers from C that stand for one of a few. The header calls each by its `enum`, or `bool`.

use rcs_camera::Projection;
use rcs_scene::{Encoding, PixelOrder};

use crate::encoding::RcsEncoding;
use crate::fault::{Fault, RcsResult};
use crate::pixels::RcsPixelOrder;
use crate::view::RcsProjection;

/// A `bool` of C: anything but 0 is true.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct Flag(pub u8);

/// An `RcsProjection`, or another number.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct ProjectionNumber(pub u32);

/// An `RcsEncoding`, or another number.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct EncodingNumber(pub u32);

/// An `RcsPixelOrder`, or another number.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct PixelOrderNumber(pub u32);

impl Flag {
    pub(crate) fn is_set(self) -> bool {
        self.0 != 0
    }
}

fn unknown<T>(name: &str, number: u32) -> Result<T, Fault> {
    Err(Fault::new(RcsResult::BadValue, format_args!("{number} is no {name}")))
}

impl ProjectionNumber {
    pub(crate) fn checked(self) -> Result<Projection, Fault> {
        match self.0 {
            number if number == RcsProjection::Rviz as u32 => Ok(Projection::Rviz),
            number if number == RcsProjection::Exact as u32 => Ok(Projection::Exact),
            number => unknown("RcsProjection", number),
        }
    }
}

impl EncodingNumber {
    pub(crate) fn checked(self) -> Result<Encoding, Fault> {
        let known = RcsEncoding::ALL.into_iter().zip(Encoding::ALL);
        let found = known.into_iter().find(|(number, _)| *number as u32 == self.0);
        found.map_or_else(|| unknown("RcsEncoding", self.0), |(_, encoding)| Ok(encoding))
    }
}

impl PixelOrderNumber {
    pub(crate) fn checked(self) -> Result<PixelOrder, Fault> {
        match self.0 {
            number if number == RcsPixelOrder::Rgba as u32 => Ok(PixelOrder::Rgba),
            number if number == RcsPixelOrder::Bgra as u32 => Ok(PixelOrder::Bgra),
            number => unknown("RcsPixelOrder", number),
        }
    }
}
