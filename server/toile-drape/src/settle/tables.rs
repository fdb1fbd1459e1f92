//! What settling needs of an outfit whatever its body: where it folds, and what falls together.

use glam::Vec3;
use toile_geometry::mesh::{Adjacency, edges};
use toile_geometry::normals::vertex_normals;

use super::flutes;
use crate::graph::{Links, OutfitGraph, cluster, interpolation};
use crate::straighten::vertex_of_node;
use crate::stretch::interleaved;

/// Size of the cell of nodes that fall together, metres: twice a node's.
const CLUSTER_SIZE: f32 = 0.05;

/// What settling needs of an outfit, part of its static pass. Nodes are those of the canonical graph.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SettleTables {
    /// Height of a flute at each node ([`flutes`]).
    pub flutes: Vec<f32>,
    /// Four nodes around each node, counterclockwise as seen from outside; the node itself where there is none.
    pub around: Vec<[u32; 4]>,
    /// Pairs of nodes that touch or that an edge of the mesh joins, of those that a vertex stands for.
    pub pairs: Vec<[u32; 2]>,
    /// Cluster that each node falls with.
    pub cluster_of: Vec<u32>,
    /// Pairs of clusters that such a pair of nodes joins.
    pub cluster_pairs: Vec<[u32; 2]>,
    /// Nodes from clusters.
    pub node_from_cluster: Links,
}

impl SettleTables {
    /// Of an outfit with its mended `rest` positions (metres), whose nodes have `room` (metres) to the skin or other cloth.
    #[must_use]
    pub fn new(graph: &OutfitGraph, rest: &[Vec3], triangles: &[[u32; 3]], room: &[f32]) -> Self {
        let count = graph.near.len();
        let joined: Vec<[u32; 2]> = joined(graph, &edges(triangles)).collect();
        let links = Adjacency::from_pairs(count, both_ways(&joined));
        let clusters = cluster(&graph.nodes.positions, &links, &graph.nodes.garment, CLUSTER_SIZE);
        let vertices = vertex_of_node(&graph.vertex_from_node, count);
        let stands = |n: &u32| vertices.get(*n as usize).is_some_and(Option::is_some);
        let pairs = unique(joined.into_iter().filter(|ends| ends.iter().all(stands)));
        let of = |n: u32| clusters.cluster_of[n as usize];
        let between = unique(pairs.iter().map(|[a, b]| [of(*a), of(*b)]).filter(|[a, b]| a != b));
        Self {
            flutes: flutes::pattern(&graph.nodes.positions, &graph.near, &graph.vertex_from_node, room),
            around: around(&Surface::new(&vertices, rest, triangles), &pairs),
            pairs,
            node_from_cluster: interpolation(&graph.nodes.positions, &clusters, CLUSTER_SIZE),
            cluster_of: clusters.cluster_of,
            cluster_pairs: interleaved(between),
        }
    }

    /// Unit normals of the nodes at `positions`, metres; 0 where the nodes around one lie in a line.
    pub(super) fn normals(&self, positions: &[Vec3]) -> impl Iterator<Item = Vec3> {
        (0..self.around.len()).map(|n| self.normal(n, positions))
    }

    /// That of node `n`.
    pub(super) fn normal(&self, n: usize, positions: &[Vec3]) -> Vec3 {
        let [right, above, left, below] = self.around[n].map(|n| positions[n as usize]);
        (right - left).cross(above - below).normalize_or_zero()
    }

    /// Bytes held in memory.
    #[must_use]
    pub fn byte_size(&self) -> usize {
        8 * (self.flutes.len() + 2 * self.around.len() + self.pairs.len() + self.cluster_pairs.len())
            + 8 * self.node_from_cluster.index.len()
    }
}

/// Pairs of nodes that touch or that one of the mesh's `edges` joins, some of them twice: meshes coarser than the graph
/// have nodes without a vertex between the ends of an edge.
fn joined(graph: &OutfitGraph, edges: &[[u32; 2]]) -> impl Iterator<Item = [u32; 2]> {
    let near = &graph.near;
    let touching = (0..near.len()).flat_map(|n| near.row(n).map(move |(m, _)| [n, m]));
    let node = |v: u32| graph.vertex_from_node.nearest(v as usize);
    let across = edges.iter().filter_map(move |[a, b]| Some([node(*a)?, node(*b)?]));
    touching.chain(across).filter(|[a, b]| a != b).map(|ends| ends.map(|n| n as u32))
}

fn both_ways(pairs: &[[u32; 2]]) -> Vec<(u32, u32)> {
    pairs.iter().flat_map(|[a, b]| [(*a, *b), (*b, *a)]).collect()
}

fn unique(pairs: impl Iterator<Item = [u32; 2]>) -> Vec<[u32; 2]> {
    let mut pairs: Vec<[u32; 2]> = pairs.map(|[a, b]| [a.min(b), a.max(b)]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs.shrink_to_fit();
    pairs
}

/// Rest positions and normals of the nodes, those of the vertices that stand for them; metres.
struct Surface {
    at: Vec<Vec3>,
    normals: Vec<Vec3>,
}

impl Surface {
    fn new(vertices: &[Option<u32>], rest: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let of = |values: &[Vec3]| {
            let value = |v: &Option<u32>| v.and_then(|v| values.get(v as usize)).copied().unwrap_or_default();
            vertices.iter().map(value).collect()
        };
        Self { at: of(rest), normals: of(&vertex_normals(rest, triangles)) }
    }
}

/// For each node those that reach farthest along four directions at right angles in the surface.
fn around(surface: &Surface, pairs: &[[u32; 2]]) -> Vec<[u32; 4]> {
    let links = Adjacency::from_pairs(surface.at.len(), both_ways(pairs));
    let corners = |(n, normal): (usize, &Vec3)| {
        let (along, across) = normal.try_normalize().unwrap_or(Vec3::Y).any_orthonormal_pair();
        [along, across, -along, -across].map(|direction| {
            let reach = |m: u32| (surface.at[m as usize] - surface.at[n]).dot(direction);
            let farther = |best: u32, m: &u32| if reach(*m) > reach(best) { *m } else { best };
            links.of(n).iter().fold(n as u32, farther)
        })
    };
    surface.normals.iter().enumerate().map(corners).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::tube;

    #[test]
    fn normals_of_nodes_point_out_of_the_cloth() {
        let (rest, triangles) = tube(0.15, 0.5);
        let graph = OutfitGraph::new(&rest, &triangles, &vec![0; rest.len()]);
        let tables = SettleTables::new(&graph, &rest, &triangles, &vec![0.1; graph.near.len()]);
        let vertices = vertex_of_node(&graph.vertex_from_node, graph.near.len());
        let surface = Surface::new(&vertices, &rest, &triangles);
        for (normal, expected) in tables.normals(&surface.at).zip(&surface.normals) {
            assert!(normal.dot(*expected) > 0.97, "{normal} {expected}");
        }
    }
}
