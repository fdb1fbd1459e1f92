//! What a scan leaves open: shape, place, and how its arms and legs are held.

use std::collections::BTreeMap;

use glam::{Quat, Vec3};

use crate::body::{Body, BodyShape, MUSCLE, PARAMETERS, PHENOTYPES};
use crate::measurements::{Measurement, solve};
use crate::pose::Pose;

/// Limbs and the axes that they turn about, which the A-pose leaves to the person.
const TURNS: [(&str, Vec3); 9] = [
    ("hips", Vec3::Y),
    ("leftUpperArm", Vec3::Z),
    ("leftUpperArm", Vec3::Y),
    ("rightUpperArm", Vec3::Z),
    ("rightUpperArm", Vec3::Y),
    ("leftLowerArm", Vec3::Y),
    ("rightLowerArm", Vec3::Y),
    ("leftUpperLeg", Vec3::Z),
    ("rightUpperLeg", Vec3::Z),
];
/// Where translation and turns begin among the unknowns.
pub(super) const PLACE: usize = PARAMETERS;
const TURN: usize = PLACE + 3;
/// Number of unknowns.
pub(super) const COUNT: usize = TURN + TURNS.len();
/// How strongly unknowns are drawn to the middle, square metres a square unit.
const PULL: f64 = 4e-7;
/// How much more strongly local changes are at first: a waist is not to be narrowed where a whole body is to be thinner.
const PULL_AT_FIRST: f64 = 3e3;
/// Where the two halves of muscle meet, which change a body in different ways.
const KINK: f32 = 0.5;
/// How far beyond it the second search starts.
const AWAY: f32 = 0.2;
/// Widest turn, radians.
const WIDEST: f32 = 0.9;
/// Longest step of a parameter of the shape, of the place (metres) and of a turn (radians).
const LONGEST: f32 = 0.25;

/// Shape parameters, translation (metres), turns (radians).
#[derive(Clone, Debug)]
pub(super) struct Unknowns {
    values: [f32; COUNT],
    /// Bounds of the muscle.
    muscle: (f32, f32),
}

impl Unknowns {
    /// A body of about this height on the middle of the scan's bounds.
    pub(super) fn standing(body: &Body, height: f32, low: Vec3, high: Vec3) -> Self {
        let mut out = Self { values: [0.0; COUNT], muscle: (0.0, 1.0) };
        let requested = BTreeMap::from([(Measurement::Height, 100.0 * height)]);
        let shape =
            solve(body, &requested, &BTreeMap::new()).map_or_else(|_| BodyShape::default(), |s| s.shape);
        out.values[..PARAMETERS].copy_from_slice(&shape.parameters().map(|p| p as f32));
        let centre = |low: Vec3, high: Vec3| Vec3::new((low.x + high.x) / 2.0, low.y, (low.z + high.z) / 2.0);
        let vertices = body.shape(&shape).apose_vertices;
        let bound = |pick: fn(Vec3, Vec3) -> Vec3| vertices.iter().copied().reduce(pick).unwrap_or_default();
        let shift = centre(low, high) - centre(bound(Vec3::min), bound(Vec3::max));
        out.values[PLACE..TURN].copy_from_slice(&shift.to_array());
        out
    }

    pub(super) fn shape(&self) -> BodyShape {
        BodyShape::from_parameters(&std::array::from_fn(|k| f64::from(self.values[k])))
    }

    pub(super) fn pose(&self, body: &Body) -> Pose {
        let mut turns: BTreeMap<String, Quat> = BTreeMap::new();
        for ((joint, axis), &angle) in TURNS.iter().zip(&self.values[TURN..]) {
            let turn = turns.entry((*joint).to_owned()).or_insert(Quat::IDENTITY);
            *turn = Quat::from_axis_angle(*axis, angle) * *turn;
        }
        let mut pose = Pose::from_humanoid(body, &turns).unwrap_or_else(|_| Pose::identity(body));
        pose.root_translation = Vec3::from_slice(&self.values[PLACE..TURN]);
        pose
    }

    /// With unknown `k` moved by `step`.
    pub(super) fn moved(&self, k: usize, step: f32) -> Self {
        let mut out = self.clone();
        out.values[k] += step;
        out
    }

    /// Normal equations of the pull to the middle: the reference body, the A-pose. Place is free. `early`: 1 at the
    /// start to 0 at the end.
    pub(super) fn pull(&self, early: f32) -> (Vec<Vec<f64>>, Vec<f64>) {
        let (mut matrix, mut right) = (vec![vec![0.0; COUNT]; COUNT], vec![0.0; COUNT]);
        let middle = BodyShape::default().parameters();
        for k in 0..COUNT {
            let weight = match k {
                _ if k < PHENOTYPES => 4.0 * PULL,
                _ if k < PLACE => PULL * PULL_AT_FIRST.powf(f64::from(early)),
                _ => 1e-3 * PULL,
            };
            let off = f64::from(self.values[k]) - middle.get(k).copied().unwrap_or(0.0);
            matrix[k][k] = weight;
            right[k] = if (PLACE..TURN).contains(&k) { 0.0 } else { -weight * off };
        }
        (matrix, right)
    }

    /// The same on the other side of the muscle's kink, which it is held to.
    pub(super) fn across(&self) -> Self {
        let mut out = self.clone();
        let low = self.values[MUSCLE] > KINK;
        out.muscle = if low { (0.0, KINK) } else { (KINK, 1.0) };
        out.values[MUSCLE] = if low { KINK - AWAY } else { KINK + AWAY };
        out.values[PHENOTYPES..PLACE].fill(0.0);
        out
    }

    /// Moves all unknowns, within their bounds.
    pub(super) fn change(&mut self, change: &[f64]) {
        for (k, (value, by)) in self.values.iter_mut().zip(change).enumerate() {
            let next = *value + (*by as f32).clamp(-LONGEST, LONGEST);
            *value = match k {
                MUSCLE => next.clamp(self.muscle.0, self.muscle.1),
                _ if k < PHENOTYPES => next.clamp(0.0, 1.0),
                _ if k < PLACE => next.clamp(-1.0, 1.0),
                _ if k < TURN => next,
                _ => next.clamp(-WIDEST, WIDEST),
            };
        }
    }
}
