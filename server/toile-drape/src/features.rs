//! Body-relative input features of the graph's nodes. `rest` space on the reference body, metres.
//!
//! Training computes the same (`model/garment/features.py`).

use std::f32::consts::TAU;

use glam::Vec3;

use crate::binding::Weights;
use crate::graph::OutfitGraph;
use crate::reference::{GARMENT_JOINTS, ReferenceBody};

const WAVELENGTHS: [f32; 2] = [0.5, 0.2];
/// Features of a node.
pub const FEATURES: usize = 3 + 3 + 3 + 1 + 3 + 6 * WAVELENGTHS.len() + GARMENT_JOINTS + 1;

/// Features, row-major (nodes, [`FEATURES`]): position, cloth normal, body normal at the nearest body vertex,
/// signed distance and offset to it (decimetres, clipped), waves of the position, prior weights, layer.
#[must_use]
pub fn node_features(
    graph: &OutfitGraph,
    normals: &[Vec3],
    prior: &[Weights],
    layer: &[u32],
    reference: &ReferenceBody,
) -> Vec<f32> {
    let count = graph.nodes.positions.len();
    let (mut normal, mut node_layer) = (vec![Vec3::ZERO; count], vec![0; count]);
    for ((&node, n), &l) in graph.nodes.cluster_of.iter().zip(normals).zip(layer) {
        normal[node as usize] += *n;
        node_layer[node as usize] = l;
    }
    let mut out = Vec::with_capacity(count * FEATURES);
    for i in 0..count {
        let position = graph.nodes.positions[i];
        let hit = reference.clothed.nearest(position).index as usize;
        let (skin, outwards) = (reference.vertices[hit], reference.normals[hit]);
        let offset = position - skin;
        let centred = position - Vec3::Y;
        out.extend(centred.to_array());
        out.extend(normal[i].normalize_or_zero().to_array());
        out.extend(outwards.to_array());
        out.push((10.0 * offset.dot(outwards)).clamp(-1.0, 3.0));
        out.extend((10.0 * offset).to_array().map(|x| x.clamp(-3.0, 3.0)));
        for wavelength in WAVELENGTHS {
            let phase = (centred * (TAU / wavelength)).to_array();
            out.extend(phase.map(f32::sin));
            out.extend(phase.map(f32::cos));
        }
        out.extend(prior[i]);
        out.push(node_layer[i].min(3) as f32 / 3.0);
    }
    out
}
