//! Unchecked numbers from C. The header calls each by its `enum`, or `bool`.

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
