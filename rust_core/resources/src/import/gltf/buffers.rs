//! The binary data of a glTF file: its buffers, and the values of accessors in them.

use std::borrow::Cow;

use base64::{
    alphabet,
    engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig},
    Engine,
};

use super::json::{GltfAccessor, GltfBuffer, GltfBufferView, GltfRoot, SparsePlace};
use crate::{
    import::imported::{check_count, MeshSource},
    MeshFault,
};

/// Base64 with padding or without, and with any trailing bits.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);
/// Most values of an accessor without data, which are zero.
const MAX_ZEROS: usize = 1 << 20;

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl ComponentType {
    /// The type of an OpenGL constant.
    fn of(number: u32) -> Result<Self, MeshFault> {
        Ok(match number {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            other => return Err(MeshFault::malformed(format!("component type {other} does not exist"))),
        })
    }

    fn size_bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number in these bytes; normalized integers are scaled to −1 or 0 up to 1.
    fn value(self, bytes: &[u8], normalized: bool) -> f32 {
        let scaled = |value: f32, largest: f32| if normalized { (value / largest).max(-1.0) } else { value };
        match (self, bytes) {
            (Self::I8, &[a]) => scaled(f32::from(i8::from_le_bytes([a])), 127.0),
            (Self::U8, &[a]) => scaled(f32::from(a), 255.0),
            (Self::I16, &[a, b]) => scaled(f32::from(i16::from_le_bytes([a, b])), 32767.0),
            (Self::U16, &[a, b]) => scaled(f32::from(u16::from_le_bytes([a, b])), 65535.0),
            (Self::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]) as f32,
            (Self::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            _ => f32::NAN,
        }
    }

    /// The index in these bytes.
    fn index(self, bytes: &[u8]) -> Option<u32> {
        match (self, bytes) {
            (Self::U8, &[a]) => Some(u32::from(a)),
            (Self::U16, &[a, b]) => Some(u32::from(u16::from_le_bytes([a, b]))),
            (Self::U32, &[a, b, c, d]) => Some(u32::from_le_bytes([a, b, c, d])),
            _ => None,
        }
    }
}

/// The buffers of a file, loaded.
pub(super) struct GltfBuffers<'a> {
    root: &'a GltfRoot,
    loaded: Vec<Cow<'a, [u8]>>,
}

impl<'a> GltfBuffers<'a> {
    /// Loads the buffers; `binary` are the bytes after a GLB's JSON. The size limit of a file holds for all together.
    pub(super) fn load(root: &'a GltfRoot, binary: &'a [u8], source: MeshSource<'_>) -> Result<Self, MeshFault> {
        let mut left = source.options.max_file_bytes;
        let mut loaded = Vec::with_capacity(root.buffers.len());
        for GltfBuffer { uri } in &root.buffers {
            let bytes = match uri {
                None => Cow::Borrowed(binary),
                Some(uri) => Cow::Owned(match data_of_uri(uri) {
                    Some(data) => data?,
                    None => read_beside(uri, source, left)?,
                }),
            };
            if let Cow::Owned(bytes) = &bytes {
                left = left.saturating_sub(bytes.len() as u64);
            }
            loaded.push(bytes);
        }
        Ok(Self { root, loaded })
    }

    /// The bytes of a view.
    pub(super) fn view(&self, index: usize) -> Result<(&GltfBufferView, &[u8]), MeshFault> {
        let view = self
            .root
            .buffer_views
            .get(index)
            .ok_or_else(|| MeshFault::malformed(format!("there is no bufferView {index}")))?;
        let bytes = self.loaded.get(view.buffer).and_then(|buffer| {
            let end = view.byte_offset.checked_add(view.byte_length)?;
            buffer.get(view.byte_offset..end)
        });
        Ok((
            view,
            bytes.ok_or_else(|| MeshFault::malformed(format!("bufferView {index} is past the end of its buffer")))?,
        ))
    }

    /// The vectors of an accessor; missing components are zero.
    pub(super) fn vectors<const N: usize>(&self, index: usize) -> Result<Vec<[f32; N]>, MeshFault> {
        let accessor = self.accessor(index)?;
        let component = ComponentType::of(accessor.component_type)?;
        let size = component.size_bytes();
        let vector = |bytes: &[u8]| {
            let mut vector = [0.0; N];
            for (slot, bytes) in vector.iter_mut().zip(bytes.chunks_exact(size)) {
                *slot = component.value(bytes, accessor.normalized);
            }
            vector
        };
        let element = size * components_of(&accessor.kind)?;
        let mut vectors: Vec<[f32; N]> = match accessor.buffer_view {
            Some(_) => self.elements(accessor, element)?.map(vector).collect(),
            None => {
                check_count(accessor.count, MAX_ZEROS, "zeros")?;
                vec![[0.0; N]; accessor.count]
            }
        };
        if let Some(sparse) = &accessor.sparse {
            let index_type = ComponentType::of(sparse.indices.component_type)?;
            let indices = self.packed(&sparse.indices, sparse.count, index_type.size_bytes())?;
            let values = self.packed(&sparse.values, sparse.count, element)?;
            for (index, value) in indices.zip(values) {
                let slot = index_type.index(index).and_then(|index| vectors.get_mut(index as usize));
                *slot.ok_or_else(|| MeshFault::malformed("a sparse value replaces none"))? = vector(value);
            }
        }
        Ok(vectors)
    }

    /// The indices of an accessor.
    pub(super) fn indices(&self, index: usize) -> Result<Vec<u32>, MeshFault> {
        let accessor = self.accessor(index)?;
        let component = ComponentType::of(accessor.component_type)?;
        let indices = self.elements(accessor, component.size_bytes())?.map(|bytes| component.index(bytes));
        indices.collect::<Option<_>>().ok_or_else(|| MeshFault::malformed(format!("accessor {index} has no indices")))
    }

    /// Number of values of an accessor.
    pub(super) fn count(&self, index: usize) -> Result<usize, MeshFault> {
        self.accessor(index).map(|accessor| accessor.count)
    }

    fn accessor(&self, index: usize) -> Result<&'a GltfAccessor, MeshFault> {
        self.root.accessors.get(index).ok_or_else(|| MeshFault::malformed(format!("there is no accessor {index}")))
    }

    /// The bytes of each value of an accessor, `size` bytes each.
    fn elements(&self, accessor: &GltfAccessor, size: usize) -> Result<impl Iterator<Item = &[u8]>, MeshFault> {
        let view = accessor.buffer_view.ok_or_else(|| MeshFault::malformed("indices without a bufferView"))?;
        let (view, bytes) = self.view(view)?;
        let stride = view.byte_stride.filter(|stride| *stride > 0).unwrap_or(size).max(1);
        strided(bytes, accessor.byte_offset, accessor.count, stride, size)
    }

    /// The bytes of each value of a sparse accessor, or of each index.
    fn packed(&self, place: &SparsePlace, count: usize, size: usize) -> Result<impl Iterator<Item = &[u8]>, MeshFault> {
        let (_, bytes) = self.view(place.buffer_view)?;
        strided(bytes, place.byte_offset, count, size.max(1), size)
    }
}

/// `count` slices of `size` bytes, `stride` bytes apart.
fn strided(
    bytes: &[u8],
    offset: usize,
    count: usize,
    stride: usize,
    size: usize,
) -> Result<impl Iterator<Item = &[u8]>, MeshFault> {
    let last = count.saturating_sub(1).checked_mul(stride).and_then(|last| last.checked_add(offset)?.checked_add(size));
    if count > 0 && last.is_none_or(|end| end > bytes.len()) {
        return Err(MeshFault::malformed(format!("{count} values are past the end of their bufferView")));
    }
    Ok((0..count).map(move |number| bytes.get(offset + number * stride..).and_then(|b| b.get(..size)).unwrap_or(&[])))
}

fn components_of(kind: &str) -> Result<usize, MeshFault> {
    Ok(match kind {
        "" | "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        other => return Err(MeshFault::malformed(format!("type {other:?} is not supported"))),
    })
}

/// The bytes of a `data:` URI; `None` for other URIs.
pub(super) fn data_of_uri(uri: &str) -> Option<Result<Vec<u8>, MeshFault>> {
    let (media, data) = uri.strip_prefix("data:")?.split_once(',').unwrap_or_default();
    let decoded = media.ends_with(";base64").then(|| BASE64.decode(data.trim_ascii()).ok()).flatten();
    Some(decoded.ok_or_else(|| MeshFault::malformed("a data URI is not base64")))
}

/// A file of at most `max_bytes` beside the mesh.
fn read_beside(uri: &str, source: MeshSource<'_>, max_bytes: u64) -> Result<Vec<u8>, MeshFault> {
    let decoded = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let read = |name: &str| source.options.read(&source.beside(name));
    let bytes = read(uri).or_else(|error| read(&decoded).map_err(|_| error));
    let bytes = bytes.map_err(|error| MeshFault::malformed(format!("buffer {uri:?}: {error}")))?;
    if bytes.len() as u64 > max_bytes {
        return Err(MeshFault::malformed(format!(
            "buffer {uri:?}: all buffers together are larger than a file may be"
        )));
    }
    Ok(bytes)
}
