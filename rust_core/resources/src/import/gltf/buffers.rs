//! The binary data of a glTF file: its buffers, and the values of accessors in them.

use std::borrow::Cow;

use base64::{
    alphabet,
    engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig},
    Engine,
};

use super::json::{fault, GltfAccessor, GltfBuffer, GltfBufferView, GltfRoot, SparsePlace};
use crate::{
    import::{
        imported::{check_count, MeshSource},
        scalar::ScalarType,
    },
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

/// The type of an OpenGL constant.
fn scalar_type(number: u32) -> Result<ScalarType, MeshFault> {
    Ok(match number {
        5120 => ScalarType::I8,
        5121 => ScalarType::U8,
        5122 => ScalarType::I16,
        5123 => ScalarType::U16,
        5125 => ScalarType::U32,
        5126 => ScalarType::F32,
        other => return Err(fault(format!("component type {other} does not exist"))),
    })
}

/// The number in these bytes; normalized integers are scaled to −1 or 0 up to 1.
fn component(kind: ScalarType, bytes: &[u8], is_normalized: bool) -> f32 {
    let value = kind.value(bytes).map_or(f32::NAN, |value| value as f32);
    let largest = match kind {
        ScalarType::I8 => 127.0,
        ScalarType::U8 => 255.0,
        ScalarType::I16 => 32767.0,
        ScalarType::U16 => 65535.0,
        _ => return value,
    };
    if is_normalized {
        (value / largest).max(-1.0)
    } else {
        value
    }
}

/// The index in these bytes.
fn index_value(kind: ScalarType, bytes: &[u8]) -> Option<u32> {
    let is_index = matches!(kind, ScalarType::U8 | ScalarType::U16 | ScalarType::U32);
    kind.value(bytes).filter(|_| is_index).map(|value| value as u32)
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
        let view = self.root.buffer_views.get(index).ok_or_else(|| fault(format!("there is no bufferView {index}")))?;
        let bytes = self.loaded.get(view.buffer).and_then(|buffer| {
            let end = view.byte_offset.checked_add(view.byte_length)?;
            buffer.get(view.byte_offset..end)
        });
        Ok((view, bytes.ok_or_else(|| fault(format!("bufferView {index} is past the end of its buffer")))?))
    }

    /// The vectors of an accessor; missing components are zero.
    pub(super) fn vectors<const N: usize>(&self, index: usize) -> Result<Vec<[f32; N]>, MeshFault> {
        let accessor = self.accessor(index)?;
        let kind = scalar_type(accessor.component_type)?;
        let size = kind.size_bytes();
        let vector = |bytes: &[u8]| {
            let mut vector = [0.0; N];
            for (slot, bytes) in vector.iter_mut().zip(bytes.chunks_exact(size)) {
                *slot = component(kind, bytes, accessor.normalized);
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
            let index_type = scalar_type(sparse.indices.component_type)?;
            let indices = self.packed(&sparse.indices, sparse.count, index_type.size_bytes())?;
            let values = self.packed(&sparse.values, sparse.count, element)?;
            for (place, value) in indices.zip(values) {
                let slot = index_value(index_type, place).and_then(|index| vectors.get_mut(index as usize));
                *slot.ok_or_else(|| fault("a sparse value replaces none"))? = vector(value);
            }
        }
        Ok(vectors)
    }

    /// The indices of an accessor.
    pub(super) fn indices(&self, number: usize) -> Result<Vec<u32>, MeshFault> {
        let accessor = self.accessor(number)?;
        let kind = scalar_type(accessor.component_type)?;
        let indices = self.elements(accessor, kind.size_bytes())?.map(|bytes| index_value(kind, bytes));
        indices.collect::<Option<_>>().ok_or_else(|| fault(format!("accessor {number} has no indices")))
    }

    /// Number of values of an accessor.
    pub(super) fn count(&self, index: usize) -> Result<usize, MeshFault> {
        self.accessor(index).map(|accessor| accessor.count)
    }

    fn accessor(&self, index: usize) -> Result<&'a GltfAccessor, MeshFault> {
        self.root.accessors.get(index).ok_or_else(|| fault(format!("there is no accessor {index}")))
    }

    /// The bytes of each value of an accessor, `size` bytes each.
    fn elements(&self, accessor: &GltfAccessor, size: usize) -> Result<impl Iterator<Item = &[u8]>, MeshFault> {
        let view = accessor.buffer_view.ok_or_else(|| fault("indices without a bufferView"))?;
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
        return Err(fault(format!("{count} values are past the end of their bufferView")));
    }
    Ok((0..count).map(move |number| bytes.get(offset + number * stride..).and_then(|b| b.get(..size)).unwrap_or(&[])))
}

fn components_of(kind: &str) -> Result<usize, MeshFault> {
    Ok(match kind {
        "" | "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        other => return Err(fault(format!("type {other:?} is not supported"))),
    })
}

/// The bytes of a `data:` URI; `None` for other URIs.
pub(super) fn data_of_uri(uri: &str) -> Option<Result<Vec<u8>, MeshFault>> {
    let (media, data) = uri.strip_prefix("data:")?.split_once(',').unwrap_or_default();
    let decoded = media.ends_with(";base64").then(|| BASE64.decode(data.trim_ascii()).ok()).flatten();
    Some(decoded.ok_or_else(|| fault("a data URI is not base64")))
}

/// A file of at most `max_bytes` beside the mesh.
fn read_beside(uri: &str, source: MeshSource<'_>, max_bytes: u64) -> Result<Vec<u8>, MeshFault> {
    let decoded = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let read = |name: &str| source.options.read(&source.beside(name));
    let bytes = read(uri).or_else(|error| read(&decoded).map_err(|_| error));
    let bytes = bytes.map_err(|error| fault(format!("buffer {uri:?}: {error}")))?;
    if bytes.len() as u64 > max_bytes {
        return Err(fault(format!("buffer {uri:?}: all buffers together are larger than a file may be")));
    }
    Ok(bytes)
}
