//! From JSON to domain types: the only place where a request becomes a body shape, a pose, a motion.
//! The command line reads its files through the same types.

mod body;
mod output;
mod pose;

use serde::{Deserialize, Serialize};
use toile_drape::methods::MethodKind;
use toile_drape::pipeline::Motion;
use toile_geometry::body::BodyShape;
use toile_geometry::pose::Pose;

use crate::assets::Assets;
use crate::errors::{ApiError, Code};
use crate::json::escape;

use pose::from_library;

pub use body::BodyRequest;
pub use output::{Attribute, Detail, OutputRequest, Part};
pub use pose::PoseRequest;

/// Longest sequence.
pub const MAX_FRAMES: usize = 256;
/// The same for `garnet`, whose frames take a tenth of a second a garment.
const MAX_GARNET_FRAMES: usize = 64;
/// Frames a second where nothing is stated.
pub const DEFAULT_FRAME_RATE: f32 = 24.0;
const FRAME_RATES: std::ops::RangeInclusive<f32> = 1.0..=240.0;

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
        let most = if self.method()? == MethodKind::Garnet { MAX_GARNET_FRAMES } else { MAX_FRAMES };
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
        if frames > most {
            let detail = format!("The sequence has {frames} poses; at most {most} are draped at once.");
            return Err(ApiError::new(Code::TooManyFrames, detail).at("/poses"));
        }
        self.output.check_detail(self.poses.is_some() || self.motion.is_some())?;
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
        let (poses, own_rate) = self.poses(&shape, assets)?;
        Ok(Motion { shape, poses, frame_rate: self.frame_rate.unwrap_or(own_rate) })
    }

    /// Poses as asked for, and the frame rate that they come with.
    fn poses(&self, shape: &BodyShape, assets: &Assets) -> Result<(Vec<Pose>, f32), ApiError> {
        if let Some(id) = &self.motion {
            let clip = assets.poses.motion(id).ok_or_else(|| {
                let detail = format!("There is no motion named \"{id}\"; GET /v1/motions lists them.");
                ApiError::new(Code::UnknownMotion, detail).at("/motion")
            })?;
            let poses: Result<_, _> =
                clip.frames.iter().map(|frame| from_library(frame, shape, assets)).collect();
            return Ok((poses?, clip.frame_rate));
        }
        let poses = match (&self.poses, &self.pose) {
            (Some(poses), _) => poses
                .iter()
                .enumerate()
                .map(|(index, pose)| {
                    pose.pose(shape, assets).map_err(|error| error.under(&format!("/poses/{index}")))
                })
                .collect::<Result<_, _>>()?,
            (None, Some(pose)) => vec![pose.pose(shape, assets).map_err(|error| error.under("/pose"))?],
            (None, None) => vec![Pose::identity(assets.body())],
        };
        Ok((poses, DEFAULT_FRAME_RATE))
    }
}

/// A pointer to a member of the object at hand.
pub fn member(name: &str) -> String {
    format!("/{}", escape(name))
}

fn unused(field: &str, detail: &str) -> ApiError {
    ApiError::new(Code::UnknownField, detail).at(format!("/{field}"))
}
