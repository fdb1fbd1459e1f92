//! Poses.

use std::collections::BTreeMap;

use glam::{Quat, Vec3};
use thiserror::Error;

use crate::body::Body;

/// How far from 1 the length of a quaternion may be: numbers rounded to three digits still pass.
const UNIT_TOLERANCE: f32 = 2e-3;

/// A pose of all joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// One rotation a joint, local to the joint's parent, about axes parallel to the world's in the A-pose.
    pub rotations: Vec<Quat>,
    /// What the root moves by from where it is in the A-pose, metres.
    pub root_translation: Vec3,
}

/// Why rotations are no pose.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PoseError {
    /// No humanoid joint has this name.
    #[error("there is no joint named {name:?}")]
    UnknownJoint {
        /// The name asked for.
        name: String,
    },
    /// The quaternion is no rotation.
    #[error("the quaternion of {name} has length {length}; it must be 1")]
    NonUnit {
        /// The joint.
        name: String,
        /// The quaternion's length.
        length: f32,
    },
}

impl Pose {
    /// The A-pose.
    #[must_use]
    pub fn identity(body: &Body) -> Self {
        Self { rotations: vec![Quat::IDENTITY; body.joint_names().len()], root_translation: Vec3::ZERO }
    }

    /// A pose of rotations of humanoid joints; joints not named stay as in the A-pose.
    ///
    /// # Errors
    /// [`PoseError`] for a name that there is not, and for a quaternion that is not of length 1.
    pub fn from_humanoid(body: &Body, rotations: &BTreeMap<String, Quat>) -> Result<Self, PoseError> {
        let mut out = Self::identity(body);
        for (name, &q) in rotations {
            let length = q.length();
            if !(1.0 - UNIT_TOLERANCE..=1.0 + UNIT_TOLERANCE).contains(&length) {
                return Err(PoseError::NonUnit { name: name.clone(), length });
            }
            if !body.skeleton().set_humanoid(&mut out.rotations, name, q.normalize()) {
                return Err(PoseError::UnknownJoint { name: name.clone() });
            }
        }
        Ok(out)
    }
}
