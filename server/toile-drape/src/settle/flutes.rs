//! Flutes: the folds in which cloth hangs that is wider than what it hangs from.
//!
//! Where such folds lie is nearly chance, and a network that cannot tell answers with their mean: cloth without folds
//! that is too narrow. So each outfit has places for them, stripes along its fall that grow from noise by activation
//! nearby and inhibition further away (Turing, The Chemical Basis of Morphogenesis, 1952), and a drape folds there by as
//! much as it lacks in width.

use std::f32::consts::PI;

use glam::Vec3;

use crate::graph::{Links, NEIGHBOURS};

/// Width of a flute, crest to crest, metres.
const WIDTH: f32 = 0.16;
/// Distance along the fall over which stripes are in step, metres.
const FALL: f32 = 0.11;
/// Distance from which nodes do not act on each other, metres.
const REACH: f32 = 0.22;
/// Nodes that act on each other at most: around each, and in all together, so that crammed cloth takes no more time.
const AROUND: usize = 2000;
const IN_ALL: usize = 8_000_000;
/// Rounds of growth and how much each adds.
const ROUNDS: usize = 16;
const GROWTH: f32 = 3.0;
/// Distances to the skin or to other cloth between which flutes begin, metres.
const ROOM: (f32, f32) = (0.02, 0.06);
/// Share of its width that cloth lacks without folding, and the most that flutes take up.
const BUCKLING: f32 = 0.005;
const MOST: f32 = 0.25;
/// Rounds of averaging of what cloth lacks.
const SMOOTH: usize = 4;

/// Height of a flute at each node, from crest to trough 1 to -1; 0 where `room`, metres to the skin or to other cloth at
/// rest, leaves none. `nodes`: rest positions, metres.
#[must_use]
pub fn pattern(nodes: &[Vec3], near: &Links, vertex_from_node: &Links, room: &[f32]) -> Vec<f32> {
    let (ends, kernel) = kernel(nodes, near);
    let mut height: Vec<f32> = nodes.iter().map(|p| noise(*p)).collect();
    for _ in 0..ROUNDS {
        let mut start = 0;
        let act = |end: &usize| {
            let row = kernel.get(start..*end).unwrap_or(&[]);
            start = *end;
            let sum: f32 = row.iter().map(|(j, w)| w * height.get(*j as usize).copied().unwrap_or(0.0)).sum();
            (GROWTH * sum).tanh()
        };
        let grown = ends.iter().map(act).collect();
        height = grown;
    }
    let free = |room: &f32| ((room - ROOM.0) / (ROOM.1 - ROOM.0)).clamp(0.0, 1.0);
    height.iter_mut().zip(room).for_each(|(h, room)| *h *= free(room));
    // Vertices read a smoother field than the nodes', and half the square of a wave is its mean.
    let read = |v| vertex_from_node.row(v).map(|(n, w)| w * height[n]).sum::<f32>();
    let seen = |v| vertex_from_node.row(v).map(|(n, w)| w * free(&room[n])).sum::<f32>();
    let count = vertex_from_node.len();
    let (square, total) = (0..count).fold((0.0, 0.0), |(s, t), v| (s + read(v).powi(2), t + seen(v).powi(2)));
    let scale = if square > 0.0 { (0.5 * total / square).sqrt() } else { 0.0 };
    height.iter().map(|h| h * scale).collect()
}

/// How much each node is raised by those around it: up by those above and below, down by those half a flute away. Where
/// each row ends, and all rows in one list, which many small ones would leave holes in memory for.
fn kernel(nodes: &[Vec3], near: &Links) -> (Vec<usize>, Vec<(u32, f32)>) {
    let sigma = WIDTH / (2.0_f32.sqrt() * PI);
    let mut seen = vec![u32::MAX; nodes.len()];
    let mut row = |i: usize| {
        let act = |j: u32| {
            let between = nodes[j as usize] - nodes[i];
            let across = between.with_y(0.0).length_squared() / (sigma * sigma);
            let along = (between.y / FALL).powi(2);
            (j, (1.0 - across) * (-0.5 * (across + along)).exp())
        };
        let mut row: Vec<_> = around(i, nodes, near, &mut seen).into_iter().map(act).collect();
        let part = |sign: f32| row.iter().map(|r| (sign * r.1).max(0.0)).sum::<f32>().max(f32::MIN_POSITIVE);
        let (up, down) = (part(1.0), part(-1.0));
        row.iter_mut().for_each(|r| r.1 /= if r.1 > 0.0 { up } else { down });
        row
    };
    let (mut ends, mut all) = (Vec::new(), Vec::new());
    for i in 0..near.len().min(nodes.len()) {
        all.extend(row(i));
        ends.push(all.len());
    }
    (ends, all)
}

/// A node and those within reach that are linked to it through others within reach.
fn around(i: usize, nodes: &[Vec3], near: &Links, seen: &mut [u32]) -> Vec<u32> {
    let mut found = vec![i as u32];
    seen[i] = i as u32;
    let mut next = 0;
    let most = (IN_ALL / nodes.len().max(1)).clamp(NEIGHBOURS, AROUND);
    while let Some(&from) = found.get(next).filter(|_| found.len() < most) {
        for &to in near.targets(from as usize) {
            let t = to as usize;
            if seen[t] != i as u32 && nodes[t].distance_squared(nodes[i]) < REACH * REACH {
                seen[t] = i as u32;
                found.push(to);
            }
        }
        next += 1;
    }
    found
}

/// Between -1 and 1, the same for the same place.
fn noise(p: Vec3) -> f32 {
    let cell = (p / crate::graph::NODE_SIZE).floor().as_ivec3().to_array();
    let mut hash = 0x811c_9dc5_u32;
    for part in cell {
        hash = (hash ^ part as u32).wrapping_mul(0x7feb_352d);
        hash ^= hash >> 15;
    }
    hash as f32 / u32::MAX as f32 * 2.0 - 1.0
}

/// What the distances between pairs of nodes tell about the width that cloth lacks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Widths {
    /// How level each pair lies at rest: 1 along the ground, 0 upright.
    level: Vec<f32>,
    /// One over the pairs' lengths at rest, metres.
    per_length: Vec<f32>,
    /// One over what all pairs of each node count together.
    per_count: Vec<f32>,
}

impl Widths {
    /// Of `pairs` of nodes with these `lengths` on the body, metres; `nodes`: rest positions on the reference body.
    #[must_use]
    pub fn new(nodes: &[Vec3], pairs: &[[u32; 2]], lengths: &[f32]) -> Self {
        let level = |ends: &[u32; 2]| {
            let [a, b] = ends.map(|n| nodes[n as usize]);
            (b - a).with_y(0.0).length_squared() / (b - a).length_squared().max(f32::MIN_POSITIVE)
        };
        let level: Vec<f32> = pairs.iter().map(level).collect();
        let mut counts = vec![f32::MIN_POSITIVE; nodes.len()];
        for (ends, level) in pairs.iter().zip(&level) {
            ends.iter().for_each(|n| counts[*n as usize] += level * level);
        }
        let inverse = |value: &f32| 1.0 / value.max(f32::MIN_POSITIVE);
        let per_length = lengths.iter().map(inverse).collect();
        Self { level, per_length, per_count: counts.iter().map(inverse).collect() }
    }

    /// How high flutes rise at each of the nodes at `positions`, metres, in cloth whose `pairs` are shorter than at rest.
    /// A wave of width w and height a makes a line longer by (πa/w)².
    #[must_use]
    pub fn heights(&self, near: &Links, pairs: &[[u32; 2]], positions: &[Vec3]) -> Vec<f32> {
        let mut lack = vec![0.0_f32; self.per_count.len()];
        for ((ends, level), per_length) in pairs.iter().zip(&self.level).zip(&self.per_length) {
            let [a, b] = ends.map(|n| n as usize);
            let lacks = level * (1.0 - positions[a].distance(positions[b]) * per_length);
            lack[a] += lacks;
            lack[b] += lacks;
        }
        lack.iter_mut().zip(&self.per_count).for_each(|(sum, per_count)| *sum *= per_count);
        for _ in 0..SMOOTH {
            lack = lack.iter().enumerate().map(|(i, own)| 0.5 * (own + near.blended(i, &lack))).collect();
        }
        lack.iter().map(|l| WIDTH / PI * (l - BUCKLING).clamp(0.0, MOST).sqrt()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::OutfitGraph;
    use crate::test_meshes::tube;

    /// A tube of 20 cm radius, and its pattern with the same room everywhere.
    fn hanging(room: f32) -> (OutfitGraph, Vec<f32>) {
        let (positions, triangles) = tube(0.2, 0.6);
        let graph = OutfitGraph::new(&positions, &triangles, &vec![0; positions.len()]);
        let room = vec![room; graph.near.len()];
        let height = pattern(&graph.nodes.positions, &graph.near, &graph.vertex_from_node, &room);
        (graph, height)
    }

    #[test]
    fn flutes_run_along_the_fall_and_are_as_wide_as_they_should_be() {
        let (graph, height) = hanging(0.1);
        let nodes = &graph.nodes.positions;
        let mut ring: Vec<usize> = (0..nodes.len()).filter(|&n| (nodes[n].y - 0.31).abs() < 0.013).collect();
        ring.sort_by(|&a, &b| nodes[a].z.atan2(nodes[a].x).total_cmp(&nodes[b].z.atan2(nodes[b].x)));
        let changes = ring.windows(2).filter(|w| height[w[0]] * height[w[1]] < 0.0).count();
        let expected = 2.0 * std::f32::consts::TAU * 0.2 / WIDTH;
        assert!((0.6 * expected..1.4 * expected).contains(&(changes as f32)), "{changes} of {expected}");
        let above =
            |n: usize| (0..nodes.len()).find(|&m| (nodes[m] - nodes[n] - Vec3::Y * 0.05).length() < 0.015);
        let pairs: Vec<_> = (0..nodes.len()).filter_map(|n| Some((n, above(n)?))).collect();
        let same = pairs.iter().filter(|(n, m)| height[*n] * height[*m] > 0.0).count();
        assert!(same as f32 > 0.8 * pairs.len() as f32, "{same} of {}", pairs.len());
    }

    #[test]
    fn of_crammed_cloth_a_part_is_looked_at() {
        let count = AROUND + 1000;
        let index = (0..count as u32).map(|n| (n + 1) % count as u32).collect();
        let near = Links { width: 1, index, weight: vec![1.0; count] };
        let found = around(0, &vec![Vec3::ZERO; count], &near, &mut vec![u32::MAX; count]);
        assert_eq!(found.len(), AROUND);
    }

    #[test]
    fn cloth_on_the_skin_has_none() {
        assert!(hanging(0.01).1.iter().all(|h| *h == 0.0));
    }

    #[test]
    fn flutes_are_as_high_as_cloth_lacks_width() {
        let (graph, _) = hanging(0.1);
        let nodes = &graph.nodes.positions;
        let edges: Vec<[u32; 2]> = (0..graph.near.len())
            .flat_map(|n| graph.near.row(n).map(move |(m, _)| [n as u32, m as u32]))
            .collect();
        let length = |[a, b]: &[u32; 2]| nodes[*a as usize].distance(nodes[*b as usize]);
        let lengths: Vec<f32> = edges.iter().map(length).collect();
        let widths = Widths::new(nodes, &edges, &lengths);
        let squeezed = |share: f32| -> Vec<f32> {
            let at = |p: &Vec3| Vec3::new((1.0 - share) * p.x, p.y, (1.0 - share) * p.z);
            widths.heights(&graph.near, &edges, &nodes.iter().map(at).collect::<Vec<_>>())
        };
        let expected = WIDTH / PI * 0.2;
        let heights = squeezed(0.04 + BUCKLING);
        let mean = heights.iter().sum::<f32>() / heights.len() as f32;
        assert!((mean / expected - 1.0).abs() < 0.1, "{mean} {expected}");
        assert!(squeezed(-0.02).iter().all(|h| *h == 0.0));
    }
}
