//! The tensors of the body file, every access checked.

use glam::{Mat3A, Vec3A};
use safetensors::tensor::{Dtype, SafeTensors, TensorView};

use super::file::{BodyError, Meta, error, fail};
use super::phenotypes::{self, PhenotypeTerms};
use super::{JointFrames, ShapeBasis};
use crate::measurements::TapeSource;
use crate::skinning::SkinWeights;

/// Sizes that the tensors must agree on.
pub(super) struct Counts {
    pub vertices: usize,
    pub joints: usize,
    pub coefficients: usize,
}

impl Counts {
    pub fn of(file: &BodyFile<'_>, meta: &Meta) -> Result<Self, BodyError> {
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
pub(super) struct BodyFile<'a> {
    tensors: SafeTensors<'a>,
    /// The JSON under the key `toile`.
    pub metadata: Option<String>,
}

impl<'a> BodyFile<'a> {
    pub fn open(bytes: &'a [u8]) -> Result<Self, BodyError> {
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(|e| error(&e.to_string()))?;
        let metadata = header.metadata().as_ref().and_then(|m| m.get("toile")).cloned();
        let tensors = SafeTensors::deserialize(bytes).map_err(|e| error(&e.to_string()))?;
        Ok(Self { tensors, metadata })
    }

    fn tensor(&self, name: &str) -> Result<TensorView<'_>, BodyError> {
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

    pub fn floats(&self, name: &str, shape: &[usize]) -> Result<Vec<f32>, BodyError> {
        let (words, _) = self.data(name, Dtype::F32, shape)?.as_chunks::<4>();
        let out: Vec<f32> = words.iter().map(|&b| f32::from_le_bytes(b)).collect();
        if out.iter().any(|v| !v.is_finite()) {
            return fail(&format!("{name} holds numbers that are not finite"));
        }
        Ok(out)
    }

    /// Signed 32-bit integers that must not be negative.
    pub fn integers(&self, name: &str, shape: &[usize]) -> Result<Vec<u32>, BodyError> {
        let (words, _) = self.data(name, Dtype::I32, shape)?.as_chunks::<4>();
        let out: Result<Vec<u32>, _> = words.iter().map(|&b| u32::try_from(i32::from_le_bytes(b))).collect();
        out.map_err(|_| error(&format!("{name} holds negative numbers")))
    }

    pub fn parents(&self, counts: &Counts) -> Result<Vec<Option<usize>>, BodyError> {
        let (words, _) = self.data("joint_parents", Dtype::I32, &[counts.joints])?.as_chunks::<4>();
        Ok(words.iter().map(|&b| usize::try_from(i32::from_le_bytes(b)).ok()).collect())
    }

    pub fn triangles(&self, counts: &Counts) -> Result<Vec<[u32; 3]>, BodyError> {
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

    pub fn basis(&self, counts: &Counts) -> Result<ShapeBasis, BodyError> {
        let shape = [counts.coefficients, counts.vertices, 3];
        let (words, _) = self.data("shape_basis", Dtype::I16, &shape)?.as_chunks::<2>();
        let values: Vec<i16> = words.iter().map(|&b| i16::from_le_bytes(b)).collect();
        let steps = self.floats("shape_step", &[counts.coefficients])?;
        ShapeBasis::pack(&values, steps).ok_or_else(|| error("shape_basis and shape_step do not fit"))
    }

    pub fn joint_frames(&self, counts: &Counts) -> Result<(JointFrames, Vec<JointFrames>), BodyError> {
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

    pub fn skin(&self, counts: &Counts) -> Result<SkinWeights, BodyError> {
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

    /// The tapes, with the kinds that the metadata gives.
    pub fn tapes(&self, counts: &Counts, meta: &Meta) -> Result<TapeSource, BodyError> {
        let points = self.rows::<2>("measure_points", counts.vertices)?;
        let along = self.floats("measure_t", &[points.len()])?;
        let ranges = self.rows::<2>("measure_ranges", points.len() + 1)?;
        if ranges.len() != meta.measurements.len() {
            return fail("as many measure_ranges as measurements there are not");
        }
        let kinds = meta.measurements.iter().map(|m| m.kind);
        let coarse = self.integers("volume_vertices", self.tensor("volume_vertices")?.shape())?;
        if coarse.iter().any(|&v| v as usize >= counts.vertices) {
            return fail("volume_vertices name vertices that there are not");
        }
        Ok(TapeSource {
            points: points.into_iter().zip(along).collect(),
            tapes: kinds.zip(ranges.iter().map(|[a, b]| *a as usize..*b as usize)).collect(),
            triangles: self.rows::<3>("volume_triangles", coarse.len())?,
            coarse,
            fit: meta.volume,
        })
    }

    /// Rows of `N` signed 32-bit integers, each below `limit`.
    fn rows<const N: usize>(&self, name: &str, limit: usize) -> Result<Vec<[u32; N]>, BodyError> {
        let &[count, _] = self.tensor(name)?.shape() else { return fail(&format!("{name} is not a matrix")) };
        let values = self.integers(name, &[count, N])?;
        if values.iter().any(|&v| v as usize >= limit) {
            return fail(&format!("{name} holds a number that is not below {limit}"));
        }
        Ok(values.as_chunks::<N>().0.to_vec())
    }

    pub fn terms(&self, counts: &Counts, anchors: &[String]) -> Result<PhenotypeTerms, BodyError> {
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
        Ok(PhenotypeTerms {
            terms: masked.collect(),
            projection: self.floats("phenotype_projection", &shape)?,
            phenotype_coefficients: driven,
        })
    }
}

/// Row-major 3×3 matrices.
pub(super) fn matrices(values: &[f32]) -> Vec<Mat3A> {
    let (rows, _) = values.as_chunks::<3>();
    let (matrices, _) = rows.as_chunks::<3>();
    matrices.iter().map(|m| Mat3A::from_cols(m[0].into(), m[1].into(), m[2].into()).transpose()).collect()
}
