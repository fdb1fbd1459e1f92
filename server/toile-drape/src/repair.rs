//! Mending the rest pose: out of the body and out of the garments below, keeping folds and collars.

use glam::Vec3;
use toile_geometry::mesh::Adjacency;
use toile_geometry::nearest::PointTree;
use toile_geometry::normals::vertex_normals;

use crate::binding::{node_prior, vertex_weights};
use crate::graph::OutfitGraph;
use crate::outfit::Outfit;
use crate::push_out::{Field, followers, pushes};
use crate::reference::{Limb, ReferenceBody};

/// Distance that a mended rest pose keeps from the skin, metres.
const SKIN_GAP: f32 = 0.004;
/// Distance between layers, metres.
const LAYER_GAP: f32 = 0.0015;
/// An outer garment is only lifted off an inner one this near, metres.
const LAYER_REACH: f32 = 0.02;
const ROUNDS: usize = 8;

/// Moves every vertex of `positions` (rest space, welded order of `outfit`) out of the reference body, then
/// each garment out of the ones below it.
#[must_use]
pub fn repaired(outfit: &Outfit, positions: &[Vec3], reference: &ReferenceBody) -> Vec<Vec3> {
    let graph = OutfitGraph::new(positions, &outfit.triangles, &garment_of_vertex(outfit));
    let followers = followers(&graph.vertex_from_node, graph.near.len());
    let field = Field { vertex_from_node: &graph.vertex_from_node, near: &graph.near, followers: &followers };
    let limbs: Vec<Limb> = vertex_weights(&node_prior(&graph, reference), &graph.vertex_from_node)
        .iter()
        .map(|w| reference.limb(w))
        .collect();
    let mut out = positions.to_vec();
    let (mut skin, mut asked) = (vec![Vec3::ZERO; out.len()], vec![Vec3::NAN; out.len()]);
    for _ in 0..ROUNDS {
        for (((p, limb), need), asked) in out.iter().zip(&limbs).zip(&mut skin).zip(&mut asked) {
            // Most vertices stay where they were, and what they need is what they needed.
            if *p != std::mem::replace(asked, *p) {
                *need = skin_need(*p, *limb, reference);
            }
        }
        let layers = layer_needs(outfit, &out);
        if !apply(&mut out, &skin, &field) & !apply(&mut out, &layers, &field) {
            break;
        }
    }
    for (p, limb) in out.iter_mut().zip(&limbs) {
        *p += skin_need(*p, *limb, reference);
    }
    out
}

/// Garment index of every welded vertex.
#[must_use]
pub fn garment_of_vertex(outfit: &Outfit) -> Vec<u32> {
    let mut out = vec![0; outfit.positions.len()];
    for (i, garment) in outfit.garments.iter().enumerate() {
        let range = garment.vertices.start as usize..garment.vertices.end as usize;
        if let Some(slots) = out.get_mut(range) {
            slots.fill(i as u32);
        }
    }
    out
}

fn apply(positions: &mut [Vec3], need: &[Vec3], field: &Field<'_>) -> bool {
    let need = pushes(need);
    for (v, push) in field.spread(&need) {
        positions[v as usize] += push;
    }
    !need.is_empty()
}

fn skin_need(point: Vec3, limb: Limb, reference: &ReferenceBody) -> Vec3 {
    let hit = reference.touch[limb as usize].nearest(point).index as usize;
    match (reference.vertices.get(hit), reference.normals.get(hit)) {
        (Some(v), Some(n)) => *n * (SKIN_GAP - (point - *v).dot(*n)).max(0.0),
        _ => Vec3::ZERO,
    }
}

/// What the vertices of outer garments lack to lie over the inner ones near them.
fn layer_needs(outfit: &Outfit, positions: &[Vec3]) -> Vec<Vec3> {
    let mut out = vec![Vec3::ZERO; positions.len()];
    let normals = vertex_normals(positions, &outfit.triangles);
    for garment in outfit.garments.iter().filter(|g| g.layer > 0) {
        let below = |v: usize| {
            outfit.garments.iter().any(|g| g.layer < garment.layer && g.vertices.contains(&(v as u32)))
        };
        let Some(tree) = PointTree::new(positions, below) else { continue };
        for v in garment.vertices.clone().map(|v| v as usize) {
            let hit = tree.nearest(positions[v]);
            if hit.distance < LAYER_REACH {
                let (inner, normal) = (positions[hit.index as usize], normals[hit.index as usize]);
                out[v] = normal * (LAYER_GAP - (positions[v] - inner).dot(normal)).max(0.0);
            }
        }
    }
    out
}

/// Edges of the outfit as neighbours, for descent over inner garments.
#[must_use]
pub fn outfit_ring(outfit: &Outfit) -> Adjacency {
    Adjacency::new(outfit.positions.len(), &outfit.triangles)
}
