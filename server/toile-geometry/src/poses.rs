//! The library of preset poses and motions (`model/artifacts/poses.json`).

use std::collections::{BTreeMap, BTreeSet};

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::body::Body;
use crate::pose::{Pose, PoseError};

/// Preset poses and motions, checked against a body.
#[derive(Clone, Debug)]
pub struct PoseLibrary {
    presets: Vec<Preset>,
    motions: Vec<MotionClip>,
}

/// A named pose.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct Preset {
    /// Identifier at the API, such as `contrapposto`.
    pub id: String,
    /// For people.
    pub label: String,
    /// What presets are grouped by on the page.
    pub group: String,
    /// The pose itself.
    #[serde(flatten)]
    pub pose: KeyPose,
}

/// A pose of humanoid joints.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
pub struct KeyPose {
    /// Humanoid joint -> local rotation, xyzw.
    pub rotations: BTreeMap<String, Quat>,
    /// What the hips move by from the A-pose, metres; y counts only where the body is not put on the floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub root_translation: Option<Vec3>,
}

/// A named sequence of poses.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct MotionClip {
    /// Identifier at the API, such as `walk`.
    pub id: String,
    /// For people.
    pub label: String,
    /// Frames a second.
    pub frame_rate: f32,
    /// One pose a frame.
    pub frames: Vec<KeyPose>,
}

/// Why a library cannot be read.
#[derive(Debug, Error)]
pub enum PoseLibraryError {
    /// Not the JSON it should be.
    #[error("pose library: {0}")]
    Json(#[from] serde_json::Error),
    /// A pose that the body cannot take.
    #[error("pose library: {id}: {source}")]
    Pose {
        /// Which preset or motion.
        id: String,
        /// What is wrong.
        source: PoseError,
    },
    /// Two of one name, an empty motion, or a number that is not finite.
    #[error("pose library: {id}: {reason}")]
    Invalid {
        /// Which preset or motion.
        id: String,
        /// What is wrong.
        reason: &'static str,
    },
}

/// The file as it is written.
#[derive(Deserialize)]
struct LibraryFile {
    poses: Vec<Preset>,
    motions: Vec<MotionClip>,
}

impl KeyPose {
    /// The pose of the body's joints, with its translation as it stands.
    ///
    /// # Errors
    /// [`PoseError`]; not for poses of a [`PoseLibrary`], which are checked.
    pub fn to_pose(&self, body: &Body) -> Result<Pose, PoseError> {
        let mut pose = Pose::from_humanoid(body, &self.rotations)?;
        pose.root_translation = self.root_translation.unwrap_or(Vec3::ZERO);
        Ok(pose)
    }
}

impl PoseLibrary {
    /// Reads a library and checks every pose against the body.
    ///
    /// # Errors
    /// [`PoseLibraryError`].
    pub fn from_json(bytes: &[u8], body: &Body) -> Result<Self, PoseLibraryError> {
        let file: LibraryFile = serde_json::from_slice(bytes)?;
        let out = Self { presets: file.poses, motions: file.motions };
        check_names(out.presets.iter().map(|p| p.id.as_str()))?;
        check_names(out.motions.iter().map(|m| m.id.as_str()))?;
        for preset in &out.presets {
            check_pose(&preset.id, &preset.pose, body)?;
        }
        for motion in &out.motions {
            if motion.frames.is_empty() || !(motion.frame_rate > 0.0 && motion.frame_rate.is_finite()) {
                return Err(invalid(&motion.id, "no frames, or a frame rate that is not positive"));
            }
            motion.frames.iter().try_for_each(|frame| check_pose(&motion.id, frame, body))?;
        }
        Ok(out)
    }

    /// All presets, in the order of the file.
    #[must_use]
    pub fn presets(&self) -> &[Preset] {
        &self.presets
    }

    /// All motions, in the order of the file.
    #[must_use]
    pub fn motions(&self) -> &[MotionClip] {
        &self.motions
    }

    /// A preset by identifier.
    #[must_use]
    pub fn preset(&self, id: &str) -> Option<&Preset> {
        self.presets.iter().find(|p| p.id == id)
    }

    /// A motion by identifier.
    #[must_use]
    pub fn motion(&self, id: &str) -> Option<&MotionClip> {
        self.motions.iter().find(|m| m.id == id)
    }
}

fn check_names<'a>(ids: impl Iterator<Item = &'a str>) -> Result<(), PoseLibraryError> {
    let mut seen = BTreeSet::new();
    for id in ids {
        if !seen.insert(id) {
            return Err(invalid(id, "twice in the library"));
        }
    }
    Ok(())
}

fn check_pose(id: &str, pose: &KeyPose, body: &Body) -> Result<(), PoseLibraryError> {
    let checked =
        pose.to_pose(body).map_err(|source| PoseLibraryError::Pose { id: id.to_owned(), source })?;
    if checked.root_translation.is_finite() {
        Ok(())
    } else {
        Err(invalid(id, "a translation that is not finite"))
    }
}

fn invalid(id: &str, reason: &'static str) -> PoseLibraryError {
    PoseLibraryError::Invalid { id: id.to_owned(), reason }
}
