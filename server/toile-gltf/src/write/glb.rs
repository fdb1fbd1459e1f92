//! The GLB container: binary pieces with their views and accessors, then one buffer of bytes.
//!
//! glTF 2.0, chapter 4 (GLB) and section 3.6 (binary data).

use glam::Vec3;
use serde_json::{Map, Value, json};

use super::WriteError;

const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
const FLOAT: u32 = 5126;

#[cfg(target_endian = "big")]
compile_error!("GLB is little-endian and buffers are written as they lie in memory");

/// A piece of the binary chunk, borrowed where it was prepared beforehand.
pub(super) enum Piece<'a> {
    Bytes(&'a [u8]),
    Owned(Vec<u8>),
    Vectors(Vec<Vec3>),
    Scalars(Vec<f32>),
}

impl Piece<'_> {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Owned(bytes) => bytes,
            Self::Vectors(vectors) => bytemuck::cast_slice(vectors),
            Self::Scalars(scalars) => bytemuck::cast_slice(scalars),
        }
    }
}

/// What a buffer view holds.
#[derive(Clone, Copy)]
pub(super) enum ViewKind {
    /// Vertex attributes, so many bytes apart.
    Vertices(usize),
    Indices,
    /// Pictures and animation data.
    Other,
}

#[derive(Default)]
pub(super) struct GlbBuilder<'a> {
    pieces: Vec<Piece<'a>>,
    length: usize,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl<'a> GlbBuilder<'a> {
    /// Appends a piece as a buffer view of its own and returns the view's index.
    pub(super) fn view(&mut self, piece: Piece<'a>, kind: ViewKind) -> usize {
        let length = piece.bytes().len();
        let mut view = json!({"buffer": 0, "byteOffset": self.length, "byteLength": length});
        match kind {
            ViewKind::Vertices(stride) => {
                view["byteStride"] = stride.into();
                view["target"] = ARRAY_BUFFER.into();
            }
            ViewKind::Indices => view["target"] = ELEMENT_ARRAY_BUFFER.into(),
            ViewKind::Other => {}
        }
        self.pieces.push(piece);
        self.length += length.next_multiple_of(4);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Adds an accessor and returns its index.
    pub(super) fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds an accessor over 32-bit floats and returns its index.
    pub(super) fn floats(&mut self, view: usize, offset: usize, count: usize, kind: &str) -> usize {
        self.accessor(json!({
            "bufferView": view, "byteOffset": offset, "componentType": FLOAT, "count": count, "type": kind
        }))
    }

    /// Adds an accessor over positions, which must state their bounds, and returns its index.
    pub(super) fn positions(&mut self, view: usize, offset: usize, count: usize, bounds: [Vec3; 2]) -> usize {
        let [min, max] = bounds.map(|corner| corner.to_array());
        self.accessor(json!({
            "bufferView": view, "byteOffset": offset, "componentType": FLOAT, "count": count,
            "type": "VEC3", "min": min, "max": max
        }))
    }

    /// The file: header, JSON chunk padded with spaces, binary chunk padded with zeros.
    pub(super) fn finish(self, mut root: Map<String, Value>) -> Result<Vec<u8>, WriteError> {
        root.insert("accessors".into(), self.accessors.into());
        root.insert("bufferViews".into(), self.views.into());
        root.insert("buffers".into(), json!([{"byteLength": self.length}]));
        let mut text = Value::Object(root).to_string();
        text.extend(std::iter::repeat_n(' ', text.len().next_multiple_of(4) - text.len()));
        let total = 12 + 8 + text.len() + 8 + self.length;
        let chunk = |length: usize| u32::try_from(length).map_err(|_| WriteError::TooLarge(total));
        let mut out = Vec::with_capacity(total);
        out.extend_from_slice(b"glTF");
        for word in [2, chunk(total)?, chunk(text.len())?] {
            out.extend_from_slice(&word.to_le_bytes());
        }
        out.extend_from_slice(b"JSON");
        out.extend_from_slice(text.as_bytes());
        out.extend_from_slice(&chunk(self.length)?.to_le_bytes());
        out.extend_from_slice(b"BIN\0");
        for piece in &self.pieces {
            out.extend_from_slice(piece.bytes());
            out.resize(out.len() + (piece.bytes().len().next_multiple_of(4) - piece.bytes().len()), 0);
        }
        Ok(out)
    }
}

/// Lowest and highest corner of the points.
pub(super) fn bounds(positions: &[Vec3]) -> Result<[Vec3; 2], WriteError> {
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::ZERO);
    // NaN passes through min and max unseen; times zero, NaN and infinity stay NaN.
    let (min, max, poison) =
        positions.iter().fold(start, |(min, max, poison), &p| (min.min(p), max.max(p), poison + p * 0.0));
    if poison.is_finite() && min.is_finite() {
        Ok([min, max])
    } else {
        Err(WriteError::NonFinite("positions"))
    }
}
