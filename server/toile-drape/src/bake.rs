//! A bake: one outfit's basis and blend weights, refined beyond what the networks say of it (`model/bake.py`).

use bytemuck::Pod;
use safetensors::{Dtype, SafeTensors};
use thiserror::Error;

use crate::reference::GARMENT_JOINTS;
use crate::static_pass::{INFLUENCES, StaticPass};

/// How far the weights of a vertex may sum from 1.
const ROUNDING: f32 = 1e-3;
/// The largest entry of a basis, metres for a coefficient of 1.
const LARGEST: f32 = 10.0;

/// Why a bake cannot be used.
#[derive(Debug, Error)]
pub enum BakeError {
    /// The container.
    #[error("it is not a safetensors file: {0}")]
    Container(String),
    /// A tensor is missing, or of another type or size.
    #[error("tensor `{name}` must hold {expected} values of type {dtype:?}")]
    Tensor {
        /// Its name.
        name: &'static str,
        /// Its type.
        dtype: Dtype,
        /// Values that this outfit needs.
        expected: usize,
    },
    /// A basis that is not finite or absurdly large.
    #[error("tensor `basis` must be finite and below {LARGEST} m")]
    Basis,
    /// Blend weights that are none.
    #[error("tensor `weights` must be positive and sum to 1 at every vertex")]
    Weights,
    /// A joint that does not exist.
    #[error("tensor `joints` must be below {GARMENT_JOINTS}")]
    Joints,
}

/// What replaces the networks' answers for one outfit.
#[derive(Clone, Debug, PartialEq)]
pub struct Bake {
    basis: Vec<f32>,
    joints: Vec<[u8; INFLUENCES]>,
    weights: Vec<[f32; INFLUENCES]>,
}

impl Bake {
    /// Reads tensors `basis` (BASIS, 3 x nodes) float32, `joints` (vertices, 4) uint8 and `weights` (vertices, 4)
    /// float32 of a safetensors file, as [`crate::static_pass::Rig`] has them.
    ///
    /// # Errors
    /// When a tensor does not fit the static pass that it refines, or its values cannot be used.
    pub fn from_bytes(bytes: &[u8], statics: &StaticPass) -> Result<Self, BakeError> {
        let file = SafeTensors::deserialize(bytes).map_err(|e| BakeError::Container(e.to_string()))?;
        let influences = INFLUENCES * statics.rest.len();
        let basis: Vec<f32> = column(&file, "basis", Dtype::F32, statics.rig.basis.len())?;
        let joints: Vec<u8> = column(&file, "joints", Dtype::U8, influences)?;
        let weights: Vec<f32> = column(&file, "weights", Dtype::F32, influences)?;
        let (joints, weights) = (joints.as_chunks::<INFLUENCES>().0, weights.as_chunks::<INFLUENCES>().0);
        // A comparison with NaN is false, so these refuse it.
        if !basis.iter().all(|b| b.abs() < LARGEST) {
            return Err(BakeError::Basis);
        }
        if !joints.as_flattened().iter().all(|&j| usize::from(j) < GARMENT_JOINTS) {
            return Err(BakeError::Joints);
        }
        let is_blend = |w: &[f32; INFLUENCES]| {
            w.iter().all(|w| *w >= 0.0) && (w.iter().sum::<f32>() - 1.0).abs() < ROUNDING
        };
        if !weights.iter().all(is_blend) {
            return Err(BakeError::Weights);
        }
        Ok(Self { basis, joints: joints.to_vec(), weights: weights.to_vec() })
    }
}

impl StaticPass {
    /// The static pass with a bake in the place of the networks' answers.
    #[must_use]
    pub fn baked(mut self, bake: Bake) -> Self {
        (self.rig.basis, self.rig.joints, self.rig.weights) = (bake.basis, bake.joints, bake.weights);
        self
    }
}

fn column<T: Pod>(
    file: &SafeTensors<'_>,
    name: &'static str,
    dtype: Dtype,
    expected: usize,
) -> Result<Vec<T>, BakeError> {
    let wrong = || BakeError::Tensor { name, dtype, expected };
    let view = file.tensor(name).map_err(|_| wrong())?;
    if view.dtype() != dtype || view.data().len() != expected * size_of::<T>() {
        return Err(wrong());
    }
    Ok(bytemuck::allocation::pod_collect_to_vec(view.data()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::deepsd::BASIS;
    use crate::static_pass::Rig;
    use glam::Vec3;
    use safetensors::tensor::TensorView;

    /// Two vertices of one node.
    fn statics() -> StaticPass {
        let rig = Rig { basis: vec![0.0; 3 * BASIS], ..Rig::default() };
        StaticPass { rest: vec![Vec3::ZERO; 2], rig, ..StaticPass::default() }
    }

    fn file(basis: &[f32], joints: [u8; 8], weights: [f32; 8]) -> Vec<u8> {
        let view = |dtype, shape: &[usize], bytes| TensorView::new(dtype, shape.to_vec(), bytes).unwrap();
        let views = [
            ("basis", view(Dtype::F32, &[basis.len()], bytemuck::cast_slice(basis))),
            ("joints", view(Dtype::U8, &[2, 4], &joints)),
            ("weights", view(Dtype::F32, &[2, 4], bytemuck::cast_slice(&weights))),
        ];
        safetensors::serialize(views, None).unwrap()
    }

    const HALVES: [f32; 8] = [0.5, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

    #[test]
    fn a_bake_takes_the_place_of_the_networks_answers() {
        let basis = vec![0.25; 3 * BASIS];
        let bake = Bake::from_bytes(&file(&basis, [1, 2, 3, 4, 5, 6, 7, 8], HALVES), &statics()).unwrap();
        let baked = statics().baked(bake);
        assert_eq!(baked.rig.basis, basis);
        assert_eq!(baked.rig.joints, [[1, 2, 3, 4], [5, 6, 7, 8]]);
        assert_eq!(baked.rig.weights.as_flattened(), HALVES);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let refused = |basis: &[f32], joints, weights| {
            Bake::from_bytes(&file(basis, joints, weights), &statics()).unwrap_err().to_string()
        };
        let basis = [0.0; 3 * BASIS];
        assert!(refused(&basis[1..], [0; 8], HALVES).contains("`basis` must hold 192"));
        assert!(refused(&[f32::NAN; 3 * BASIS], [0; 8], HALVES).contains("finite"));
        assert!(refused(&basis, [GARMENT_JOINTS as u8; 8], HALVES).contains("`joints` must be below"));
        assert!(refused(&basis, [0; 8], [0.5; 8]).contains("sum to 1"));
        assert!(refused(&basis, [0; 8], [f32::NAN; 8]).contains("`weights`"));
        assert!(Bake::from_bytes(b"glTF", &statics()).unwrap_err().to_string().contains("safetensors"));
    }
}
