//! Frames of Motion JPEG, as USB cameras send them: JPEG that may lack the Huffman tables, which are then those of
//! ITU-T T.81, Annex K.

/// The segment APP0 by which AVI files mark frames of Motion JPEG.
const APP0: [u8; 18] = *b"\xff\xe0\x00\x10AVI1\0\0\0\0\0\0\0\0\0\0";

/// Marks a JPEG as a frame of Motion JPEG. The decoder, `zune-jpeg`, then takes the standard's tables for missing ones,
/// as libjpeg and so OpenCV do for any JPEG. Other bytes stay as they are.
///
/// ```
/// let marked = rcs_messages::as_motion_jpeg(b"\xff\xd8\xff\xdb".to_vec());
/// assert_eq!(marked, b"\xff\xd8\xff\xe0\x00\x10AVI1\0\0\0\0\0\0\0\0\0\0\xff\xdb");
/// ```
pub fn as_motion_jpeg(mut bytes: Vec<u8>) -> Vec<u8> {
    const START_OF_IMAGE: &[u8] = b"\xff\xd8";
    if bytes.starts_with(START_OF_IMAGE) {
        bytes.splice(START_OF_IMAGE.len()..START_OF_IMAGE.len(), APP0);
    }
    bytes
}
