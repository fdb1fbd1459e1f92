//! Pushing cloth out of a surface as a smooth field, so that it neither tears nor spikes.
//!
//! What each vertex needs is gathered on the 2.5 cm nodes of the canonical graph, spread over their
//! neighbours and interpolated back: folds and ornaments smaller than a node move as one.

use glam::Vec3;
use toile_geometry::mesh::Adjacency;
use toile_geometry::nearest::descend;

use crate::graph::Links;

/// A surface that cloth stays outside of.
#[derive(Clone, Copy)]
pub struct Collider<'a> {
    /// Vertices in the space of the cloth, metres.
    pub vertices: &'a [Vec3],
    /// Unit vertex normals, outwards.
    pub normals: &'a [Vec3],
    /// Edges of the surface.
    pub ring: &'a Adjacency,
}

impl Collider<'_> {
    /// Signed distance of `point` along the normal of its nearest vertex, and that normal.
    #[must_use]
    pub fn clearance(&self, point: Vec3, candidates: &[u32]) -> (f32, Vec3) {
        let hit = descend(point, self.vertices, candidates, self.ring) as usize;
        match (self.vertices.get(hit), self.normals.get(hit)) {
            (Some(v), Some(n)) => ((point - *v).dot(*n), *n),
            _ => (f32::INFINITY, Vec3::Y),
        }
    }
}

/// The smooth field that pushes are spread over.
#[derive(Clone, Copy)]
pub struct Field<'a> {
    /// Vertices from nodes.
    pub vertex_from_node: &'a Links,
    /// Touching nodes.
    pub near: &'a Links,
}

/// Share of a neighbour's push that a node without need of its own follows.
const FOLLOW: f32 = 0.75;
const SPREADS: usize = 3;
/// Rounds of averaging of a smoothed field.
const RELAXATIONS: usize = 6;

impl Field<'_> {
    /// Spreads the pushes that single vertices need, (vertices,) metres, over the cloth around them.
    #[must_use]
    pub fn spread(&self, need: &[Vec3]) -> Vec<Vec3> {
        self.read(&self.gather(need), need.len())
    }

    /// A field over vertices averaged on the nodes, relaxed over their neighbours, and read back.
    #[must_use]
    pub fn smoothed(&self, values: &[Vec3]) -> Vec<Vec3> {
        let count = self.near.len();
        let (mut sums, mut shares) = (vec![Vec3::ZERO; count], vec![0.0_f32; count]);
        for (v, value) in values.iter().enumerate() {
            for (node, weight) in self.vertex_from_node.row(v) {
                sums[node] += *value * weight;
                shares[node] += weight;
            }
        }
        let mut nodes: Vec<Vec3> = sums.iter().zip(&shares).map(|(s, w)| *s / w.max(1e-12)).collect();
        for _ in 0..RELAXATIONS {
            let relaxed = (0..count).map(|i| {
                let (around, linked) =
                    self.near.row(i).fold((Vec3::ZERO, 0.0), |(s, t), (j, w)| (s + nodes[j] * w, t + w));
                nodes[i] * (1.0 - 0.5 * linked) + around * 0.5
            });
            nodes = relaxed.collect();
        }
        self.read(&nodes, values.len())
    }

    fn read(&self, nodes: &[Vec3], vertices: usize) -> Vec<Vec3> {
        let value = |v: usize| {
            self.vertex_from_node.row(v).map(|(n, w)| nodes[n] * w).fold(Vec3::ZERO, |sum, x| sum + x)
        };
        (0..vertices).map(value).collect()
    }

    /// Mean need of each node's vertices, weighted towards the largest, then passed on to its neighbours.
    fn gather(&self, need: &[Vec3]) -> Vec<Vec3> {
        let count = self.near.len();
        let (mut sums, mut shares) = (vec![Vec3::ZERO; count], vec![0.0_f32; count]);
        for (v, push) in need.iter().enumerate().filter(|(_, p)| **p != Vec3::ZERO) {
            let size = push.length();
            for (node, weight) in self.vertex_from_node.row(v) {
                sums[node] += *push * (weight * size);
                shares[node] += weight * size;
            }
        }
        let wanted = |i: usize| if shares[i] > 0.0 { sums[i] / shares[i] } else { Vec3::ZERO };
        let mut field: Vec<Vec3> = (0..count).map(wanted).collect();
        for _ in 0..SPREADS {
            let next = (0..count)
                .map(|i| {
                    let around = self.near.row(i).fold(Vec3::ZERO, |s, (j, w)| s + field[j] * w) * FOLLOW;
                    if around.length_squared() > field[i].length_squared() { around } else { field[i] }
                })
                .collect();
            field = next;
        }
        field
    }
}
