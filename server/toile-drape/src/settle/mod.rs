//! Between the dynamic pass and the resolve: hanging cloth comes down and falls into folds.
//!
//! One network for every outfit answers with the mean of what it has seen. Cloth then hangs too high, and has no folds
//! where these lie by chance.

mod fall;
mod feet;
pub mod flutes;
mod hanging;
mod lift;
mod tables;

use glam::Vec3;

use crate::contact::Collider;
use crate::fitted::Fitted;
use crate::static_pass::StaticPass;
use feet::Feet;

pub use hanging::Hanging;
pub use tables::SettleTables;

/// Settles world `positions` (welded order) of an outfit on a body.
pub fn settle(statics: &StaticPass, fitted: &Fitted, body: &Collider<'_>, positions: &mut [Vec3]) {
    let (nodes, hanging) = (&fitted.node_edges, &fitted.hanging);
    if hanging.is_empty() {
        return;
    }
    let mut at = nodes.at(positions);
    let feet = Feet::of(body);
    let mut moves = hanging.fall(statics, &feet, &at);
    nodes.carry_nodes(statics, &moves, &mut at);
    let raised: Vec<Vec3> =
        statics.settle.normals(&at).zip(hanging.flutes(statics, &at)).map(|(n, height)| n * height).collect();
    for places in [&mut moves, &mut at] {
        places.iter_mut().zip(&raised).for_each(|(place, raised)| *place += raised);
    }
    feet.lift(hanging, statics, &at, &mut moves);
    nodes.carry(statics, &moves, positions);
}

#[cfg(test)]
mod tests {
    use toile_geometry::mesh::{Adjacency, edges};

    use super::*;
    use crate::binding::CANDIDATES;
    use crate::fitted::{Coarse, lengths};
    use crate::graph::OutfitGraph;
    use crate::static_pass::NodeRig;
    use crate::straighten::NodeEdges;
    use crate::stretch::interleaved;
    use crate::test_meshes::{limb, tube};

    /// A tube 30 cm wide and 50 cm high whose vertices all have the same `clearance` at rest, metres.
    pub(super) fn hung(clearance: f32) -> (StaticPass, Fitted) {
        let (rest, triangles) = tube(0.15, 0.5);
        let graph = OutfitGraph::new(&rest, &triangles, &vec![0; rest.len()]);
        let room = vec![clearance; graph.near.len()];
        let statics = StaticPass {
            settle: SettleTables::new(&graph, &rest, &triangles, &room),
            rest: rest.clone(),
            clearance: vec![clearance; rest.len()],
            candidates: vec![0; graph.near.len() * CANDIDATES],
            edges: interleaved(edges(&triangles)),
            nodes: NodeRig { positions: graph.nodes.positions, ..NodeRig::default() },
            vertex_from_node: graph.vertex_from_node,
            near: graph.near,
            ..StaticPass::default()
        };
        let node_edges = NodeEdges::new(&statics, &rest);
        let hanging = Hanging::new(&statics, &rest, &node_edges);
        let lengths = lengths(&rest, &statics.edges);
        (statics, Fitted { rest, lengths, node_edges, hanging, coarse: Coarse::default(), sags: vec![] })
    }

    /// How far the vertices of a tube lie from their mean distance to its axis, metres, after it was squeezed to 94 % of
    /// its width and settled.
    fn folds(clearance: f32) -> f32 {
        let (statics, fitted) = hung(clearance);
        let squeezed = |p: &Vec3| Vec3::new(0.94 * p.x, p.y, 0.94 * p.z);
        let mut positions: Vec<Vec3> = fitted.rest.iter().map(squeezed).collect();
        let (skin, ring) = ([Vec3::Y * 9.0], Adjacency::new(1, &[]));
        let body = limb(&skin, &[Vec3::NEG_Y], &ring);
        settle(&statics, &fitted, &body, &mut positions);
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
