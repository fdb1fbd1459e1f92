//! How an outfit holds on to the body: prior weights, collision candidates, other body shapes.
//!
//! `rest` space on the reference body, metres. Training computes the same tables (`model/garment/binding.py`).

use glam::Vec3;
use toile_geometry::nearest::Hit;

use crate::graph::{Links, OutfitGraph};
use crate::reference::{GARMENT_JOINTS, Limb, ReferenceBody};

/// Body vertices tested for collisions with the cloth of each node.
pub const CANDIDATES: usize = 16;
/// Candidates are spread over this many nearest body vertices.
const CANDIDATE_POOL: usize = 160;
/// Body vertices whose displacement a node follows to another shape.
pub const SHAPE_SUPPORTS: usize = 24;
const PRIOR_ROUNDS: usize = 80;

/// Skin weights over the garment joints.
pub type Weights = [f32; GARMENT_JOINTS];

/// Skin weights of the nearest body vertex, diffused over the graph where cloth is far from the skin.
///
/// `DeePSD` section 6 takes the nearest vertex and smooths; nearest alone tears skirts.
#[must_use]
pub fn node_prior(graph: &OutfitGraph, reference: &ReferenceBody) -> Vec<Weights> {
    let (start, hold): (Vec<Weights>, Vec<f32>) = graph
        .nodes
        .positions
        .iter()
        .map(|p| {
            let hit = reference.clothed.nearest(*p);
            let skin = reference.skin.get(hit.index as usize).copied().unwrap_or([0.0; GARMENT_JOINTS]);
            (skin, 0.5 * (-(hit.distance / 0.02).powi(2)).exp() + 0.004)
        })
        .unzip();
    let mut weights = start.clone();
    for _ in 0..PRIOR_ROUNDS {
        let next =
            (0..weights.len()).map(|i| diffused(i, &weights, &start[i], hold[i], &graph.near)).collect();
        weights = next;
    }
    for row in &mut weights {
        let sum: f32 = row.iter().sum();
        row.iter_mut().for_each(|w| *w /= sum.max(f32::MIN_POSITIVE));
    }
    weights
}

fn diffused(i: usize, weights: &[Weights], start: &Weights, hold: f32, near: &Links) -> Weights {
    let mut around = [0.0; GARMENT_JOINTS];
    let mut linked = false;
    for (j, share) in near.row(i) {
        linked = true;
        for (a, w) in around.iter_mut().zip(&weights[j]) {
            *a += share * w;
        }
    }
    let mut out = if linked { around } else { weights[i] };
    for (o, s) in out.iter_mut().zip(start) {
        *o = (hold * s + *o) / (hold + 1.0);
    }
    out
}

/// Interpolates node weights to vertices.
#[must_use]
pub fn vertex_weights(nodes: &[Weights], vertex_from_node: &Links) -> Vec<Weights> {
    (0..vertex_from_node.len())
        .map(|v| {
            let mut out = [0.0; GARMENT_JOINTS];
            for (node, share) in vertex_from_node.row(v) {
                for (o, w) in out.iter_mut().zip(&nodes[node]) {
                    *o += share * w;
                }
            }
            out
        })
        .collect()
}

/// Body vertices around each node: every tenth of the nearest ones that its limb may touch, as one table of
/// [`CANDIDATES`] a node, and the Gaussian average of the body's displacements that the node follows to
/// another shape, wider the farther it hangs. One search serves both.
#[must_use]
pub fn body_links(nodes: &[Vec3], limbs: &[Limb], reference: &ReferenceBody) -> (Vec<u32>, Links) {
    let mut candidates = Vec::with_capacity(nodes.len() * CANDIDATES);
    let rows = nodes.len() * SHAPE_SUPPORTS;
    let mut shape =
        Links { width: SHAPE_SUPPORTS, index: Vec::with_capacity(rows), weight: Vec::with_capacity(rows) };
    for (p, limb) in nodes.iter().zip(limbs) {
        let hits = reference.touch[*limb as usize].nearest_n(*p, CANDIDATE_POOL);
        let stride = CANDIDATE_POOL / CANDIDATES;
        let last = hits.last().map_or(0, |h| h.index);
        candidates.extend((0..CANDIDATES).map(|k| hits.get(k * stride).map_or(last, |h| h.index)));
        push_shape_row(&mut shape, &hits);
    }
    (candidates, shape)
}

fn push_shape_row(shape: &mut Links, hits: &[Hit]) {
    let least = hits.first().map_or(0.0, |h| h.distance);
    let spread = (0.5 * least).max(0.02);
    let start = shape.weight.len();
    for k in 0..SHAPE_SUPPORTS {
        let hit = hits.get(k * 3);
        shape.index.push(hit.map_or(0, |h| h.index));
        shape.weight.push(hit.map_or(0.0, |h| (-0.5 * ((h.distance - least) / spread).powi(2)).exp()));
    }
    let total: f32 = shape.weight[start..].iter().sum();
    shape.weight[start..].iter_mut().for_each(|w| *w /= total);
}
