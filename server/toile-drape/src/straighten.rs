//! Edges near their lengths, before cloth is moved out of anything: first between the nodes of the canonical graph, then
//! those of the mesh.
//!
//! What the networks have shortened thus buckles in folds of some centimetres, not triangle by triangle.

use glam::Vec3;

use crate::binding::CANDIDATES;
use crate::contact::Collider;
use crate::fitted::{Fitted, lengths};
use crate::folds;
use crate::graph::Links;
use crate::static_pass::StaticPass;
use crate::stretch::{draw_to_rest, interleaved};

/// How often the nodes' edges are drawn to their lengths.
const NODE_SWEEPS: usize = 6;
/// How often those of the mesh are, at least.
pub const FEWEST_SWEEPS: usize = 4;
/// At most.
const MOST_SWEEPS: usize = 20;
/// And how many in all: coarse meshes, where more of a drape's error shows in each edge, cost little.
const DRAWN: usize = 200_000;

/// The touching nodes of an outfit on one body shape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeEdges {
    /// The vertex that stands for each node; none where the mesh is coarser than the graph.
    vertex: Vec<Option<u32>>,
    /// What each vertex's links to nodes that have a vertex are to be multiplied by to sum to 1.
    share: Vec<f32>,
    /// Pairs of nodes, in the order of [`interleaved`].
    edges: Vec<[u32; 2]>,
    /// Their distances at rest, metres.
    lengths: Vec<f32>,
}

impl NodeEdges {
    /// Of an outfit with the given `rest` positions, welded order, metres.
    #[must_use]
    pub fn new(statics: &StaticPass, rest: &[Vec3]) -> Self {
        let vertex = vertex_of_node(&statics.vertex_from_node, statics.near.len());
        let stands = |node: usize| vertex.get(node).copied().flatten().is_some();
        let touching = (0..vertex.len()).filter(|&n| stands(n)).flat_map(|n| {
            let others = statics.near.row(n).map(|(m, _)| m).filter(move |&m| m != n);
            others.filter(|&m| stands(m)).map(move |m| [n.min(m) as u32, n.max(m) as u32])
        });
        let mut edges: Vec<_> = touching.collect();
        edges.sort_unstable();
        edges.dedup();
        let edges = interleaved(edges);
        let lengths = lengths(&at(&vertex, rest), &edges);
        let linked = |v| statics.vertex_from_node.row(v).filter(|(n, _)| stands(*n)).map(|(_, w)| w).sum();
        let share = (0..rest.len()).map(|v| 1.0 / f32::max(linked(v), 1e-6)).collect();
        Self { share, edges, lengths, vertex }
    }

    /// Draws the nodes' edges to their lengths and carries the vertices along.
    fn draw_to_rest(&self, statics: &StaticPass, crammed: &[bool], positions: &mut [Vec3]) {
        let before = self.at(positions);
        let mut nodes = before.clone();
        draw_to_rest(&mut nodes, &self.edges, &self.lengths, crammed, NODE_SWEEPS);
        nodes.iter_mut().zip(before).for_each(|(n, b)| *n -= b);
        self.carry(statics, &nodes, positions);
    }

    /// The vertex that stands for each node.
    #[must_use]
    pub fn vertices(&self) -> &[Option<u32>] {
        &self.vertex
    }

    /// What the nodes' vertices have of `values`, those of the vertices.
    #[must_use]
    pub fn at(&self, values: &[Vec3]) -> Vec<Vec3> {
        at(&self.vertex, values)
    }

    /// Moves the nodes' vertices, `at` their places, as [`Self::carry`] does, metres.
    pub fn carry_nodes(&self, statics: &StaticPass, moves: &[Vec3], at: &mut [Vec3]) {
        for (p, v) in at.iter_mut().zip(&self.vertex) {
            let Some(v) = v.map(|v| v as usize) else { continue };
            *p += statics.vertex_from_node.blended(v, moves) * self.share.get(v).copied().unwrap_or(0.0);
        }
    }

    /// Moves the vertices at `positions` with the nodes, metres.
    pub fn carry(&self, statics: &StaticPass, moves: &[Vec3], positions: &mut [Vec3]) {
        for (v, (p, share)) in positions.iter_mut().zip(&self.share).enumerate() {
            *p += statics.vertex_from_node.blended(v, moves) * *share;
        }
    }
}

/// The vertex that follows each of `count` nodes most.
pub(crate) fn vertex_of_node(vertex_from_node: &Links, count: usize) -> Vec<Option<u32>> {
    let mut best: Vec<(f32, Option<u32>)> = vec![(0.0, None); count];
    for v in 0..vertex_from_node.len() {
        for (node, weight) in vertex_from_node.row(v) {
            match best.get_mut(node) {
                Some(found) if weight > found.0 => *found = (weight, Some(v as u32)),
                _ => {}
            }
        }
    }
    best.into_iter().map(|(_, v)| v).collect()
}

/// Positions of the nodes' vertices, metres.
fn at(vertex: &[Option<u32>], positions: &[Vec3]) -> Vec<Vec3> {
    vertex.iter().map(|v| v.and_then(|v| positions.get(v as usize)).copied().unwrap_or_default()).collect()
}

/// How often the edges of a mesh that has so many are drawn to their lengths.
pub fn sweeps(edges: usize) -> usize {
    (DRAWN / edges.max(1)).clamp(FEWEST_SWEEPS, MOST_SWEEPS)
}

/// Draws world `positions` (welded order) towards the lengths that they have at rest on the same body, those of the mesh
/// some `sweeps` over.
pub fn straighten(
    statics: &StaticPass,
    fitted: &Fitted,
    body: &Collider<'_>,
    positions: &mut [Vec3],
    sweeps: usize,
) {
    let nodes = crammed_nodes(statics, body);
    fitted.node_edges.draw_to_rest(statics, &nodes, positions);
    let crammed = |v| statics.node_of(v).and_then(|node| nodes.get(node).copied()).unwrap_or(false);
    let crammed: Vec<bool> = (0..positions.len()).map(crammed).collect();
    draw_to_rest(positions, &statics.edges, &fitted.lengths, &crammed, sweeps);
}

/// Which nodes lie near a fold of the body.
fn crammed_nodes(statics: &StaticPass, body: &Collider<'_>) -> Vec<bool> {
    let folded = |v: &u32| body.facing.get(*v as usize).is_some_and(|other| *other != folds::NONE);
    statics.candidates.chunks(CANDIDATES).map(|near| near.iter().any(folded)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fitted::Coarse;
    use crate::graph::OutfitGraph;
    use crate::settle::Hanging;
    use crate::test_meshes::{limb, sheet};
    use toile_geometry::mesh::{Adjacency, edges};

    /// A sheet of 1 cm quads whose nodes all know the one vertex of a body.
    fn cloth() -> (StaticPass, Fitted) {
        let (rest, triangles) = sheet(40);
        let graph = OutfitGraph::new(&rest, &triangles, &vec![0; rest.len()]);
        let statics = StaticPass {
            candidates: vec![0; graph.nodes.positions.len() * CANDIDATES],
            edges: interleaved(edges(&triangles)),
            vertex_from_node: graph.vertex_from_node,
            near: graph.near,
            ..StaticPass::default()
        };
        let node_edges = NodeEdges::new(&statics, &rest);
        let lengths = lengths(&rest, &statics.edges);
        (
            statics,
            Fitted {
                rest,
                lengths,
                node_edges,
                hanging: Hanging::default(),
                coarse: Coarse::default(),
                sags: vec![],
            },
        )
    }

    /// Mean relative change of the edges of squeezed cloth before and after, near a body whose vertex faces `other`.
    fn change(other: u32) -> (f32, f32) {
        let (statics, fitted) = cloth();
        let squeezed = |p: &Vec3| Vec3::new(0.92 * p.x, 0.002 * (40.0 * p.x).sin(), p.z);
        let mut positions: Vec<Vec3> = fitted.rest.iter().map(squeezed).collect();
        let mean = |positions: &[Vec3]| {
            let now = lengths(positions, &statics.edges);
            now.iter().zip(&fitted.lengths).map(|(n, r)| (n / r - 1.0).abs()).sum::<f32>() / now.len() as f32
        };
        let (skin, ring) = ([Vec3::ZERO], Adjacency::new(1, &[]));
        let body = Collider { facing: &[other], ..limb(&skin, &skin, &ring) };
        let before = mean(&positions);
        straighten(&statics, &fitted, &body, &mut positions, sweeps(statics.edges.len()));
        (before, mean(&positions))
    }

    #[test]
    fn squeezed_cloth_gets_its_length_back_but_in_a_fold_of_the_body() {
        let (before, after) = change(folds::NONE);
        assert!(after < 0.7 * before, "{after} {before}");
        let (before, crammed) = change(0);
        assert!(crammed > 0.9 * before, "{crammed} {before}");
    }

    #[test]
    fn cloth_at_rest_stays() {
        let (statics, fitted) = cloth();
        let mut positions = fitted.rest.clone();
        let (skin, ring) = ([Vec3::ZERO], Adjacency::new(1, &[]));
        let body = limb(&skin, &skin, &ring);
        straighten(&statics, &fitted, &body, &mut positions, sweeps(statics.edges.len()));
        assert!(positions.iter().zip(&fitted.rest).all(|(p, q)| p.distance(*q) < 1e-6));
    }
}
