//! The canonical graph of an outfit: nodes of a fixed size, whatever the mesh's resolution.
//!
//! The network runs on clusters of vertices, so that the same outfit gives the same answer at a quarter or
//! four times the vertices. A cluster is a connected piece of one garment inside one cell of a grid. Two
//! levels: nodes (2.5 cm) and patches (10 cm). `rest` space, metres. Training builds the same graph
//! (`model/garment/graph.py`).

use std::ops::{Add, Mul};

use glam::Vec3;
use toile_geometry::mesh::Adjacency;

/// Size of a node's cell, metres.
pub const NODE_SIZE: f32 = 0.025;
/// Size of a patch's cell, metres.
pub const PATCH_SIZE: f32 = 0.10;
/// Neighbours kept for a node or a patch.
pub const NEIGHBOURS: usize = 8;
/// Nodes kept for a patch.
pub const MEMBERS: usize = 16;
/// Clusters that a point is interpolated from.
pub const SUPPORTS: usize = 8;
/// Radius of the interpolation kernel in cluster sizes.
const KERNEL: f32 = 2.0;

/// One level of clustering of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clusters {
    /// Mean position of the members, metres.
    pub positions: Vec<Vec3>,
    /// Cluster of each point.
    pub cluster_of: Vec<u32>,
    /// Clusters that touch each cluster.
    pub touching: Adjacency,
    /// Garment of each cluster.
    pub garment: Vec<u32>,
}

/// A padded table of weighted links, `width` a row: padding repeats the first entry with weight 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Links {
    /// Entries a row.
    pub width: usize,
    /// Targets, row-major.
    pub index: Vec<u32>,
    /// Weights, row-major; a row sums to 1, or to 0 when it has no links.
    pub weight: Vec<f32>,
}

impl Links {
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.index.len().checked_div(self.width).unwrap_or(0)
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// The targets of one row, padding included.
    #[must_use]
    pub fn targets(&self, i: usize) -> &[u32] {
        self.index.get(i * self.width..(i + 1) * self.width).unwrap_or(&[])
    }

    /// The target of a row with the largest weight: rows are sorted by it.
    #[must_use]
    pub fn nearest(&self, i: usize) -> Option<usize> {
        self.targets(i).first().map(|t| *t as usize)
    }

    /// The links of one row with weight above zero.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f32)> {
        let range = i * self.width..(i + 1) * self.width;
        let index = self.index.get(range.clone()).unwrap_or(&[]);
        let weight = self.weight.get(range).unwrap_or(&[]);
        index.iter().zip(weight).filter(|(_, w)| **w > 0.0).map(|(i, w)| (*i as usize, *w))
    }

    /// The weighted sum of the targets' `values` of one row.
    #[must_use]
    pub fn blended<T>(&self, i: usize, values: &[T]) -> T
    where
        T: Copy + Default + Add<Output = T> + Mul<f32, Output = T>,
    {
        // Padding has weight 0: cheaper to add than to leave out.
        let weight = self.weight.get(i * self.width..(i + 1) * self.width).unwrap_or(&[]);
        let links = self.targets(i).iter().zip(weight);
        links
            .fold(T::default(), |sum, (t, w)| sum + values.get(*t as usize).copied().unwrap_or_default() * *w)
    }

    /// Drops all rows but the first `rows`.
    pub fn keep(&mut self, rows: usize) {
        self.index.truncate(rows * self.width);
        self.weight.truncate(rows * self.width);
    }

    fn push(&mut self, row: &[(u32, f32)]) {
        let first = row.first().map_or(0, |r| r.0);
        for k in 0..self.width {
            let (index, weight) = row.get(k).copied().unwrap_or((first, 0.0));
            self.index.push(index);
            self.weight.push(weight);
        }
    }

    fn with_capacity(width: usize, rows: usize) -> Self {
        Self { width, index: Vec::with_capacity(width * rows), weight: Vec::with_capacity(width * rows) }
    }
}

/// The two levels and every table that the network gathers through.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutfitGraph {
    /// Clusters of vertices.
    pub nodes: Clusters,
    /// Clusters of nodes.
    pub patches: Clusters,
    /// Node to touching nodes.
    pub near: Links,
    /// Patch to its nodes.
    pub members: Links,
    /// Patch to touching patches.
    pub patch_near: Links,
    /// Node to the patches around it.
    pub node_from_patch: Links,
    /// Vertex to the nodes around it.
    pub vertex_from_node: Links,
}

impl OutfitGraph {
    /// Builds the graph of welded vertices in rest space; `garment` gives the garment of each vertex.
    #[must_use]
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]], garment: &[u32]) -> Self {
        let mesh = Adjacency::new(positions.len(), triangles);
        let nodes = cluster(positions, &mesh, garment, NODE_SIZE);
        let patches = cluster(&nodes.positions, &nodes.touching, &nodes.garment, PATCH_SIZE);
        let mut lists = vec![Vec::new(); patches.positions.len()];
        for (node, &patch) in patches.cluster_of.iter().enumerate() {
            if let Some(list) = lists.get_mut(patch as usize) {
                list.push(node as u32);
            }
        }
        let member_lists = |p: usize| lists.get(p).map_or(&[] as &[u32], Vec::as_slice);
        Self {
            near: nearest_linked(&nodes.positions, |i| nodes.touching.of(i), &nodes.positions, NEIGHBOURS),
            members: nearest_linked(&patches.positions, member_lists, &nodes.positions, MEMBERS),
            patch_near: nearest_linked(
                &patches.positions,
                |i| patches.touching.of(i),
                &patches.positions,
                NEIGHBOURS,
            ),
            node_from_patch: interpolation(&nodes.positions, &patches, PATCH_SIZE),
            vertex_from_node: interpolation(positions, &nodes, NODE_SIZE),
            nodes,
            patches,
        }
    }
}

/// Connected pieces of one garment inside one grid cell.
pub(crate) fn cluster(points: &[Vec3], links: &Adjacency, garment: &[u32], size: f32) -> Clusters {
    let cells: Vec<(glam::IVec3, u32)> =
        points.iter().zip(garment).map(|(p, &g)| ((*p / size).floor().as_ivec3(), g)).collect();
    let cluster_of = components(&cells, links);
    let count = cluster_of.iter().max().map_or(0, |m| *m as usize + 1);
    let (mut sums, mut members, mut owner) = (vec![Vec3::ZERO; count], vec![0_u32; count], vec![0; count]);
    for ((&c, p), &g) in cluster_of.iter().zip(points).zip(garment) {
        sums[c as usize] += *p;
        members[c as usize] += 1;
        owner[c as usize] = g;
    }
    let mut pairs = Vec::new();
    for (v, &from) in cluster_of.iter().enumerate() {
        pairs.extend(links.of(v).iter().map(|&w| (from, cluster_of[w as usize])).filter(|(a, b)| a != b));
    }
    Clusters {
        positions: sums.iter().zip(&members).map(|(s, &n)| *s / n as f32).collect(),
        touching: Adjacency::from_pairs(count, pairs),
        cluster_of,
        garment: owner,
    }
}

/// Labels of the connected pieces of equal cells, numbered in order of their first point.
pub(crate) fn components<C: PartialEq>(cells: &[C], links: &Adjacency) -> Vec<u32> {
    let mut label = vec![u32::MAX; cells.len()];
    let (mut next, mut stack) = (0, Vec::new());
    for seed in 0..cells.len() {
        if label[seed] != u32::MAX {
            continue;
        }
        label[seed] = next;
        stack.push(seed);
        while let Some(v) = stack.pop() {
            for &w in links.of(v) {
                let w = w as usize;
                if label[w] == u32::MAX && cells[w] == cells[seed] {
                    label[w] = next;
                    stack.push(w);
                }
            }
        }
        next += 1;
    }
    label
}

/// For each origin the `width` nearest of its linked targets, with equal weights.
fn nearest_linked<'a>(
    origins: &[Vec3],
    linked: impl Fn(usize) -> &'a [u32],
    targets: &[Vec3],
    width: usize,
) -> Links {
    let mut out = Links::with_capacity(width, origins.len());
    for (i, origin) in origins.iter().enumerate() {
        let mut row: Vec<(u32, f32)> =
            linked(i).iter().map(|&t| (t, origin.distance(targets[t as usize]))).collect();
        row.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        row.truncate(width);
        let share = 1.0 / row.len().max(1) as f32;
        row.iter_mut().for_each(|r| r.1 = share);
        out.push(&row);
    }
    out
}

/// Partition-of-unity weights of the clusters around each point: kernel (1 - (d / radius)^2)^2 over the
/// point's own cluster and the two rings around it.
pub(crate) fn interpolation(points: &[Vec3], clusters: &Clusters, size: f32) -> Links {
    let mut out = Links::with_capacity(SUPPORTS, points.len());
    let reach: Vec<Vec<u32>> =
        (0..clusters.positions.len()).map(|c| two_rings(c, &clusters.touching)).collect();
    for (point, &own) in points.iter().zip(&clusters.cluster_of) {
        let mut row: Vec<(u32, f32)> = reach[own as usize]
            .iter()
            .map(|&c| {
                let d = point.distance(clusters.positions[c as usize]) / (KERNEL * size);
                let kernel = (1.0 - d * d).max(0.0).powi(2);
                (c, if c == own { kernel + 1e-3 } else { kernel })
            })
            .collect();
        row.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        row.truncate(SUPPORTS);
        let total: f32 = row.iter().map(|r| r.1).sum();
        row.iter_mut().for_each(|r| r.1 /= total);
        out.push(&row);
    }
    out
}

fn two_rings(centre: usize, touching: &Adjacency) -> Vec<u32> {
    let mut reach = vec![centre as u32];
    for &a in touching.of(centre) {
        reach.push(a);
        reach.extend(touching.of(a as usize));
    }
    reach.sort_unstable();
    reach.dedup();
    reach
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(columns: u32, size: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let at = |i: u32| Vec3::new((i / 2) as f32 * size, (i % 2) as f32 * size, 0.1);
        let triangles = (0..columns - 1).flat_map(|c| {
            let i = 2 * c;
            [[i, i + 2, i + 1], [i + 1, i + 2, i + 3]]
        });
        ((0..2 * columns).map(at).collect(), triangles.collect())
    }

    #[test]
    fn every_vertex_is_interpolated_from_nodes_with_weights_that_sum_to_one() {
        let (positions, triangles) = strip(80, 0.008);
        let graph = OutfitGraph::new(&positions, &triangles, &vec![0; positions.len()]);
        for v in 0..positions.len() {
            let total: f32 = graph.vertex_from_node.row(v).map(|r| r.1).sum();
            assert!((total - 1.0).abs() < 1e-5);
        }
        assert!(graph.nodes.positions.len() < positions.len() / 2);
        assert!(graph.patches.positions.len() < graph.nodes.positions.len());
    }

    #[test]
    fn garments_that_touch_in_space_share_no_node() {
        let (mut positions, mut triangles) = strip(10, 0.008);
        let count = positions.len() as u32;
        positions.extend_from_within(..);
        triangles.extend(triangles.clone().iter().map(|t| t.map(|i| i + count)));
        let garment: Vec<u32> = (0..2 * count).map(|v| v / count).collect();
        let graph = OutfitGraph::new(&positions, &triangles, &garment);
        let (first, second) = graph.nodes.cluster_of.split_at(count as usize);
        assert!(first.iter().all(|c| !second.contains(c)));
    }

    #[test]
    fn coarse_meshes_have_a_node_for_every_vertex() {
        let (positions, triangles) = strip(6, 0.08);
        let graph = OutfitGraph::new(&positions, &triangles, &vec![0; positions.len()]);
        assert_eq!(graph.nodes.positions.len(), positions.len());
    }
}
