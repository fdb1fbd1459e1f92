//! Skinning by blended dual quaternions (Kavan et al. 2007): limbs keep their girth where they twist.

use glam::{Affine3A, Mat3, Quat, Vec3};

use crate::static_pass::INFLUENCES;

/// A rigid motion: a quaternion, and half the translation times it.
#[derive(Clone, Copy, Debug)]
pub struct DualQuaternion {
    real: Quat,
    dual: Quat,
}

impl DualQuaternion {
    fn new(transform: &Affine3A) -> Self {
        let real = Quat::from_mat3a(&transform.matrix3).normalize();
        let t = transform.translation;
        Self { real, dual: Quat::from_xyzw(t.x, t.y, t.z, 0.0) * real * 0.5 }
    }

    /// The point moved. Metres.
    #[must_use]
    pub fn transform(self, point: Vec3) -> Vec3 {
        let length = self.real.length().max(f32::MIN_POSITIVE);
        let (real, dual) = (self.real * length.recip(), self.dual * length.recip());
        real * point + (dual * real.conjugate()).xyz() * 2.0
    }

    /// What it turns by.
    #[must_use]
    pub fn turn(self) -> Mat3 {
        Mat3::from_quat(self.real * self.real.length().max(f32::MIN_POSITIVE).recip())
    }
}

/// Rest points moved by rigid `transforms`, world from A-pose, blended by their influences, the strongest first.
/// Metres.
#[must_use]
pub fn warp(
    rest: &[Vec3],
    joints: &[[u8; INFLUENCES]],
    weights: &[[f32; INFLUENCES]],
    transforms: &[Affine3A],
) -> Vec<Vec3> {
    rest.iter().zip(motions(joints, weights, transforms)).map(|(p, motion)| motion.transform(*p)).collect()
}

/// Motions of points that follow several joints by their influences, the strongest first.
pub fn motions(
    joints: &[[u8; INFLUENCES]],
    weights: &[[f32; INFLUENCES]],
    transforms: &[Affine3A],
) -> impl Iterator<Item = DualQuaternion> {
    let of_joints: Vec<DualQuaternion> = transforms.iter().map(DualQuaternion::new).collect();
    joints.iter().zip(weights).map(move |(joint, weight)| blended(&of_joints, joint, weight))
}

fn blended(
    motions: &[DualQuaternion],
    joints: &[u8; INFLUENCES],
    weights: &[f32; INFLUENCES],
) -> DualQuaternion {
    let mut sum = DualQuaternion {
        real: Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
        dual: Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
    };
    let mut strongest = None;
    for (&joint, &weight) in joints.iter().zip(weights) {
        let Some(motion) = motions.get(joint as usize) else { continue };
        // A quaternion and its negative turn alike: all on the side of the strongest.
        let side = if strongest.get_or_insert(motion.real).dot(motion.real) < 0.0 { -weight } else { weight };
        sum.real += motion.real * side;
        sum.dual += motion.dual * side;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_rigid_motion_moves_as_it_says() {
        let turn = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.7), Vec3::new(0.1, 0.2, -0.3));
        let rest = [Vec3::new(0.3, 1.0, 0.2)];
        let moved = warp(&rest, &[[0, 1, 0, 0]], &[[0.4, 0.6, 0.0, 0.0]], &[turn, turn]);
        assert!(moved[0].distance(turn.transform_point3(rest[0])) < 1e-6);
        let motion = motions(&[[0, 1, 0, 0]], &[[0.4, 0.6, 0.0, 0.0]], &[turn, turn]).next().unwrap();
        assert!(motion.turn().abs_diff_eq(Mat3::from(turn.matrix3), 1e-6));
    }

    #[test]
    fn a_twist_keeps_the_girth_that_linear_blending_loses() {
        let twist = Affine3A::from_rotation_x(3.0);
        let rest = [Vec3::new(0.0, 0.1, 0.0)];
        let half = warp(&rest, &[[0, 1, 0, 0]], &[[0.5, 0.5, 0.0, 0.0]], &[Affine3A::IDENTITY, twist]);
        let (sin, cos) = 1.5_f32.sin_cos();
        assert!(half[0].distance(0.1 * Vec3::new(0.0, cos, sin)) < 1e-6, "{}", half[0]);
    }
}
