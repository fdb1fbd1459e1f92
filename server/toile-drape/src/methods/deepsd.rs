//! `DeePSD` (Bertiche et al. 2021) with a static basis: equation 4 with psi = basis x coefficients.

use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use toile_geometry::body::BodyShape;

use super::{Method, Placement, Wearer};
use crate::binding::{Weights, vertex_weights};
use crate::error::DrapeError;
use crate::features::FEATURES;
use crate::graph::OutfitGraph;
use crate::network::{Networks, Tensor, TensorRef};
use crate::ornaments::Riders;
use crate::reference::GARMENT_JOINTS;
use crate::static_pass::{Rig, largest_influences};

/// Basis vectors of a vertex.
pub const BASIS: usize = 64;
/// Pose features: a relative rotation and a gravity direction a joint.
pub const POSE: usize = GARMENT_JOINTS * 12;
/// Frames in one run of the network; a chunk's product stays in the cache.
const CHUNK: usize = 48;

/// `DeePSD` in its basis form.
pub struct Deepsd;

impl Method for Deepsd {
    fn dynamic_pass<'s>(
        &self,
        wearer: &Wearer<'s>,
        networks: &mut dyn Networks,
    ) -> Result<Placement<'s>, DrapeError> {
        let statics = wearer.statics;
        // On the nodes, which are fewer than the vertices of a fine mesh; everything after is linear.
        let width = 3 * statics.near.len();
        let shape = shape_features(wearer.shape);
        let mut offsets = Vec::with_capacity(wearer.transforms.len() * 3 * statics.rest.len());
        for frames in wearer.transforms.chunks(CHUNK) {
            let pose: Vec<f32> = frames.iter().flat_map(|f| pose_features(f, wearer.parents)).collect();
            let answer = networks.run(
                "deepsd/dynamic",
                &[
                    ("pose", TensorRef::F32(&[frames.len(), POSE], &pose)),
                    ("shape", TensorRef::F32(&[1, shape.len()], &shape)),
                    ("basis", TensorRef::F32(&[BASIS, width], &statics.rig.basis)),
                ],
            )?;
            let nodes = only("deepsd/dynamic", answer, frames.len() * width)?;
            for frame in nodes.chunks_exact(width.max(1)) {
                let at: Vec<Vec3> = frame.as_chunks::<3>().0.iter().map(|o| Vec3::from_array(*o)).collect();
                let vertices = 0..statics.rest.len();
                offsets.extend(vertices.flat_map(|v| statics.vertex_from_node.blended(v, &at).to_array()));
            }
        }
        Ok(Placement::Rest { offsets, joints: &statics.rig.joints, weights: &statics.rig.weights })
    }
}

/// Phi, Omega and Psi over the graph, interpolated to vertices.
///
/// # Errors
/// When the network fails or answers with an unexpected shape.
pub fn static_pass(
    graph: &OutfitGraph,
    features: &[f32],
    prior: &[Weights],
    riders: &Riders,
    networks: &mut dyn Networks,
) -> Result<Rig, DrapeError> {
    let nodes = prior.len();
    let [mut weights, mut basis, mut descriptors] = run_static(graph, features, prior, networks)?;
    let mut prior = prior.to_vec();
    let tables = [&mut weights.values, &mut basis.values, &mut descriptors.values];
    tables.into_iter().for_each(|values| riders.carry(graph, values));
    riders.carry(graph, prior.as_flattened_mut());
    let rows: Vec<Weights> =
        weights.values.chunks_exact(GARMENT_JOINTS).filter_map(|r| r.try_into().ok()).collect();
    if rows.len() != nodes || basis.values.len() != nodes * 3 * BASIS {
        let (expected, found) =
            (nodes * (GARMENT_JOINTS + 3 * BASIS), weights.values.len() + basis.values.len());
        return Err(DrapeError::Answer { graph: "deepsd/static".to_owned(), expected, found });
    }
    let (joints, weights) = largest_influences(&vertex_weights(&rows, &graph.vertex_from_node));
    let (prior_joints, prior_weights) = largest_influences(&vertex_weights(&prior, &graph.vertex_from_node));
    Ok(Rig {
        joints,
        weights,
        prior_joints,
        prior_weights,
        basis: rows_of_basis(&basis.values),
        descriptors: descriptors.values,
    })
}

fn run_static(
    graph: &OutfitGraph,
    features: &[f32],
    prior: &[Weights],
    networks: &mut dyn Networks,
) -> Result<[Tensor; 3], DrapeError> {
    let tables = [
        ("near", "near_weight", &graph.near),
        ("members", "members_weight", &graph.members),
        ("patch_near", "patch_near_weight", &graph.patch_near),
        ("node_from_patch", "node_from_patch_weight", &graph.node_from_patch),
    ];
    let indices: Vec<Vec<i64>> =
        tables.iter().map(|(_, _, l)| l.index.iter().map(|&i| i64::from(i)).collect()).collect();
    let shapes: Vec<[usize; 2]> = tables.iter().map(|(_, _, l)| [l.len(), l.width]).collect();
    let node_shape = [prior.len(), FEATURES];
    let prior_shape = [prior.len(), GARMENT_JOINTS];
    let mut inputs = vec![
        ("features", TensorRef::F32(&node_shape, features)),
        ("prior", TensorRef::F32(&prior_shape, prior.as_flattened())),
    ];
    for (((name, weight_name, links), index), shape) in tables.iter().zip(&indices).zip(&shapes) {
        inputs.push((name, TensorRef::I64(shape, index)));
        inputs.push((weight_name, TensorRef::F32(shape, &links.weight)));
    }
    let answer = networks.run("deepsd/static", &inputs)?;
    let found = answer.len();
    answer.try_into().map_err(|_| DrapeError::Answer {
        graph: "deepsd/static".to_owned(),
        expected: 3,
        found,
    })
}

/// Basis (nodes, 3, BASIS) as (BASIS, 3 x nodes), the layout of the dynamic product.
fn rows_of_basis(nodes: &[f32]) -> Vec<f32> {
    let width = nodes.len() / BASIS;
    let mut out = vec![0.0; nodes.len()];
    for (column, values) in nodes.chunks_exact(BASIS).enumerate() {
        for (r, value) in values.iter().enumerate() {
            out[r * width + column] = *value;
        }
    }
    out
}

/// The only output of a graph, checked for its size.
///
/// # Errors
/// When the network answered something else.
pub fn only(graph: &str, answer: Vec<Tensor>, expected: usize) -> Result<Vec<f32>, DrapeError> {
    let values = answer.into_iter().next().map(|t| t.values).unwrap_or_default();
    if values.len() == expected {
        return Ok(values);
    }
    Err(DrapeError::Answer { graph: graph.to_owned(), expected, found: values.len() })
}

/// Pose features of one frame, zero in the A-pose: for each joint its rotation relative to its parent minus
/// the identity (9, row-major) and the direction of gravity in its frame minus that at rest (3).
#[must_use]
pub fn pose_features(transforms: &[Affine3A], parents: &[Option<usize>]) -> Vec<f32> {
    let mut out = Vec::with_capacity(POSE);
    for (joint, transform) in transforms.iter().enumerate() {
        let rotation = transform.matrix3;
        let parent = parents.get(joint).copied().flatten().and_then(|p| transforms.get(p));
        let local = parent.map_or(rotation, |p| p.matrix3.transpose() * rotation);
        let change =
            Mat3A::from_cols(local.x_axis - Vec3A::X, local.y_axis - Vec3A::Y, local.z_axis - Vec3A::Z);
        out.extend(change.transpose().to_cols_array());
        out.extend((rotation.transpose() * Vec3A::NEG_Y - Vec3A::NEG_Y).to_array());
    }
    out
}

/// Shape features, zero for the reference body: phenotypes less their default, doubled; local changes.
#[must_use]
pub fn shape_features(shape: &BodyShape) -> Vec<f32> {
    let reference = BodyShape::default();
    let phenotypes = shape.phenotypes.iter().zip(&reference.phenotypes).map(|(p, r)| 2.0 * (p - r));
    phenotypes.chain(shape.local_changes).collect()
}
