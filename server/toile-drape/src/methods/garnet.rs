//! `GarNet++` (Gundogdu et al. 2020): a network of a kind of garment that sees the body as points.
//!
//! Equation 1: dual-quaternion skinning by the body's own weights, then a translation of every node of the canonical
//! graph, read at the vertices. `model/garnet_scenes.py` puts the same inputs together for training.

use glam::{Affine3A, Mat3, Vec3};

use super::{GarmentKind, Method, Placement, Wearer};
use crate::dual_quaternions::{motions, warp};
use crate::error::DrapeError;
use crate::garnet_tables::{AVERAGED, POOLED};
use crate::graph::NEIGHBOURS;
use crate::methods::deepsd::only;
use crate::network::{Networks, TensorRef};
use crate::posed_body::PosedBody;
use crate::static_pass::StaticPass;

/// Entries of a ring: a node and its neighbours.
const RING: usize = NEIGHBOURS + 1;

/// Turn about the upright up to which bodies face in training, radians (`model/garnet_scenes.py`).
const FACING: f32 = 0.3;

/// `GarNet++`, local variant.
pub struct Garnet;

impl Method for Garnet {
    fn dynamic_pass<'s>(
        &self,
        wearer: &Wearer<'s>,
        networks: &mut dyn Networks,
    ) -> Result<Placement<'s>, DrapeError> {
        let pieces = pieces(wearer)?;
        let nodes = nodes_on_body(wearer.statics, wearer.rest);
        let thinned: Vec<i64> = wearer.seen.thinned.as_flattened().iter().map(|&i| i64::from(i)).collect();
        let mut frames = Vec::with_capacity(wearer.transforms.len());
        for (transforms, body) in wearer.transforms.iter().zip(wearer.bodies) {
            let scene = Scene::new(wearer, &thinned, &nodes, (transforms, body));
            let mut moved = vec![Vec3::ZERO; nodes.len()];
            for piece in &pieces {
                scene.translate(piece, networks, &mut moved)?;
            }
            frames.push(scene.cloth(&moved));
        }
        Ok(Placement::World(frames))
    }
}

/// One garment as its network sees it: a run of nodes and their ring.
struct Piece {
    kind: GarmentKind,
    nodes: Vec<usize>,
    /// Where they are at rest, less their middle.
    rest: Vec<Vec3>,
    ring: Vec<i64>,
    ring_weight: Vec<f32>,
}

/// Every garment with the tables that do not depend on body or pose.
fn pieces(wearer: &Wearer<'_>) -> Result<Vec<Piece>, DrapeError> {
    let count = wearer.outfit.garments.len();
    if wearer.kinds.len() != count {
        return Err(DrapeError::NoKinds { expected: count, found: wearer.kinds.len() });
    }
    let of_garment = |(garment, &kind): (usize, &GarmentKind)| piece(wearer.statics, garment as u32, kind);
    Ok(wearer.kinds.iter().enumerate().map(of_garment).filter(|piece| !piece.nodes.is_empty()).collect())
}

fn piece(statics: &StaticPass, garment: u32, kind: GarmentKind) -> Piece {
    let all = 0..statics.nodes.garment.len();
    let nodes: Vec<usize> = all.filter(|&n| statics.nodes.garment[n] == garment).collect();
    let mut place = vec![0; statics.near.len()];
    nodes.iter().zip(0..).for_each(|(&n, k)| place[n] = k);
    let (mut ring, mut ring_weight) = (Vec::new(), Vec::new());
    for &node in &nodes {
        let near: Vec<i64> = statics.near.row(node).map(|(n, _)| place[n]).collect();
        let share = 1.0 / (near.len() + 1) as f32;
        ring.push(place[node]);
        ring.extend((0..NEIGHBOURS).map(|k| near.get(k).copied().unwrap_or(place[node])));
        ring_weight.extend((0..RING).map(|k| if k <= near.len() { share } else { 0.0 }));
    }
    let drawn = || nodes.iter().map(|&n| statics.nodes.positions[n]);
    let middle = drawn().sum::<Vec3>() / nodes.len().max(1) as f32;
    Piece { kind, rest: drawn().map(|p| p - middle).collect(), nodes, ring, ring_weight }
}

/// Nodes of the rest pose carried to a body: they follow the vertices that read them. `rest`: vertices on that body.
fn nodes_on_body(statics: &StaticPass, rest: &[Vec3]) -> Vec<Vec3> {
    let count = statics.nodes.positions.len();
    let (mut moved, mut total) = (vec![Vec3::ZERO; count], vec![0.0_f32; count]);
    for (v, (on_body, drawn)) in rest.iter().zip(&statics.rest).enumerate() {
        for (node, weight) in statics.vertex_from_node.row(v) {
            moved[node] += (*on_body - *drawn) * weight;
            total[node] += weight;
        }
    }
    let carried = |((p, m), t): ((&Vec3, Vec3), f32)| *p + m / t.max(1e-9);
    statics.nodes.positions.iter().zip(moved).zip(total).map(carried).collect()
}

/// One frame.
struct Scene<'a> {
    wearer: &'a Wearer<'a>,
    thinned: &'a [i64],
    seen: Vec<Vec3>,
    transforms: &'a [Affine3A],
    /// Where skinning puts the nodes, and by what it turns them, world from rest.
    nodes: Vec<Vec3>,
    turns: Vec<Mat3>,
    /// What the networks are shown it in, from the world.
    shown: Mat3,
}

impl<'a> Scene<'a> {
    /// `nodes`: on the body, at rest.
    fn new(
        wearer: &'a Wearer<'a>,
        thinned: &'a [i64],
        nodes: &[Vec3],
        (transforms, body): (&'a [Affine3A], &PosedBody),
    ) -> Self {
        let points = wearer.seen.points.iter();
        let seen = points.filter_map(|&i| body.vertices.get(i as usize)).copied().collect();
        let rig = &wearer.statics.nodes;
        let motions = motions(&rig.joints, &rig.weights, transforms);
        let (nodes, turns) = nodes.iter().zip(motions).map(|(p, m)| (m.transform(*p), m.turn())).unzip();
        Self { wearer, thinned, seen, transforms, nodes, turns, shown: shown(wearer.parents, transforms) }
    }

    /// The garments' vertices where skinning puts them, and the translations of the nodes read there. World, m.
    fn cloth(&self, moved: &[Vec3]) -> Vec<Vec3> {
        let (rig, read) = (&self.wearer.statics.rig, &self.wearer.statics.vertex_from_node);
        let warped = warp(self.wearer.rest, &rig.prior_joints, &rig.prior_weights, self.transforms);
        warped.into_iter().enumerate().map(|(v, p)| p + read.blended(v, moved)).collect()
    }

    /// Runs a garment's network and writes the translations of its nodes.
    fn translate(
        &self,
        piece: &Piece,
        networks: &mut dyn Networks,
        moved: &mut [Vec3],
    ) -> Result<(), DrapeError> {
        let nodes: Vec<Vec3> = piece.nodes.iter().map(|&n| self.nodes[n]).collect();
        let count = nodes.len();
        let middle = nodes.iter().sum::<Vec3>() / count as f32;
        let pooled = self.wearer.seen.pooled(&self.seen, &nodes);
        let shown = |p: &Vec3| (self.shown * (*p - middle)).to_array();
        let body: Vec<f32> = self.seen.iter().flat_map(shown).collect();
        let rows = nodes.iter().zip(&piece.rest).map(|(p, rest)| [shown(p), rest.to_array()]);
        let garment: Vec<f32> = rows.flatten().flatten().collect();
        // Row by row; glam keeps columns.
        let turns: Vec<f32> = piece
            .nodes
            .iter()
            .flat_map(|&n| (self.shown * self.turns[n]).transpose().to_cols_array())
            .collect();
        let thinned = [self.wearer.seen.thinned.len(), AVERAGED];
        let graph = piece.kind.graph();
        let answer = networks.run(
            graph,
            &[
                ("garment", TensorRef::F32(&[count, 6], &garment)),
                ("turn", TensorRef::F32(&[count, 3, 3], &turns)),
                ("body", TensorRef::F32(&[self.seen.len(), 3], &body)),
                ("ring", TensorRef::I64(&[count, RING], &piece.ring)),
                ("ring_weight", TensorRef::F32(&[count, RING], &piece.ring_weight)),
                ("thinned", TensorRef::I64(&thinned, self.thinned)),
                ("pooled", TensorRef::I64(&[count, POOLED], &pooled)),
            ],
        )?;
        let translations = only(graph, answer, 3 * count)?;
        for (&node, t) in piece.nodes.iter().zip(translations.as_chunks::<3>().0) {
            moved[node] = self.shown.transpose() * Vec3::from_array(*t);
        }
        Ok(())
    }
}

/// Turns the world until a body faces as far from +Z as in training at most: neither cloth nor gravity notices.
fn shown(parents: &[Option<usize>], transforms: &[Affine3A]) -> Mat3 {
    let hips = parents.iter().zip(transforms).find(|(parent, _)| parent.is_none());
    let ahead = hips.map_or(Vec3::Z, |(_, hips)| hips.transform_vector3(Vec3::Z));
    let facing = ahead.x.atan2(ahead.z);
    Mat3::from_rotation_y(facing.clamp(-FACING, FACING) - facing)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a body that is turned about the upright by some radians is shown to face.
    fn faces(turn: f32) -> f32 {
        let hips = Affine3A::from_rotation_y(turn);
        let ahead = shown(&[None, Some(0)], &[hips, Affine3A::IDENTITY]) * hips.transform_vector3(Vec3::Z);
        ahead.x.atan2(ahead.z)
    }

    #[test]
    fn bodies_are_shown_facing_as_in_training() {
        for turn in [-0.2, 0.0, 0.29] {
            assert!((faces(turn) - turn).abs() < 1e-6);
        }
        assert!((faces(1.6) - FACING).abs() < 1e-5 && (faces(-3.0) + FACING).abs() < 1e-5);
    }
}
