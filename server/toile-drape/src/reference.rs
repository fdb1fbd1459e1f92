//! The reference body as outfits are bound to it: surface, limbs, and which part cloth may touch.

use std::sync::Arc;

use glam::Vec3;
use thiserror::Error;
use toile_geometry::body::{Body, BodyShape};
use toile_geometry::mesh::Adjacency;
use toile_geometry::nearest::PointTree;
use toile_geometry::normals::vertex_normals;

/// Joints of the garment skeleton.
pub const GARMENT_JOINTS: usize = 36;

const ARM: [&str; 5] = ["upperarm01", "upperarm02", "lowerarm01", "lowerarm02", "wrist"];
const LEG: [&str; 5] = ["upperleg01", "upperleg02", "lowerleg01", "lowerleg02", "foot"];
const SHOULDER: [&str; 2] = ["clavicle", "shoulder01"];
const SIDES: [&str; 2] = ["L", "R"];

/// Which part of the body a cloth vertex may touch: its own limb, never the arm beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limb {
    /// Everything but the arms.
    Trunk = 0,
    /// One arm and its shoulder.
    ArmLeft = 1,
    /// One arm and its shoulder.
    ArmRight = 2,
    /// Everything but the arms and the other leg.
    LegLeft = 3,
    /// Everything but the arms and the other leg.
    LegRight = 4,
}

impl Limb {
    /// Every limb, in the order of its number.
    pub const ALL: [Self; 5] = [Self::Trunk, Self::ArmLeft, Self::ArmRight, Self::LegLeft, Self::LegRight];
}

/// Parts of the body that can meet where it bends (see [`crate::folds`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// From the chest down to the hips.
    Trunk,
    /// Upper leg.
    ThighLeft,
    /// Upper leg.
    ThighRight,
    /// Lower leg.
    CalfLeft,
    /// Lower leg.
    CalfRight,
}

/// Height of the reference body's chest, above which nothing meets a thigh, metres.
const CHEST: f32 = 1.25;

/// The body does not fit what draping needs.
#[derive(Debug, Error)]
#[error("the baked body lacks {0}")]
pub struct ReferenceError(String);

/// The reference body's surface in the A-pose, `rest` space of every outfit.
pub struct ReferenceBody {
    /// Vertices, metres.
    pub vertices: Vec<Vec3>,
    /// Unit vertex normals.
    pub normals: Vec<Vec3>,
    /// Skin weights over the garment joints, a row a vertex.
    pub skin: Vec<[f32; GARMENT_JOINTS]>,
    /// Edges of the surface.
    pub ring: Adjacency,
    /// Part of every vertex; none for arms, head and feet.
    pub parts: Arc<[Option<Part>]>,
    /// Vertices of the left and of the right foot.
    pub feet: [Vec<u32>; 2],
    /// For each limb the body vertices that its cloth may touch.
    pub touch: [PointTree; 5],
    /// Every body vertex.
    pub all: PointTree,
    /// Every body vertex but the hands.
    pub clothed: PointTree,
    limbs: LimbJoints,
}

/// Garment joint numbers of the limbs, left and right.
struct LimbJoints {
    arm: [Vec<usize>; 2],
    leg: [Vec<usize>; 2],
    shoulder: [Vec<usize>; 2],
    hand: [Vec<usize>; 2],
}

impl LimbJoints {
    fn new(names: &[&str]) -> Result<Self, ReferenceError> {
        let find = |parts: &[&str]| -> Result<[Vec<usize>; 2], ReferenceError> {
            let side = |s: &str| {
                parts
                    .iter()
                    .map(|p| format!("{p}.{s}"))
                    .map(|n| names.iter().position(|x| *x == n).ok_or(ReferenceError(format!("joint {n}"))))
                    .collect::<Result<Vec<_>, _>>()
            };
            Ok([side(SIDES[0])?, side(SIDES[1])?])
        };
        Ok(Self { arm: find(&ARM)?, leg: find(&LEG)?, shoulder: find(&SHOULDER)?, hand: find(&["wrist"])? })
    }
}

impl LimbJoints {
    /// Whether a foot, left or right, has most of a vertex's skin weight.
    fn is_foot(&self, side: usize, row: &[f32; GARMENT_JOINTS]) -> bool {
        self.leg[side].last().is_some_and(|foot| row[*foot] > 0.5)
    }

    /// The part with most of a vertex's skin weight.
    fn part(&self, row: &[f32; GARMENT_JOINTS]) -> Option<Part> {
        let sides = [(Part::ThighLeft, Part::CalfLeft), (Part::ThighRight, Part::CalfRight)];
        for (leg, (thigh, calf)) in self.leg.iter().zip(sides) {
            let share = |range: std::ops::Range<usize>| leg.get(range).map_or(0.0, |j| total(row, j));
            match (share(0..2), share(2..4), share(4..5)) {
                (_, _, foot) if foot > 0.5 => return None,
                (upper, lower, _) if upper + lower > 0.5 => {
                    return Some(if upper > lower { thigh } else { calf });
                }
                _ => {}
            }
        }
        Some(Part::Trunk)
    }
}

fn total(row: &[f32; GARMENT_JOINTS], joints: &[usize]) -> f32 {
    joints.iter().filter_map(|&j| row.get(j)).sum()
}

impl ReferenceBody {
    /// Builds the surface of the default shape.
    ///
    /// # Errors
    /// When the body's skeleton lacks a limb joint.
    pub fn new(body: &Body) -> Result<Self, ReferenceError> {
        let vertices = body.shape(&BodyShape::default()).apose_vertices;
        let limbs = LimbJoints::new(&garment_joint_names(body))?;
        let skin: Vec<[f32; GARMENT_JOINTS]> = (0..vertices.len()).map(|v| dense_row(body, v)).collect();
        let hand = |v: usize| limbs.hand.iter().map(|h| total(&skin[v], h)).sum::<f32>();
        let arms = |v: usize| limbs.arm.iter().map(|a| total(&skin[v], a)).sum::<f32>();
        let no_arm = |v: usize| arms(v) < 0.6;
        let arm_side = |v: usize, s: usize| {
            let near = total(&skin[v], &limbs.arm[s]) > 0.15;
            let shoulder = total(&skin[v], &limbs.shoulder[s]) > 0.15 && no_arm(v);
            (near || shoulder) && hand(v) <= 0.5
        };
        let leg_side = |v: usize, s: usize| no_arm(v) && total(&skin[v], &limbs.leg[1 - s]) < 0.5;
        let tree = |allowed: &dyn Fn(usize) -> bool| {
            PointTree::new(&vertices, allowed).ok_or(ReferenceError("a limb".to_owned()))
        };
        Ok(Self {
            touch: [
                tree(&no_arm)?,
                tree(&|v| arm_side(v, 0))?,
                tree(&|v| arm_side(v, 1))?,
                tree(&|v| leg_side(v, 0))?,
                tree(&|v| leg_side(v, 1))?,
            ],
            all: tree(&|_| true)?,
            clothed: tree(&|v| hand(v) <= 0.95)?,
            feet: [0, 1]
                .map(|s| (0..).zip(&skin).filter(|(_, row)| limbs.is_foot(s, row)).map(|(v, _)| v).collect()),
            parts: (0..vertices.len())
                .map(|v| limbs.part(&skin[v]).filter(|_| no_arm(v) && vertices[v].y < CHEST))
                .collect(),
            normals: vertex_normals(&vertices, body.triangles()),
            ring: Adjacency::new(vertices.len(), body.triangles()),
            vertices,
            skin,
            limbs,
        })
    }

    /// Limb of a cloth vertex from its diffused skin weights: an arm above one half, a leg only when clear
    /// of the other.
    #[must_use]
    pub fn limb(&self, prior: &[f32; GARMENT_JOINTS]) -> Limb {
        for (s, limb) in [Limb::ArmLeft, Limb::ArmRight].into_iter().enumerate() {
            if total(prior, &self.limbs.arm[s]) > 0.5 {
                return limb;
            }
        }
        let leg = [0, 1].map(|s| total(prior, &self.limbs.leg[s]));
        match leg {
            [l, r] if l > 0.3 && r < 0.02 => Limb::LegLeft,
            [l, r] if r > 0.3 && l < 0.02 => Limb::LegRight,
            _ => Limb::Trunk,
        }
    }

    /// Signed distance of a point to the surface along the normal of the nearest vertex, metres.
    #[must_use]
    pub fn signed_distance(&self, point: Vec3) -> f32 {
        let hit = self.all.nearest(point).index as usize;
        match (self.vertices.get(hit), self.normals.get(hit)) {
            (Some(v), Some(n)) => (point - *v).dot(*n),
            _ => 0.0,
        }
    }
}

/// Names of the garment skeleton's joints, in its order.
#[must_use]
pub fn garment_joint_names(body: &Body) -> Vec<&str> {
    let skeleton = body.skeleton();
    skeleton.garment_joints().iter().filter_map(|&j| body.joint_names().get(j)).map(String::as_str).collect()
}

fn dense_row(body: &Body, vertex: usize) -> [f32; GARMENT_JOINTS] {
    let (joints, weights) = body.garment_skin().row(vertex);
    let mut out = [0.0; GARMENT_JOINTS];
    for (&j, &w) in joints.iter().zip(weights) {
        if let Some(slot) = out.get_mut(usize::from(j)) {
            *slot += w;
        }
    }
    out
}
