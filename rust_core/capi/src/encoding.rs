//! The encodings of a published image.

use std::ffi::{c_char, CStr};
use std::mem::MaybeUninit;

use rcs_scene::Encoding;

use crate::fault::{Fault, RcsResult};
use crate::numbers::EncodingNumber;
use crate::{guard, pointers};

/// The encodings of a published image, by the names of `sensor_msgs/image_encodings`, in the order of the property's
/// menu.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RcsEncoding {
    /// Red, green, blue.
    Rgb8 = 0,
    /// Red, green, blue, alpha (always 255).
    Rgba8,
    /// Blue, green, red.
    Bgr8,
    /// Blue, green, red, alpha (always 255).
    Bgra8,
    /// The red channel.
    Mono8,
    /// The red channel in 16 bits, little endian.
    Mono16,
}

impl RcsEncoding {
    /// All encodings, in the order of [`Encoding::ALL`].
    pub(crate) const ALL: [Self; 6] = [Self::Rgb8, Self::Rgba8, Self::Bgr8, Self::Bgra8, Self::Mono8, Self::Mono16];
}

/// The encodings' names for C, in the order of [`Encoding::ALL`].
const NAMES: [&CStr; 6] = [c"rgb8", c"rgba8", c"bgr8", c"bgra8", c"mono8", c"mono16"];

/// Bytes of one pixel in an encoding; 0 for an invalid encoding.
#[no_mangle]
pub extern "C" fn rcs_encoding_bytes_per_pixel(encoding: EncodingNumber) -> usize {
    guard::value(0, || encoding.checked().map(Encoding::bytes_per_pixel))
}

/// The name of an encoding, such as `"rgb8"`; static, NULL for an invalid encoding.
#[no_mangle]
pub extern "C" fn rcs_encoding_name(encoding: EncodingNumber) -> *const c_char {
    guard::value(std::ptr::null(), || {
        encoding.checked()?;
        Ok(NAMES.get(encoding.0 as usize).map_or(std::ptr::null(), |name| name.as_ptr()))
    })
}

/// Writes the encoding of a name. `RCS_RESULT_BAD_VALUE` for an unknown name.
///
/// # Safety
/// `name` ends with a NUL.
#[no_mangle]
pub unsafe extern "C" fn rcs_encoding_from_name(
    name: *const c_char,
    encoding: Option<&mut MaybeUninit<RcsEncoding>>,
) -> RcsResult {
    guard::result(|| {
        // SAFETY: as the caller promises.
        let name = unsafe { pointers::text(name, "name") }?;
        let encoding = pointers::required(encoding, "encoding")?;
        let mut known = RcsEncoding::ALL.into_iter().zip(Encoding::ALL);
        let found = known.find(|(_, known)| known.name() == name);
        let unknown = || {
            let known = Encoding::ALL.map(Encoding::name).join(", ");
            Fault::new(RcsResult::BadValue, format_args!("unknown encoding '{name}'; encodings: {known}"))
        };
        encoding.write(found.ok_or_else(unknown)?.0);
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers_are_those_of_the_node() {
        for (at, encoding) in Encoding::ALL.into_iter().enumerate() {
            let number = EncodingNumber(at as u32);
            assert_eq!(rcs_encoding_bytes_per_pixel(number), encoding.bytes_per_pixel());
            // SAFETY: static, with a NUL.
            let name = unsafe { CStr::from_ptr(rcs_encoding_name(number)) };
            assert_eq!(name.to_str(), Ok(encoding.name()));
            let mut found = MaybeUninit::uninit();
            // SAFETY: the name ends with a NUL.
            assert_eq!(unsafe { rcs_encoding_from_name(name.as_ptr(), Some(&mut found)) }, RcsResult::Ok);
            // SAFETY: it was written.
            assert_eq!(unsafe { found.assume_init() }, RcsEncoding::ALL[at]);
        }
        for number in [6, u32::MAX].map(EncodingNumber) {
            assert_eq!(rcs_encoding_bytes_per_pixel(number), 0);
            assert!(rcs_encoding_name(number).is_null());
        }
    }

    #[test]
    fn other_names_are_refused() {
        let mut found = MaybeUninit::new(RcsEncoding::Bgra8);
        for name in [c"", c"RGB8", c"rgb", c"rgb88", c"\xff"] {
            // SAFETY: the name ends with a NUL.
            assert_eq!(unsafe { rcs_encoding_from_name(name.as_ptr(), Some(&mut found)) }, RcsResult::BadValue);
        }
        // SAFETY: it has a value from the beginning.
        assert_eq!(unsafe { found.assume_init() }, RcsEncoding::Bgra8);
    }
}
