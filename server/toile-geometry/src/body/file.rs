//! Reading the baked body, checked: a wrong file is an error, never a panic.

use std::collections::BTreeMap;

use glam::{Mat3A, Vec3A};
use safetensors::tensor::{Dtype, SafeTensors};
use serde::Deserialize;
use thiserror::Error;

use super::phenotypes::{self, LOCAL_CHANGES, PhenotypeTerms};
use super::{Body, JointFrames, REFERENCE_AGE, ShapeBasis};
use crate::skeleton::{HumanoidSource, Skeleton};
use crate::skinning::SkinWeights;

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
struct Meta {
    format: String,
    joints: Vec<String>,
    humanoid: BTreeMap<String, Vec<String>>,
    bone_axes: BTreeMap<String, [f32; 3]>,
    phenotypes: Vec<String>,
    anchors: Vec<String>,
    local_changes: Vec<String>,
    reference_age: f32,
}

impl Body {
    /// Reads `body.safetensors`.
    ///
    /// # Errors
    /// [`BodyError::File`] when a tensor is missing or of another shape or type, an index is out of
    /// range, a number is not finite, or the names are not those that this code knows.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Self, BodyError> {
        let file = BodyFile::open(bytes)?;
        let meta = file.meta()?;
        let counts = Counts::of(&file, &meta)?;
        let parents = file.parents(&counts)?;
        let humanoid = HumanoidSource { joints: meta.humanoid, bone_axes: meta.bone_axes };
        let garment_of: Vec<u32> = file.integers("garment_joint", &[counts.joints])?;
        let skeleton =
            Skeleton::new(meta.joints, parents, &garment_of, &humanoid).map_err(BodyError::File)?;
        let skin = file.skin(&counts)?;
        let (joint_template, joint_basis) = file.joint_frames(&counts)?;
        let terms = file.terms(&counts, &meta.anchors)?;
        if terms.coefficient_count() != counts.coefficients {
            return fail("phenotypes and local changes do not add up to the shape basis");
        }
        let garment_skin =
            skin.folded(&garment_of).ok_or_else(|| error("garment joints do not fit the skin"))?;
        Ok(Self {
            phenotype_names: meta.phenotypes,
            local_change_names: meta.local_changes,
            terms,
            template: file.floats("template_vertices", &[counts.vertices, 3])?,
            basis: file.basis(&counts)?,
            joint_template,
            joint_basis,
            reference_orientation: matrices(&file.floats("reference_orientation", &[counts.joints, 3, 3])?),
            garment_skin,
            skin,
            triangles: file.triangles(&counts)?,
            skeleton,
        })
    }
}

/// Sizes that the tensors must agree on.
struct Counts {
    vertices: usize,
    joints: usize,
    coefficients: usize,
}

impl Counts {
    fn of(file: &BodyFile<'_>, meta: &Meta) -> Result<Self, BodyError> {
        let basis = file.tensor("shape_basis")?;
        let &[coefficients, vertices, 3] = basis.shape() else {
            return fail("shape_basis is not (coefficients, vertices, 3)");
        };
        if vertices == 0 || coefficients == 0 || meta.joints.is_empty() {
            return fail("no vertices, coefficients or joints");
        }
        Ok(Self { vertices, joints: meta.joints.len(), coefficients })
    }
}

/// The tensors, with every access checked.
struct BodyFile<'a> {
    tensors: SafeTensors<'a>,
    metadata: Option<String>,
}

impl<'a> BodyFile<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, BodyError> {
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(|e| error(&e.to_string()))?;
        let metadata = header.metadata().as_ref().and_then(|m| m.get("toile")).cloned();
        let tensors = SafeTensors::deserialize(bytes).map_err(|e| error(&e.to_string()))?;
        Ok(Self { tensors, metadata })
    }

    fn meta(&self) -> Result<Meta, BodyError> {
        let text = self.metadata.as_deref().ok_or_else(|| error("no metadata"))?;
        let meta: Meta = serde_json::from_str(text).map_err(|e| error(&format!("metadata: {e}")))?;
        if meta.format != FORMAT {
            return fail(&format!("format is {:?}, not {FORMAT:?}", meta.format));
        }
        if meta.phenotypes != phenotypes::names() || meta.local_changes.len() != LOCAL_CHANGES {
            return fail("other phenotypes or local changes than this program knows");
        }
        if (meta.reference_age - REFERENCE_AGE).abs() > 1e-6 {
            return fail("another reference age than this program knows");
        }
        Ok(meta)
    }

    fn tensor(&self, name: &str) -> Result<safetensors::tensor::TensorView<'_>, BodyError> {
        self.tensors.tensor(name).map_err(|e| error(&format!("{name}: {e}")))
    }

    /// The little-endian bytes of a tensor of this type and shape.
    fn data(&self, name: &str, dtype: Dtype, shape: &[usize]) -> Result<&[u8], BodyError> {
        let tensor = self.tensor(name)?;
        if tensor.dtype() != dtype || tensor.shape() != shape {
            let (found, at) = (tensor.dtype(), tensor.shape());
            return fail(&format!("{name} is {found:?} {at:?}, not {dtype:?} {shape:?}"));
        }
        self.tensors.tensor(name).map(|t| t.data()).map_err(|e| error(&format!("{name}: {e}")))
    }

    fn floats(&self, name: &str, shape: &[usize]) -> Result<Vec<f32>, BodyError> {
        let (words, _) = self.data(name, Dtype::F32, shape)?.as_chunks::<4>();
        let out: Vec<f32> = words.iter().map(|&b| f32::from_le_bytes(b)).collect();
        if out.iter().any(|v| !v.is_finite()) {
            return fail(&format!("{name} holds numbers that are not finite"));
        }
        Ok(out)
    }

    /// Signed 32-bit integers that must not be negative.
    fn integers(&self, name: &str, shape: &[usize]) -> Result<Vec<u32>, BodyError> {
        let (words, _) = self.data(name, Dtype::I32, shape)?.as_chunks::<4>();
        let out: Result<Vec<u32>, _> = words.iter().map(|&b| u32::try_from(i32::from_le_bytes(b))).collect();
        out.map_err(|_| error(&format!("{name} holds negative numbers")))
    }

    fn parents(&self, counts: &Counts) -> Result<Vec<Option<usize>>, BodyError> {
        let (words, _) = self.data("joint_parents", Dtype::I32, &[counts.joints])?.as_chunks::<4>();
        Ok(words.iter().map(|&b| usize::try_from(i32::from_le_bytes(b)).ok()).collect())
    }

    fn triangles(&self, counts: &Counts) -> Result<Vec<[u32; 3]>, BodyError> {
        let shape = self.tensor("triangles")?.shape().to_vec();
        let &[_, 3] = shape.as_slice() else { return fail("triangles are not (triangles, 3)") };
        let (words, _) = self.data("triangles", Dtype::U32, &shape)?.as_chunks::<4>();
        let (corners, _) = words.as_chunks::<3>();
        let out: Vec<[u32; 3]> = corners.iter().map(|t| t.map(u32::from_le_bytes)).collect();
        if out.iter().flatten().any(|&v| v as usize >= counts.vertices) {
            return fail("triangles name vertices that there are not");
        }
        Ok(out)
    }

    fn basis(&self, counts: &Counts) -> Result<ShapeBasis, BodyError> {
        let shape = [counts.coefficients, counts.vertices, 3];
        let (words, _) = self.data("shape_basis", Dtype::I16, &shape)?.as_chunks::<2>();
        let values: Vec<i16> = words.iter().map(|&b| i16::from_le_bytes(b)).collect();
        let steps = self.floats("shape_step", &[counts.coefficients])?;
        ShapeBasis::pack(&values, steps).ok_or_else(|| error("shape_basis and shape_step do not fit"))
    }

    fn joint_frames(&self, counts: &Counts) -> Result<(JointFrames, Vec<JointFrames>), BodyError> {
        let (joints, k) = (counts.joints, counts.coefficients);
        let frames = |heads: &[f32], orientations: &[f32]| JointFrames {
            heads: heads.chunks_exact(3).map(Vec3A::from_slice).collect(),
            orientations: matrices(orientations),
        };
        let template = frames(
            &self.floats("joint_heads", &[joints, 3])?,
            &self.floats("joint_orientation", &[joints, 3, 3])?,
        );
        let heads = self.floats("joint_heads_basis", &[k, joints, 3])?;
        let orientations = self.floats("joint_orientation_basis", &[k, joints, 3, 3])?;
        let rows = heads.chunks_exact(joints * 3).zip(orientations.chunks_exact(joints * 9));
        Ok((template, rows.map(|(h, o)| frames(h, o)).collect()))
    }

    fn skin(&self, counts: &Counts) -> Result<SkinWeights, BodyError> {
        let shape = self.tensor("skin_weights")?.shape().to_vec();
        let &[_, influences] = shape.as_slice() else {
            return fail("skin_weights are not (vertices, influences)");
        };
        let shape = [counts.vertices, influences];
        let weights = self.floats("skin_weights", &shape)?;
        let (words, _) = self.data("skin_joints", Dtype::U16, &shape)?.as_chunks::<2>();
        let joints: Vec<u16> = words.iter().map(|&b| u16::from_le_bytes(b)).collect();
        SkinWeights::from_dense(&joints, &weights, influences, counts.joints)
            .ok_or_else(|| error("skin weights name joints that there are not, or are empty"))
    }

    fn terms(&self, counts: &Counts, anchors: &[String]) -> Result<PhenotypeTerms, BodyError> {
        let known: Option<Vec<_>> = anchors.iter().map(|a| phenotypes::anchor(a)).collect();
        let known = known.ok_or_else(|| error("anchors that this program does not know"))?;
        let shape = self.tensor("phenotype_projection")?.shape().to_vec();
        let &[terms, driven] = shape.as_slice() else { return fail("phenotype_projection is not a matrix") };
        if driven == 0 || driven > counts.coefficients || known.is_empty() {
            return fail("phenotype_projection does not fit the shape basis");
        }
        let mask = self.data("phenotype_mask", Dtype::U8, &[terms, known.len()])?;
        let masked = mask.chunks_exact(known.len()).map(|row| {
            row.iter().zip(&known).filter(|(on, _)| **on != 0).map(|(_, &anchor)| anchor).collect::<Vec<_>>()
        });
        let factors = self.floats("phenotype_projection", &shape)?;
        let projection = factors.iter().enumerate().filter(|(_, f)| **f != 0.0);
        Ok(PhenotypeTerms {
            terms: masked.collect(),
            projection: projection.map(|(i, &f)| (i / driven, i % driven, f64::from(f))).collect(),
            phenotype_coefficients: driven,
        })
    }
}

/// Row-major 3×3 matrices.
fn matrices(values: &[f32]) -> Vec<Mat3A> {
    let (rows, _) = values.as_chunks::<3>();
    let (matrices, _) = rows.as_chunks::<3>();
    matrices.iter().map(|m| Mat3A::from_cols(m[0].into(), m[1].into(), m[2].into()).transpose()).collect()
}

fn error(reason: &str) -> BodyError {
    BodyError::File(reason.to_owned())
}

fn fail<T>(reason: &str) -> Result<T, BodyError> {
    Err(error(reason))
}
