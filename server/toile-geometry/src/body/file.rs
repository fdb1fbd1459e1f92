//! Reading the baked body, checked: a wrong file is an error, never a panic.

use std::collections::BTreeMap;

use serde::Deserialize;
use thiserror::Error;

use super::phenotypes::{self, LOCAL_CHANGES};
use super::tensors::{BodyFile, Counts, matrices};
use super::{Body, REFERENCE_AGE};
use crate::measurements::{Measurement, MeasurementInfo, Tape, TapeKind, VolumeFit};
use crate::skeleton::{HumanoidSource, Skeleton};

/// The version of the format that this reads.
const FORMAT: &str = "toile-body/1";

/// Why a body cannot be read, or a shape cannot be made.
#[derive(Debug, Error)]
pub enum BodyError {
    /// The body file is not what it should be.
    #[error("body file: {0}")]
    File(String),
    /// There is no phenotype and no local change of this name.
    #[error("there is no phenotype or local change named {name:?}")]
    UnknownPhenotype {
        /// The name asked for.
        name: String,
    },
    /// A phenotype or local change is outside its range, or not a number.
    #[error("{name} is {value}; it must be between {min} and {max}")]
    PhenotypeOutOfRange {
        /// The parameter.
        name: String,
        /// The value asked for.
        value: f32,
        /// Smallest value.
        min: f32,
        /// Largest value.
        max: f32,
    },
}

/// The JSON under the key `toile` of the file's metadata.
#[derive(Deserialize)]
pub(super) struct Meta {
    format: String,
    pub joints: Vec<String>,
    humanoid: BTreeMap<String, Vec<String>>,
    bone_axes: BTreeMap<String, [f32; 3]>,
    phenotypes: Vec<String>,
    anchors: Vec<String>,
    local_changes: Vec<String>,
    reference_age: f32,
    pub measurements: Vec<MeasurementEntry>,
    pub volume: VolumeFit,
}

/// A measurement, and how its tape measures.
#[derive(Deserialize)]
pub(super) struct MeasurementEntry {
    #[serde(flatten)]
    info: MeasurementInfo,
    pub kind: TapeKind,
}

impl Meta {
    fn read(text: Option<&str>) -> Result<Self, BodyError> {
        let text = text.ok_or_else(|| error("no metadata"))?;
        let meta: Self = serde_json::from_str(text).map_err(|e| error(&format!("metadata: {e}")))?;
        if meta.format != FORMAT {
            return fail(&format!("format is {:?}, not {FORMAT:?}", meta.format));
        }
        if meta.phenotypes != phenotypes::names() || meta.local_changes.len() != LOCAL_CHANGES {
            return fail("other phenotypes or local changes than this program knows");
        }
        if !meta.measurements.iter().map(|m| m.info.name.as_str()).eq(Measurement::ALL.map(Measurement::name))
        {
            return fail("other measurements than this program knows");
        }
        if (meta.reference_age - REFERENCE_AGE).abs() > 1e-6 {
            return fail("another reference age than this program knows");
        }
        Ok(meta)
    }
}

impl Body {
    /// Reads `body.safetensors`.
    ///
    /// # Errors
    /// [`BodyError::File`] when a tensor is missing or of another shape or type, an index is out of
    /// range, a number is not finite, or the names are not those that this code knows.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, BodyError> {
        let file = BodyFile::open(bytes)?;
        let meta = Meta::read(file.metadata.as_deref())?;
        let counts = Counts::of(&file, &meta)?;
        let garment_of: Vec<u32> = file.integers("garment_joint", &[counts.joints])?;
        let skin = file.skin(&counts)?;
        let garment_skin =
            skin.folded(&garment_of).ok_or_else(|| error("garment joints do not fit the skin"))?;
        let (joint_template, joint_basis) = file.joint_frames(&counts)?;
        let terms = file.terms(&counts, &meta.anchors)?;
        if terms.coefficient_count() != counts.coefficients {
            return fail("phenotypes and local changes do not add up to the shape basis");
        }
        let (template, basis) =
            (file.floats("template_vertices", &[counts.vertices, 3])?, file.basis(&counts)?);
        let tape = Tape::new(file.tapes(&counts, &meta)?, &template, &basis);
        let humanoid = HumanoidSource { joints: meta.humanoid, bone_axes: meta.bone_axes };
        Ok(Self {
            skeleton: Skeleton::new(meta.joints, file.parents(&counts)?, &garment_of, &humanoid)
                .map_err(BodyError::File)?,
            phenotype_names: meta.phenotypes,
            local_change_names: meta.local_changes,
            terms,
            template,
            basis,
            tape: tape.ok_or_else(|| error("the tapes do not fit the body"))?,
            measurements: meta.measurements.into_iter().map(|m| m.info).collect(),
            joint_template,
            joint_basis,
            reference_orientation: matrices(&file.floats("reference_orientation", &[counts.joints, 3, 3])?),
            garment_skin,
            skin,
            triangles: file.triangles(&counts)?,
        })
    }
}

pub(super) fn error(reason: &str) -> BodyError {
    BodyError::File(reason.to_owned())
}

pub(super) fn fail<T>(reason: &str) -> Result<T, BodyError> {
    Err(error(reason))
}
