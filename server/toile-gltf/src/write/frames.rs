//! Positions and normals of the frames: the first as attributes, the others as morph targets.

use std::ops::Range;

use glam::Vec3;
use serde_json::{Map, Value, json};

use super::error::check_length;
use super::glb::{GlbBuilder, Piece, ViewKind, bounds};
use super::{FrameView, OutfitTemplate, Scene, WriteError};

const VEC3_BYTES: usize = size_of::<Vec3>();

/// Morph targets of a mesh, one per frame after the first.
pub(super) type Morphs = Vec<Value>;
type Attributes = Map<String, Value>;
type PositionsAndNormals = (Vec<Vec3>, Vec<Vec3>);

/// Adds the outfit's vertices of every frame; attributes and morph targets of each garment.
pub(super) fn outfit_vertices(
    glb: &mut GlbBuilder<'_>,
    outfit: &OutfitTemplate,
    frames: &[FrameView<'_>],
    ranges: &[Range<usize>],
) -> Result<Vec<(Attributes, Morphs)>, WriteError> {
    let drawn: Vec<PositionsAndNormals> = frames
        .iter()
        .map(|frame| (gather(&outfit.vertex_of, frame.positions), gather(&outfit.vertex_of, frame.normals)))
        .collect();
    let mut meshes = mesh_vertices(glb, drawn, ranges)?;
    if let Some(first) = frames.first() {
        for (name, values) in [("_STRAIN", first.strain), ("_PENETRATION", first.penetration)] {
            add_scalars(glb, outfit, (name, values), &mut meshes)?;
        }
    }
    Ok(meshes)
}

fn add_scalars(
    glb: &mut GlbBuilder<'_>,
    outfit: &OutfitTemplate,
    (name, values): (&'static str, &[f32]),
    meshes: &mut [(Attributes, Morphs)],
) -> Result<(), WriteError> {
    if values.is_empty() {
        return Ok(());
    }
    check_length(name, outfit.welded_count, values.len())?;
    if !values.iter().all(|value| value.is_finite()) {
        return Err(WriteError::NonFinite(name));
    }
    let view = glb.view(Piece::Scalars(gather(&outfit.vertex_of, values)), ViewKind::Vertices(4));
    for (garment, (attributes, _)) in outfit.garments.iter().zip(meshes) {
        let accessor = glb.floats(view, garment.drawn.start * 4, garment.drawn.len(), "SCALAR");
        attributes.insert(name.into(), accessor.into());
    }
    Ok(())
}

fn gather<T: Copy + Default>(vertex_of: &[u32], welded: &[T]) -> Vec<T> {
    vertex_of.iter().map(|&vertex| welded.get(vertex as usize).copied().unwrap_or_default()).collect()
}

/// Adds positions and normals of every frame; attributes and morph targets for each range of vertices.
pub(super) fn mesh_vertices(
    glb: &mut GlbBuilder<'_>,
    frames: Vec<PositionsAndNormals>,
    ranges: &[Range<usize>],
) -> Result<Vec<(Attributes, Morphs)>, WriteError> {
    let mut frames = frames.into_iter();
    let Some((positions, normals)) = frames.next() else { return Err(WriteError::EmptyScene("no frames")) };
    let mut morphs = vec![Morphs::new(); ranges.len()];
    for (later_positions, later_normals) in frames {
        let deltas = (minus(later_positions, &positions), minus(later_normals, &normals));
        for (targets, target) in morphs.iter_mut().zip(add_vectors(glb, deltas, ranges)?) {
            targets.push(Value::Object(target));
        }
    }
    let attributes = add_vectors(glb, (positions, normals), ranges)?;
    Ok(attributes.into_iter().zip(morphs).collect())
}

fn minus(mut later: Vec<Vec3>, first: &[Vec3]) -> Vec<Vec3> {
    for (value, base) in later.iter_mut().zip(first) {
        *value -= *base;
    }
    later
}

/// `POSITION` and `NORMAL` accessors for each range.
fn add_vectors(
    glb: &mut GlbBuilder<'_>,
    (positions, normals): PositionsAndNormals,
    ranges: &[Range<usize>],
) -> Result<Vec<Attributes>, WriteError> {
    if !normals.iter().fold(Vec3::ZERO, |sum, n| sum + *n * 0.0).is_finite() {
        return Err(WriteError::NonFinite("normals"));
    }
    let corners: Result<Vec<_>, _> =
        ranges.iter().map(|range| bounds(positions.get(range.clone()).unwrap_or(&[]))).collect();
    let position_view = glb.view(Piece::Vectors(positions), ViewKind::Vertices(VEC3_BYTES));
    let normal_view = glb.view(Piece::Vectors(normals), ViewKind::Vertices(VEC3_BYTES));
    let mut attributes_of = |(range, corners): (&Range<usize>, [Vec3; 2])| {
        let (offset, count) = (range.start * VEC3_BYTES, range.len());
        let position = glb.positions(position_view, offset, count, corners);
        let normal = glb.floats(normal_view, offset, count, "VEC3");
        Attributes::from_iter([("POSITION".into(), position.into()), ("NORMAL".into(), normal.into())])
    };
    Ok(ranges.iter().zip(corners?).map(&mut attributes_of).collect())
}

/// One clip that shows frame k at time k ÷ rate: the weight of its morph target is 1 there.
pub(super) fn animation(glb: &mut GlbBuilder<'_>, scene: &Scene<'_>, node_count: usize) -> Value {
    let count = scene.frames.len();
    let times: Vec<f32> = (0..count).map(|k| k as f32 / scene.frame_rate).collect();
    let last = times.last().copied().unwrap_or(0.0);
    let targets = count - 1;
    let weights =
        (0..count * targets).map(|i| if i / targets == i % targets + 1 { 1.0 } else { 0.0 }).collect();
    let time_view = glb.view(Piece::Scalars(times), ViewKind::Other);
    let weight_view = glb.view(Piece::Scalars(weights), ViewKind::Other);
    let input = glb.accessor(json!({
        "bufferView": time_view, "componentType": 5126, "count": count, "type": "SCALAR", "min": [0.0], "max": [last]
    }));
    let output = glb.floats(weight_view, 0, count * targets, "SCALAR");
    let channels: Vec<Value> = (0..node_count)
        .map(|node| json!({"sampler": 0, "target": {"node": node, "path": "weights"}}))
        .collect();
    json!({
        "name": "motion",
        "samplers": [{"input": input, "output": output, "interpolation": "LINEAR"}],
        "channels": channels,
    })
}
