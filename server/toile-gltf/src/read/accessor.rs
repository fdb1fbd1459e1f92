//! Reads accessors in checked arithmetic (glTF 2.0, section 3.6.2): every component type, strides, sparse
//! substitution, accessors without data.

use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{self, Index, buffer};

use super::ReadError;
use super::document::Document;

/// How elements lie in the file.
#[derive(Clone, Copy, Debug)]
struct Layout {
    component: ComponentType,
    components: usize,
    count: usize,
}

impl Layout {
    fn element_size(self) -> usize {
        self.component.size() * self.components
    }
}

/// A checked run of elements.
#[derive(Clone, Copy, Debug)]
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    layout: Layout,
}

impl<'a> Elements<'a> {
    /// Element `i` as its components' bytes; empty beyond the end.
    fn get(&self, i: usize) -> &'a [u8] {
        let start = i.saturating_mul(self.stride);
        self.bytes.get(start..start.saturating_add(self.layout.element_size())).unwrap_or_default()
    }
}

/// Reads vectors of `N` floats; integers are divided by their largest value where the accessor is normalised.
pub(super) fn read_vectors<const N: usize>(
    document: &Document<'_>,
    index: Index<Accessor>,
    limit: usize,
) -> Result<Vec<[f32; N]>, ReadError> {
    let accessor = find(document, index)?;
    let layout = layout(accessor, index)?;
    if layout.components != N || multiplicity_is_matrix(accessor) {
        return Err(invalid(index, &format!("holds {} components where {N} are needed", layout.components)));
    }
    check_limit(layout.count, limit)?;
    let decode = |bytes: &[u8]| vector(bytes, layout.component, accessor.normalized);
    let mut out = vec![[0.0; N]; layout.count];
    if let Some(elements) = base_elements(document, accessor, index, layout)? {
        for (i, value) in out.iter_mut().enumerate() {
            *value = decode(elements.get(i));
        }
    }
    for (target, bytes) in substitutions(document, accessor, index, layout)? {
        if let Some(value) = out.get_mut(target) {
            *value = decode(bytes);
        }
    }
    Ok(out)
}

/// Reads unsigned scalars, such as triangle indices.
pub(super) fn read_indices(
    document: &Document<'_>,
    index: Index<Accessor>,
    limit: usize,
) -> Result<Vec<u32>, ReadError> {
    let accessor = find(document, index)?;
    let layout = layout(accessor, index)?;
    if layout.components != 1 || !is_unsigned(layout.component) {
        return Err(invalid(index, "does not hold unsigned integers, as indices must be"));
    }
    check_limit(layout.count, limit)?;
    let mut out = vec![0; layout.count];
    if let Some(elements) = base_elements(document, accessor, index, layout)? {
        for (i, value) in out.iter_mut().enumerate() {
            *value = unsigned(elements.get(i));
        }
    }
    for (target, bytes) in substitutions(document, accessor, index, layout)? {
        if let Some(value) = out.get_mut(target) {
            *value = unsigned(bytes);
        }
    }
    Ok(out)
}

fn find<'a>(document: &'a Document<'_>, index: Index<Accessor>) -> Result<&'a Accessor, ReadError> {
    document.root.accessors.get(index.value()).ok_or_else(|| invalid(index, "does not exist"))
}

fn layout(accessor: &Accessor, index: Index<Accessor>) -> Result<Layout, ReadError> {
    let (Checked::Valid(component), Checked::Valid(kind)) = (&accessor.component_type, &accessor.type_)
    else {
        return Err(invalid(index, "has an unknown type"));
    };
    let count = usize::try_from(accessor.count.0).map_err(|_| invalid(index, "has too many elements"))?;
    Ok(Layout { component: component.0, components: kind.multiplicity(), count })
}

fn multiplicity_is_matrix(accessor: &Accessor) -> bool {
    matches!(accessor.type_, Checked::Valid(Type::Mat2 | Type::Mat3 | Type::Mat4))
}

fn check_limit(count: usize, limit: usize) -> Result<(), ReadError> {
    if count > limit { Err(ReadError::too_large(count, "elements in an accessor", limit)) } else { Ok(()) }
}

/// The accessor's own data; none means zeros.
fn base_elements<'a>(
    document: &'a Document<'_>,
    accessor: &Accessor,
    index: Index<Accessor>,
    layout: Layout,
) -> Result<Option<Elements<'a>>, ReadError> {
    let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
    accessor.buffer_view.map(|view| elements(document, (view, offset), layout, index)).transpose()
}

fn elements<'a>(
    document: &'a Document<'_>,
    (view, offset): (Index<buffer::View>, u64),
    layout: Layout,
    index: Index<Accessor>,
) -> Result<Elements<'a>, ReadError> {
    let (bytes, stride) = document.view(view)?;
    let size = layout.element_size();
    let stride = stride.filter(|stride| *stride > 0).unwrap_or(size);
    if stride < size {
        return Err(invalid(index, &format!("has elements of {size} bytes {stride} bytes apart")));
    }
    let bytes = usize::try_from(offset).ok().and_then(|offset| bytes.get(offset..));
    let needed = match layout.count {
        0 => Some(0),
        count => (count - 1).checked_mul(stride).and_then(|before| before.checked_add(size)),
    };
    match (bytes, needed) {
        (Some(bytes), Some(needed)) if needed <= bytes.len() => Ok(Elements { bytes, stride, layout }),
        _ => Err(invalid(index, "reaches beyond its buffer view")),
    }
}

/// The sparse values: which element, and its new bytes.
fn substitutions<'a>(
    document: &'a Document<'_>,
    accessor: &Accessor,
    index: Index<Accessor>,
    layout: Layout,
) -> Result<Vec<(usize, &'a [u8])>, ReadError> {
    let Some(sparse) = &accessor.sparse else { return Ok(Vec::new()) };
    let count = usize::try_from(sparse.count.0).ok().filter(|count| *count <= layout.count);
    let count = count.ok_or_else(|| invalid(index, "has more sparse values than elements"))?;
    let Checked::Valid(component) = &sparse.indices.component_type else {
        return Err(invalid(index, "has sparse indices of an unknown type"));
    };
    let targets = Layout { component: component.0, components: 1, count };
    let targets =
        elements(document, (sparse.indices.buffer_view, sparse.indices.byte_offset.0), targets, index)?;
    let values = (sparse.values.buffer_view, sparse.values.byte_offset.0);
    let values = elements(document, values, Layout { count, ..layout }, index)?;
    (0..count)
        .map(|i| match unsigned(targets.get(i)) as usize {
            target if target < layout.count => Ok((target, values.get(i))),
            target => Err(ReadError::IndexOutOfRange {
                what: format!("a sparse index of accessors[{}]", index.value()),
                index: target as i64,
                count: layout.count,
            }),
        })
        .collect()
}

fn is_unsigned(component: ComponentType) -> bool {
    matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
}

/// A little-endian unsigned integer of up to four bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().take(4).rev().fold(0, |value, byte| value << 8 | u32::from(*byte))
}

fn vector<const N: usize>(bytes: &[u8], component: ComponentType, normalized: bool) -> [f32; N] {
    let mut out = [0.0; N];
    for (value, bytes) in out.iter_mut().zip(bytes.chunks_exact(component.size())) {
        *value = number(bytes, component, normalized);
    }
    out
}

/// One component; normalised integers after glTF 2.0, section 3.6.2.2.
fn number(bytes: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let raw = unsigned(bytes);
    let (value, largest) = match component {
        ComponentType::F32 => return f32::from_bits(raw),
        ComponentType::I8 => (f32::from(raw as u8 as i8), 127.0),
        ComponentType::U8 => (raw as f32, 255.0),
        ComponentType::I16 => (f32::from(raw as u16 as i16), 32_767.0),
        ComponentType::U16 => (raw as f32, 65_535.0),
        ComponentType::U32 => (raw as f32, 4_294_967_295.0),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}

fn invalid(index: Index<json::Accessor>, what: &str) -> ReadError {
    ReadError::InvalidAccessor(format!("accessors[{}] {what}", index.value()))
}
