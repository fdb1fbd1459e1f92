//! Room for the arms: the library's poses are drawn on the reference body, and a wider trunk needs them further out.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use toile_geometry::body::{Body, BodyShape, ShapedBody};
use toile_geometry::pose::Pose;

use crate::recent::Recent;
use crate::reference::Part;

const SHAPES: usize = 16;

/// Arms are swung out by at most this, radians.
const MOST: f32 = 0.6;
/// Above this share of the arm's length under the shoulder, the armpit hides how wide the trunk is.
const ARMPIT: f32 = 0.35;

/// Joints of one arm.
struct Arm {
    /// +1 left, -1 right: the sign of x.
    side: f32,
    shoulder: usize,
    wrist: usize,
    /// What the collar bone hangs on.
    chest: usize,
}

/// How wide the reference body is, and where its arms are.
pub struct ArmRoom {
    arms: Vec<Arm>,
    /// Angle from the vertical at which the trunk touches a straight arm, left and right, radians.
    reference: Vec<f32>,
    parts: Arc<[Option<Part>]>,
    /// How much wider recently asked bodies are, left and right, radians.
    wider: Recent<BodyShape, Vec<f32>>,
}

impl ArmRoom {
    /// Measures the reference body; `parts` are those of its vertices.
    #[must_use]
    pub fn new(body: &Body, reference: &ShapedBody, parts: Arc<[Option<Part>]>) -> Self {
        let skeleton = body.skeleton();
        let arm = |(name, side): (&str, f32)| {
            let joint = |part: &str| skeleton.index(&format!("{part}.{name}"));
            let chest = skeleton.parents().get(joint("clavicle")?).copied().flatten()?;
            Some(Arm { side, shoulder: joint("upperarm01")?, wrist: joint("wrist")?, chest })
        };
        let arms: Vec<Arm> = [("L", 1.0), ("R", -1.0)].into_iter().filter_map(arm).collect();
        let mut out = Self { arms, reference: Vec::new(), parts, wider: Recent::new(SHAPES) };
        out.reference = out.arms.iter().map(|arm| out.touch(arm, reference)).collect();
        out
    }

    /// The pose with its hanging arms swung out by as much as this body is wider than the reference body.
    #[must_use]
    pub fn given(&self, body: &Body, shaped: &ShapedBody, mut pose: Pose) -> Pose {
        let world = body.world_joints(shaped, &pose);
        let widths = self.wider.get(shaped.shape.clone(), |_| self.widths(shaped));
        for (arm, wider) in self.arms.iter().zip(widths.iter()) {
            let turn = arm.side * wider * arm.hangs(&shaped.joints, &world);
            if let Some(rotation) = pose.rotations.get_mut(arm.shoulder).filter(|_| turn != 0.0) {
                *rotation = Quat::from_rotation_z(turn) * *rotation;
            }
        }
        pose
    }

    fn widths(&self, shaped: &ShapedBody) -> Vec<f32> {
        let wider = |(arm, reference): (&Arm, &f32)| (self.touch(arm, shaped) - reference).clamp(0.0, MOST);
        self.arms.iter().zip(&self.reference).map(wider).collect()
    }

    /// Angle from the vertical under the shoulder at which hips or belly would touch a straight arm, radians.
    fn touch(&self, arm: &Arm, shaped: &ShapedBody) -> f32 {
        let (Some(shoulder), Some(wrist)) = (shaped.joints.get(arm.shoulder), shaped.joints.get(arm.wrist))
        else {
            return 0.0;
        };
        let length = shoulder.distance(*wrist);
        let angle = |(vertex, part): (&Vec3, &Option<Part>)| {
            let below = shoulder.y - vertex.y;
            let beside = arm.side * (vertex.x - shoulder.x);
            let seen = part.is_some() && below > ARMPIT * length && below < length;
            seen.then(|| beside.atan2(below))
        };
        let angles = shaped.apose_vertices.iter().zip(self.parts.iter()).filter_map(angle);
        angles.fold(f32::NEG_INFINITY, f32::max).clamp(-1.0, 1.0)
    }
}

impl Arm {
    /// 1 where the wrist is under the shoulder, 0 where the arm is as far out as in the A-pose or further.
    fn hangs(&self, apose: &[Vec3], world: &[Affine3A]) -> f32 {
        let at = |joint: usize| apose.get(joint).copied().unwrap_or_default();
        let posed = |joint: usize| world.get(joint).map_or(Vec3::ZERO, |w| Vec3::from(w.translation));
        let upright =
            world.get(self.chest).map_or(Quat::IDENTITY, |w| Quat::from_mat3a(&w.matrix3).conjugate());
        let out = |way: Vec3| (self.side * way.x).atan2(-way.y);
        let drawn = out(at(self.wrist) - at(self.shoulder));
        let now = out(upright * (posed(self.wrist) - posed(self.shoulder)));
        (1.0 - now / drawn.max(0.1)).clamp(0.0, 1.0)
    }
}
