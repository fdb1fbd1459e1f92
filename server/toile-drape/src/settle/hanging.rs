//! What of an outfit hangs on one body shape, and from where: clusters of the canonical graph's nodes, 5 cm wide.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::Vec3;
use toile_geometry::mesh::Adjacency;

use super::flutes::Widths;
use crate::fitted::lengths;
use crate::graph::components;
use crate::static_pass::StaticPass;
use crate::straighten::NodeEdges;

/// Distances to the skin or other cloth at rest between which cloth begins to fall, metres.
const FREE: (f32, f32) = (0.02, 0.06);
/// Height of what holds every piece of cloth at its top, metres: neckline or waistband.
const BAND: f32 = 0.04;
/// Share of the way that the end of an edge nearer to what holds it moves.
const HELD: f32 = 0.5;

/// A cluster that falls, as far as its tether lets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tether {
    pub cluster: u32,
    pub anchor: u32,
    /// Metres along the cloth.
    pub length: f32,
    /// Share of the fall that it takes part in.
    pub free: f32,
}

/// A pair of clusters of which one or both fall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Edge {
    pub ends: [u32; 2],
    /// Metres.
    pub length: f32,
    /// Shares of the way to its length, at each end.
    pub shares: [f32; 2],
}

/// What of an outfit hangs on one body shape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hanging {
    /// Nodes of each cluster that have a vertex.
    pub(super) members: Vec<Vec<u32>>,
    pub(super) tethers: Vec<Tether>,
    pub(super) edges: Vec<Edge>,
    widths: Widths,
}

impl Hanging {
    /// Of an outfit with the given `rest` positions, welded order, metres.
    #[must_use]
    pub fn new(statics: &StaticPass, rest: &[Vec3], nodes: &NodeEdges) -> Self {
        let tables = &statics.settle;
        let members = members(statics, nodes);
        let node_rest = nodes.at(rest);
        let free = free(statics, nodes, &members);
        let pairs = &tables.cluster_pairs;
        let lengths_of = lengths(&means(&members, &node_rest), pairs);
        let held = held_by(&free, pairs, &lengths_of);
        Self {
            edges: edges(&free, &held, pairs, &lengths_of),
            tethers: tethers(&free, &held),
            members,
            widths: Widths::new(&statics.nodes.positions, &tables.pairs, &lengths(&node_rest, &tables.pairs)),
        }
    }

    /// Whether nothing hangs.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.tethers.is_empty()
    }

    /// How far flutes rise at each of the nodes at `positions`, metres; below 0 they sink.
    #[must_use]
    pub fn flutes(&self, statics: &StaticPass, positions: &[Vec3]) -> Vec<f32> {
        let heights = self.widths.heights(&statics.near, &statics.settle.pairs, positions);
        heights.iter().zip(&statics.settle.flutes).map(|(height, pattern)| height * pattern).collect()
    }
}

/// The nodes of each cluster that have a vertex.
fn members(statics: &StaticPass, nodes: &NodeEdges) -> Vec<Vec<u32>> {
    let count = statics.settle.cluster_of.iter().max().map_or(0, |c| *c as usize + 1);
    let mut members = vec![vec![]; count];
    for (n, (cluster, vertex)) in statics.settle.cluster_of.iter().zip(nodes.vertices()).enumerate() {
        if vertex.is_some() {
            members[*cluster as usize].push(n as u32);
        }
    }
    members
}

/// The mean of each cluster's members' `values`.
pub(super) fn means(members: &[Vec<u32>], values: &[Vec3]) -> Vec<Vec3> {
    let mean = |nodes: &Vec<u32>| {
        nodes.iter().map(|n| values[*n as usize]).sum::<Vec3>() / nodes.len().max(1) as f32
    };
    members.iter().map(mean).collect()
}

/// How free each cluster is to fall: 0 near the skin and other cloth, in the topmost band of its piece and without members.
fn free(statics: &StaticPass, nodes: &NodeEdges, members: &[Vec<u32>]) -> Vec<f32> {
    let height = |c: usize| {
        let heights = members[c].iter().map(|n| statics.nodes.positions[*n as usize].y);
        heights.sum::<f32>() / members[c].len().max(1) as f32
    };
    let piece = pieces(members.len(), &statics.settle.cluster_pairs);
    let mut top = vec![f32::MIN; members.len()];
    for (c, piece) in piece.iter().enumerate().filter(|(c, _)| !members[*c].is_empty()) {
        let top = &mut top[*piece as usize];
        *top = top.max(height(c));
    }
    let clearance =
        |v: &Option<u32>| v.and_then(|v| statics.clearance.get(v as usize)).copied().unwrap_or(0.0);
    let mut room: Vec<f32> = nodes.vertices().iter().map(clearance).collect();
    statics.layers.narrow(&mut room, |v| statics.node_of(v));
    let of = |c: usize| {
        let mean = members[c].iter().map(|n| room[*n as usize]).sum::<f32>() / members[c].len().max(1) as f32;
        let below = height(c) < top[piece[c] as usize] - BAND;
        if below { ((mean - FREE.0) / (FREE.1 - FREE.0)).clamp(0.0, 1.0) } else { 0.0 }
    };
    (0..members.len()).map(of).collect()
}

/// The connected piece that each of `count` clusters belongs to.
fn pieces(count: usize, pairs: &[[u32; 2]]) -> Vec<u32> {
    let both = pairs.iter().flat_map(|[a, b]| [(*a, *b), (*b, *a)]).collect();
    components(&vec![(); count], &Adjacency::from_pairs(count, both))
}

/// Where a cluster hangs from: the nearest one along the cloth that does not fall, and the way to it, metres.
type Held = Option<(u32, f32)>;

/// What holds each cluster (Dijkstra); none where nothing does.
fn held_by(free: &[f32], pairs: &[[u32; 2]], lengths: &[f32]) -> Vec<Held> {
    let mut links: Vec<Vec<(u32, f32)>> = vec![vec![]; free.len()];
    for ([a, b], length) in pairs.iter().zip(lengths) {
        links[*a as usize].push((*b, *length));
        links[*b as usize].push((*a, *length));
    }
    let mut found: Vec<Held> =
        free.iter().enumerate().map(|(c, free)| (*free == 0.0).then_some((c as u32, 0.0))).collect();
    // Lengths are positive, so their bits are in their order.
    let fixed = (0..free.len()).filter(|c| free[*c] == 0.0);
    let mut next: BinaryHeap<_> = fixed.map(|c| (Reverse(0_u32), c as u32)).collect();
    while let Some((Reverse(bits), c)) = next.pop() {
        let Some((anchor, way)) = found[c as usize].filter(|(_, way)| way.to_bits() == bits) else {
            continue;
        };
        for (to, length) in &links[c as usize] {
            let way = way + length;
            if found[*to as usize].is_none_or(|(_, known)| way < known) {
                found[*to as usize] = Some((anchor, way));
                next.push((Reverse(way.to_bits()), *to));
            }
        }
    }
    found
}

fn tethers(free: &[f32], held: &[Held]) -> Vec<Tether> {
    let tether = |(c, (held, free)): (usize, (&Held, &f32))| {
        let (anchor, length) = (*held)?;
        (*free > 0.0).then_some(Tether { cluster: c as u32, anchor, length, free: *free })
    };
    held.iter().zip(free).enumerate().filter_map(tether).collect()
}

fn edges(free: &[f32], held: &[Held], pairs: &[[u32; 2]], lengths: &[f32]) -> Vec<Edge> {
    let edge = |(ends, length): (&[u32; 2], &f32)| {
        let [a, b] = ends.map(|c| held[c as usize].map(|(_, way)| (way, free[c as usize])));
        let ((a, mut x), (b, mut y)) = (a?, b?);
        *(if a < b { &mut x } else { &mut y }) *= HELD;
        let sum = x + y;
        (sum > 0.0).then(|| Edge { ends: *ends, length: *length, shares: [x / sum, y / sum] })
    };
    pairs.iter().zip(lengths).filter_map(edge).collect()
}
