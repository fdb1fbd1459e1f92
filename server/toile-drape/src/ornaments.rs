//! Small loose pieces (bows, buttons, pockets) ride on the garment that carries them.
//!
//! Nothing sews them on, so a network of cloth would let them fall. A piece moves as the one point that carries it
//! does: rigidly. A small garment in several pieces (the knot and tails of a bow) is one. Training does the same
//! (`model/garment/ornaments.py`).

use std::collections::BTreeMap;

use glam::Vec3;
use toile_geometry::mesh::Adjacency;
use toile_geometry::nearest::PointTree;

use crate::graph::{OutfitGraph, components};
use crate::refine::Refined;

/// Pieces whose bounding box has a diagonal below this are small, metres.
const SMALL: f32 = 0.33;
/// A small piece is carried when some vertex of it lies this near to a larger one, metres.
const TOUCHES: f32 = 0.03;

/// Nodes of carried pieces, each with the vertex that carries it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Riders(Vec<(usize, usize)>);

impl Riders {
    /// The riders of a graph that was built on `fine`, cut from `rest` with edges `ring`; `garment` is that of each
    /// vertex.
    #[must_use]
    pub fn new(
        graph: &OutfitGraph,
        fine: &Refined,
        rest: &[Vec3],
        ring: &Adjacency,
        garment: &[u32],
    ) -> Self {
        let carrier = fine.spread(&carriers(rest, ring, garment));
        let nodes = graph.nodes.cluster_of.iter().zip(carrier);
        let mut riders: Vec<_> =
            nodes.filter_map(|(&node, carrier)| Some((node as usize, carrier? as usize))).collect();
        riders.sort_unstable();
        riders.dedup();
        Self(riders)
    }

    /// Gives the rows of riding nodes the values at their carriers. `values` is row-major, a row a node.
    pub fn carry(&self, graph: &OutfitGraph, values: &mut [f32]) {
        let width = values.len() / graph.nodes.positions.len().max(1);
        for &(node, carrier) in &self.0 {
            let mut row = vec![0.0; width];
            for (from, weight) in graph.vertex_from_node.row(carrier) {
                let there = values.get(from * width..(from + 1) * width).unwrap_or(&[]);
                row.iter_mut().zip(there).for_each(|(r, v)| *r += weight * v);
            }
            if let Some(place) = values.get_mut(node * width..(node + 1) * width) {
                place.copy_from_slice(&row);
            }
        }
    }
}

/// For every vertex of a carried piece the vertex of the larger pieces nearest to where the piece touches them
/// highest: from there it hangs.
fn carriers(rest: &[Vec3], ring: &Adjacency, garment: &[u32]) -> Vec<Option<u32>> {
    let mut out = vec![None; rest.len()];
    let (small, large): (Vec<_>, Vec<_>) =
        pieces(rest, ring, garment).into_iter().partition(|piece| is_small(rest, piece));
    let mut carries = vec![false; rest.len()];
    large.iter().flatten().for_each(|&v| carries[v] = true);
    let Some(tree) = PointTree::new(rest, |v| !small.is_empty() && carries[v]) else { return out };
    for piece in small {
        let hits = piece.iter().map(|&v| (rest[v].y, tree.nearest(rest[v])));
        let touching = hits.filter(|(_, hit)| hit.distance < TOUCHES);
        let hook = touching.min_by(|(y, a), (z, b)| z.total_cmp(y).then(a.distance.total_cmp(&b.distance)));
        if let Some((_, hit)) = hook {
            piece.into_iter().for_each(|v| out[v] = Some(hit.index));
        }
    }
    out
}

fn is_small(rest: &[Vec3], piece: &[usize]) -> bool {
    let low = piece.iter().map(|&v| rest[v]).fold(Vec3::INFINITY, Vec3::min);
    let high = piece.iter().map(|&v| rest[v]).fold(Vec3::NEG_INFINITY, Vec3::max);
    (high - low).length() < SMALL
}

/// Vertices of each connected piece of a garment; those of a small garment are one piece.
fn pieces(rest: &[Vec3], ring: &Adjacency, garment: &[u32]) -> Vec<Vec<usize>> {
    let mut by_garment: BTreeMap<u32, BTreeMap<u32, Vec<usize>>> = BTreeMap::new();
    for (v, (label, owner)) in components(garment, ring).into_iter().zip(garment).enumerate() {
        by_garment.entry(*owner).or_default().entry(label).or_default().push(v);
    }
    let joined = |pieces: BTreeMap<u32, Vec<usize>>| {
        let pieces: Vec<_> = pieces.into_values().collect();
        let all = pieces.concat();
        if is_small(rest, &all) { vec![all] } else { pieces }
    };
    by_garment.into_values().flat_map(joined).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of squares along x, `count` of 5 cm, at height `y`.
    fn strip(count: u32, y: f32, first: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let points = (0..2 * (count + 1)).map(|i| Vec3::new((i / 2) as f32 * 0.05, y, (i % 2) as f32 * 0.05));
        let faces = (0..count).flat_map(|c| {
            let i = first + 2 * c;
            [[i, i + 2, i + 1], [i + 1, i + 2, i + 3]]
        });
        (points.collect(), faces.collect())
    }

    #[test]
    fn a_small_piece_rides_on_the_large_one_near_it_and_a_far_one_does_not() {
        let (mut points, mut faces) = strip(12, 0.0, 0);
        for (y, near) in [(0.01, true), (0.2, false)] {
            let first = points.len() as u32;
            let (more, more_faces) = strip(2, y, first);
            points.extend(more);
            faces.extend(more_faces);
            let found = carriers(&points, &Adjacency::new(points.len(), &faces), &vec![0; points.len()]);
            assert!(found[..26].iter().all(Option::is_none));
            assert!(found[first as usize..].iter().all(|carrier| *carrier == near.then_some(0)));
        }
    }

    #[test]
    fn every_node_of_a_carried_piece_moves_as_its_carrier_does() {
        let (mut points, mut faces) = strip(12, 0.0, 0);
        let (more, more_faces) = strip(2, 0.01, 26);
        points.extend(more);
        faces.extend(more_faces);
        let fine = Refined::new(&points, &faces);
        let graph = OutfitGraph::new(&fine.positions, &fine.triangles, &vec![0; fine.positions.len()]);
        let ring = Adjacency::new(points.len(), &faces);
        let riders = Riders::new(&graph, &fine, &points, &ring, &vec![0; points.len()]);
        let mut values: Vec<f32> = graph.nodes.positions.iter().flat_map(|p| [p.x, p.y]).collect();
        riders.carry(&graph, &mut values);
        let expected = graph.vertex_from_node.blended(0, &graph.nodes.positions);
        for v in 26..points.len() {
            let node = graph.nodes.cluster_of[v] as usize;
            assert!(
                (values[2 * node] - expected.x).abs() < 1e-6
                    && (values[2 * node + 1] - expected.y).abs() < 1e-6
            );
        }
        let node = graph.nodes.cluster_of[24] as usize;
        assert_eq!(values[2 * node], graph.nodes.positions[node].x);
    }

    #[test]
    fn the_pieces_of_a_small_garment_ride_on_one_vertex() {
        let (mut points, mut faces) = strip(12, 0.0, 0);
        for first in [26, 32] {
            let (more, more_faces) = strip(2, 0.01, first);
            points.extend(more.iter().map(|p| *p + Vec3::X * (first - 26) as f32 * 0.02));
            faces.extend(more_faces);
        }
        let garment: Vec<u32> = (0..points.len()).map(|v| u32::from(v >= 26)).collect();
        let found = carriers(&points, &Adjacency::new(points.len(), &faces), &garment);
        assert!(found[26].is_some());
        assert!(found[26..].iter().all(|carrier| *carrier == found[26]));
    }
}
