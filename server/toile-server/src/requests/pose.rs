//! In which pose.

use std::collections::BTreeMap;

use glam::{Quat, Vec4};
use serde::{Deserialize, Serialize};
use toile_geometry::body::BodyShape;
use toile_geometry::pose::Pose;
use toile_geometry::poses::KeyPose;

use crate::assets::Assets;
use crate::errors::{ApiError, Code};

use super::unused;

/// How a pose is described.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PoseKind {
    /// By the name of a preset.
    Preset,
    /// By joint rotations.
    Joints,
}

/// A pose.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PoseRequest {
    kind: PoseKind,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    id: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rotations: Option<BTreeMap<String, [f32; 4]>>,
}

impl PoseRequest {
    /// A preset by name.
    pub fn preset(id: &str) -> Self {
        Self { kind: PoseKind::Preset, id: Some(id.to_owned()), rotations: None }
    }

    /// On a body of `shape`: presets give the arms of a wider body more room, joints are taken as they are.
    pub(super) fn pose(&self, shape: &BodyShape, assets: &Assets) -> Result<Pose, ApiError> {
        match (self.kind, &self.id, &self.rotations) {
            (PoseKind::Preset, Some(id), None) => {
                let preset = assets.poses.preset(id).ok_or_else(|| unknown_pose(id))?;
                from_library(&preset.pose, shape, assets)
            }
            (PoseKind::Joints, None, Some(rotations)) => {
                let rotations =
                    rotations.iter().map(|(name, &q)| (name.clone(), Quat::from_vec4(Vec4::from(q))));
                let pose = Pose::from_humanoid(assets.body(), &rotations.collect());
                pose.map_err(|error| ApiError::from(error).under("/rotations"))
            }
            (PoseKind::Preset, None, _) => {
                Err(ApiError::new(Code::MissingField, "A preset pose needs its `id`."))
            }
            (PoseKind::Joints, _, None) => {
                Err(ApiError::new(Code::MissingField, "A pose of joints needs `rotations`."))
            }
            (PoseKind::Preset, ..) => Err(unused("rotations", "A preset pose has no `rotations`.")),
            (PoseKind::Joints, ..) => Err(unused("id", "A pose of joints has no `id`.")),
        }
    }
}

fn unknown_pose(id: &str) -> ApiError {
    let detail = format!("There is no pose named \"{id}\"; GET /v1/poses lists them.");
    ApiError::new(Code::UnknownPose, detail).at("/id")
}

/// Poses of the library were checked when it was read.
pub(super) fn from_library(pose: &KeyPose, shape: &BodyShape, assets: &Assets) -> Result<Pose, ApiError> {
    let pose = pose.to_pose(assets.body()).map_err(ApiError::internal)?;
    Ok(assets.studio.arm_room.given(assets.body(), &assets.shaped(shape), pose))
}
