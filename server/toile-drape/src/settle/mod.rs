//! Between the dynamic pass and the resolve: hanging cloth comes down and falls into folds.
//!
//! One network for every outfit answers with the mean of what it has seen. Cloth then hangs too high, and has no folds
//! where these lie by chance.

mod fall;
pub mod flutes;
mod hanging;

use glam::Vec3;
use toile_geometry::mesh::Adjacency;
use toile_geometry::normals::vertex_normals;

use crate::contact::Collider;
use crate::fitted::Fitted;
use crate::graph::{Links, OutfitGraph, cluster, interpolation};
use crate::outfit::Outfit;
use crate::static_pass::StaticPass;

pub use hanging::Hanging;

/// Size of the cell of nodes that fall together, metres: twice a node's.
const CLUSTER_SIZE: f32 = 0.05;

/// The cluster of each node of an outfit whose mesh has the given `edges`, and the nodes' places between the clusters.
#[must_use]
pub fn clusters(graph: &OutfitGraph, edges: &[[u32; 2]]) -> (Vec<u32>, Links) {
    let both = linked(&graph.near, &graph.vertex_from_node, edges).flat_map(|[a, b]| [(a, b), (b, a)]);
    let links = Adjacency::from_pairs(graph.near.len(), both.collect());
    let clusters = cluster(&graph.nodes.positions, &links, &graph.nodes.garment, CLUSTER_SIZE);
    let from = interpolation(&graph.nodes.positions, &clusters, CLUSTER_SIZE);
    (clusters.cluster_of, from)
}

/// Pairs of nodes that touch or that one of the mesh's `edges` joins, some of them twice: meshes coarser than the graph
/// have nodes without a vertex between the ends of an edge.
fn linked(near: &Links, vertex_from_node: &Links, edges: &[[u32; 2]]) -> impl Iterator<Item = [u32; 2]> {
    let touching = (0..near.len()).flat_map(|n| near.row(n).map(move |(m, _)| [n, m]));
    let node = |v: u32| vertex_from_node.nearest(v as usize);
    let joined = edges.iter().filter_map(move |[a, b]| Some([node(*a)?, node(*b)?]));
    touching.chain(joined).filter(|[a, b]| a != b).map(|ends| ends.map(|n| n as u32))
}

/// Settles world `positions` (welded order) of an outfit on a body.
pub fn settle(
    outfit: &Outfit,
    statics: &StaticPass,
    fitted: &Fitted,
    body: &Collider<'_>,
    positions: &mut [Vec3],
) {
    let (nodes, hanging) = (&fitted.node_edges, &fitted.hanging);
    if hanging.is_empty() {
        return;
    }
    let fallen = hanging.fall(statics, body, &nodes.at(positions));
    nodes.carry(statics, &fallen, positions);
    let heights = hanging.flutes(statics, &nodes.at(positions));
    let normals = nodes.at(&vertex_normals(positions, &outfit.triangles));
    let raised: Vec<Vec3> = normals.iter().zip(heights).map(|(normal, height)| *normal * height).collect();
    nodes.carry(statics, &raised, positions);
}

#[cfg(test)]
mod tests {
    use toile_geometry::mesh::edges;

    use super::*;
    use crate::binding::CANDIDATES;
    use crate::fitted::lengths;
    use crate::static_pass::NodeRig;
    use crate::straighten::NodeEdges;
    use crate::stretch::interleaved;
    use crate::test_meshes::tube;

    /// A tube 30 cm wide and 50 cm high whose vertices all have the same `clearance` at rest, metres.
    pub(super) fn hung(clearance: f32) -> (Outfit, StaticPass, Fitted) {
        let (rest, triangles) = tube(0.15, 0.5);
        let graph = OutfitGraph::new(&rest, &triangles, &vec![0; rest.len()]);
        let (cluster_of, node_from_cluster) = clusters(&graph, &edges(&triangles));
        let room = vec![clearance; graph.near.len()];
        let statics = StaticPass {
            flutes: flutes::pattern(&graph.nodes.positions, &graph.near, &graph.vertex_from_node, &room),
            rest: rest.clone(),
            clearance: vec![clearance; rest.len()],
            candidates: vec![0; graph.near.len() * CANDIDATES],
            edges: interleaved(edges(&triangles)),
            nodes: NodeRig { positions: graph.nodes.positions, ..NodeRig::default() },
            vertex_from_node: graph.vertex_from_node,
            near: graph.near,
            cluster_of,
            node_from_cluster,
            ..StaticPass::default()
        };
        let node_edges = NodeEdges::new(&statics, &rest);
        let hanging = Hanging::new(&statics, &rest, &node_edges);
        let lengths = lengths(&rest, &statics.edges);
        (
            Outfit { triangles, ..Outfit::default() },
            statics,
            Fitted { rest, lengths, node_edges, hanging, coarse: vec![] },
        )
    }

    /// How far the vertices of a tube lie from their mean distance to its axis, metres, after it was squeezed to 94 % of
    /// its width and settled.
    fn folds(clearance: f32) -> f32 {
        let (outfit, statics, fitted) = hung(clearance);
        let squeezed = |p: &Vec3| Vec3::new(0.94 * p.x, p.y, 0.94 * p.z);
        let mut positions: Vec<Vec3> = fitted.rest.iter().map(squeezed).collect();
        let (skin, ring) = ([Vec3::Y * 9.0], Adjacency::new(1, &[]));
        let body = Collider { vertices: &skin, normals: &[Vec3::NEG_Y], ring: &ring, facing: &[] };
        settle(&outfit, &statics, &fitted, &body, &mut positions);
        let away: Vec<f32> = positions.iter().map(|p| p.with_y(0.0).length()).collect();
        let mean = away.iter().sum::<f32>() / away.len() as f32;
        away.iter().map(|a| (a - mean).abs()).sum::<f32>() / away.len() as f32
    }

    #[test]
    fn hanging_cloth_that_lacks_width_folds_and_cloth_on_the_skin_does_not() {
        assert!((0.003..0.015).contains(&folds(0.1)), "{}", folds(0.1));
        assert!(folds(0.01) < 1e-4, "{}", folds(0.01));
    }
}
