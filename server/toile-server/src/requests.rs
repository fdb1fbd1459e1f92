//! From JSON to domain types: the only place where a request becomes a body shape, a pose, a motion.
//! The command line reads its files through the same types.

use std::collections::{BTreeMap, BTreeSet};

use glam::{Quat, Vec4};
use serde::{Deserialize, Serialize};
use toile_drape::methods::MethodKind;
use toile_drape::pipeline::Motion;
use toile_geometry::body::BodyShape;
use toile_geometry::pose::Pose;
use toile_geometry::poses::KeyPose;

use crate::assets::Assets;
use crate::errors::{ApiError, Code};
use crate::json::escape;

/// Longest sequence.
pub const MAX_FRAMES: usize = 256;
/// Frames a second where nothing is stated.
pub const DEFAULT_FRAME_RATE: f32 = 24.0;
const FRAME_RATES: std::ops::RangeInclusive<f32> = 1.0..=240.0;

/// How a body is described.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BodyKind {
    /// By phenotypes and local changes.
    Phenotypes,
    /// By a tailor's measurements.
    Measurements,
}

/// A body.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BodyRequest {
    kind: BodyKind,
    #[serde(default)]
    values: BTreeMap<String, f32>,
}

impl BodyRequest {
    /// Phenotypes and local changes that another request may use.
    pub fn of_shape(shape: &BodyShape, assets: &Assets) -> Self {
        Self { kind: BodyKind::Phenotypes, values: shape.values(assets.body()) }
    }

    /// The shape. Solving measurements takes milliseconds: not for a tokio thread.
    ///
    /// # Errors
    /// When a name is not known, a value is out of range or no body has the measurements.
    pub fn shape(&self, assets: &Assets) -> Result<BodyShape, ApiError> {
        let shape = match self.kind {
            BodyKind::Phenotypes => {
                BodyShape::from_values(assets.body(), &self.values).map_err(ApiError::from)
            }
            BodyKind::Measurements => crate::measurements::solve(assets, &self.values, &BTreeMap::new())
                .map(|solution| solution.shape),
        };
        shape.map_err(|error| error.under("/values"))
    }
}

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

    fn pose(&self, assets: &Assets) -> Result<Pose, ApiError> {
        match (self.kind, &self.id, &self.rotations) {
            (PoseKind::Preset, Some(id), None) => {
                let preset = assets.poses.preset(id).ok_or_else(|| unknown_pose(id))?;
                from_library(&preset.pose, assets)
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

fn unused(field: &str, detail: &str) -> ApiError {
    ApiError::new(Code::UnknownField, detail).at(format!("/{field}"))
}

fn unknown_pose(id: &str) -> ApiError {
    let detail = format!("There is no pose named \"{id}\"; GET /v1/poses lists them.");
    ApiError::new(Code::UnknownPose, detail).at("/id")
}

/// A part of the answer.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Ord, PartialEq, PartialOrd, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// The draped garments.
    Outfit,
    /// The posed body.
    Body,
}

/// A figure for every vertex.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Ord, PartialEq, PartialOrd, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Attribute {
    /// `_STRAIN`
    Strain,
    /// `_PENETRATION`
    Penetration,
}

/// What the answer holds.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutputRequest {
    /// Parts of the scene.
    pub include: BTreeSet<Part>,
    /// Name of the method.
    method: String,
    /// Figures for every vertex.
    pub attributes: BTreeSet<Attribute>,
    /// Whether the outfit's pictures are embedded.
    pub textures: bool,
}

impl Default for OutputRequest {
    fn default() -> Self {
        let include = BTreeSet::from([Part::Outfit]);
        Self { include, method: MethodKind::Deepsd.to_string(), attributes: BTreeSet::new(), textures: true }
    }
}

/// A request to drape an outfit.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DrapeBody {
    /// Id of the outfit.
    pub outfit: String,
    /// Who wears it.
    #[serde(default)]
    pub body: Option<BodyRequest>,
    /// One pose …
    #[serde(default)]
    pub pose: Option<PoseRequest>,
    /// … or several …
    #[serde(default)]
    pub poses: Option<Vec<PoseRequest>>,
    /// … or those of a motion.
    #[serde(default)]
    pub motion: Option<String>,
    /// Of a sequence.
    #[serde(default)]
    pub frame_rate: Option<f32>,
    /// What the answer holds.
    #[serde(default)]
    pub output: OutputRequest,
}

impl DrapeBody {
    /// One pose of an outfit, everything else by default.
    pub fn single(outfit: &str, body: Option<BodyRequest>, pose: Option<PoseRequest>) -> Self {
        let output = OutputRequest::default();
        Self { outfit: outfit.to_owned(), body, pose, poses: None, motion: None, frame_rate: None, output }
    }

    /// The method by name.
    ///
    /// # Errors
    /// `invalid-field` when there is no such method.
    pub fn method(&self) -> Result<MethodKind, ApiError> {
        self.output.method.parse().map_err(|_| {
            let known: Vec<String> = MethodKind::ALL.iter().map(ToString::to_string).collect();
            let detail =
                format!("There is no method \"{}\"; use one of {}.", self.output.method, known.join(", "));
            ApiError::new(Code::InvalidField, detail).at("/output/method")
        })
    }

    /// Sets the method by name, as from a command line.
    pub fn set_method(&mut self, name: &str) {
        name.clone_into(&mut self.output.method);
    }

    /// Refuses what can be refused without looking at outfit or body.
    ///
    /// # Errors
    /// When fields contradict each other or a sequence is empty or too long.
    pub fn check(&self) -> Result<(), ApiError> {
        self.method()?;
        if self.output.include.is_empty() {
            return Err(ApiError::new(Code::InvalidField, "Include at least one part.").at("/output/include"));
        }
        let stated = [
            ("/pose", self.pose.is_some()),
            ("/poses", self.poses.is_some()),
            ("/motion", self.motion.is_some()),
        ];
        if let Some((pointer, _)) = stated.iter().filter(|(_, is_some)| *is_some).nth(1) {
            let detail = "State one of `pose`, `poses` and `motion`.";
            return Err(ApiError::new(Code::InvalidField, detail).at(*pointer));
        }
        let frames = self.poses.as_ref().map_or(1, Vec::len);
        if frames == 0 {
            return Err(ApiError::new(Code::EmptySequence, "Give at least one pose.").at("/poses"));
        }
        if frames > MAX_FRAMES {
            let detail = format!("The sequence has {frames} poses; at most {MAX_FRAMES} are draped at once.");
            return Err(ApiError::new(Code::TooManyFrames, detail).at("/poses"));
        }
        self.check_frame_rate()
    }

    fn check_frame_rate(&self) -> Result<(), ApiError> {
        let invalid = |detail: &str| Err(ApiError::new(Code::InvalidField, detail).at("/frame_rate"));
        match self.frame_rate {
            Some(_) if self.poses.is_none() && self.motion.is_none() => {
                invalid("A single pose has no frame rate.")
            }
            Some(rate) if !FRAME_RATES.contains(&rate) => {
                invalid("The frame rate must be between 1 and 240.")
            }
            _ => Ok(()),
        }
    }

    /// Body and poses. Takes milliseconds: not for a tokio thread.
    ///
    /// # Errors
    /// When body or pose is refused.
    pub fn motion(&self, assets: &Assets) -> Result<Motion, ApiError> {
        let shape = match &self.body {
            Some(body) => body.shape(assets).map_err(|error| error.under("/body"))?,
            None => BodyShape::default(),
        };
        let (poses, own_rate) = self.poses(assets)?;
        Ok(Motion { shape, poses, frame_rate: self.frame_rate.unwrap_or(own_rate) })
    }

    /// Poses as asked for, and the frame rate that they come with.
    fn poses(&self, assets: &Assets) -> Result<(Vec<Pose>, f32), ApiError> {
        if let Some(id) = &self.motion {
            let clip = assets.poses.motion(id).ok_or_else(|| {
                let detail = format!("There is no motion named \"{id}\"; GET /v1/motions lists them.");
                ApiError::new(Code::UnknownMotion, detail).at("/motion")
            })?;
            let poses: Result<_, _> = clip.frames.iter().map(|frame| from_library(frame, assets)).collect();
            return Ok((poses?, clip.frame_rate));
        }
        let poses = match (&self.poses, &self.pose) {
            (Some(poses), _) => poses
                .iter()
                .enumerate()
                .map(|(index, pose)| {
                    pose.pose(assets).map_err(|error| error.under(&format!("/poses/{index}")))
                })
                .collect::<Result<_, _>>()?,
            (None, Some(pose)) => vec![pose.pose(assets).map_err(|error| error.under("/pose"))?],
            (None, None) => vec![Pose::identity(assets.body())],
        };
        Ok((poses, DEFAULT_FRAME_RATE))
    }
}

/// Poses of the library were checked when it was read.
fn from_library(pose: &KeyPose, assets: &Assets) -> Result<Pose, ApiError> {
    pose.to_pose(assets.body()).map_err(ApiError::internal)
}

/// A pointer to a member of the object at hand.
pub fn member(name: &str) -> String {
    format!("/{}", escape(name))
}
