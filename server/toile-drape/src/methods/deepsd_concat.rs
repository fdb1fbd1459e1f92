//! `DeePSD` as printed (section 4.2.2): descriptors and pose concatenated, a network on every vertex.

use super::deepsd::{POSE, only, pose_features, shape_features};
use super::{Method, Placement, Wearer};
use crate::error::DrapeError;
use crate::network::{Networks, TensorRef};

/// `DeePSD` in its printed form, kept for comparison.
pub struct DeepsdConcat;

impl Method for DeepsdConcat {
    fn dynamic_pass<'s>(
        &self,
        wearer: &Wearer<'s>,
        networks: &mut dyn Networks,
    ) -> Result<Placement<'s>, DrapeError> {
        let statics = wearer.statics;
        let vertices = statics.rest.len();
        let descriptors = statics.vertex_descriptors();
        let width = descriptors.len() / vertices.max(1);
        let shape = shape_features(wearer.shape);
        let mut offsets = Vec::with_capacity(wearer.transforms.len() * vertices * 3);
        for frame in wearer.transforms {
            let pose = pose_features(frame, wearer.parents);
            let answer = networks.run(
                "deepsd-concat/dynamic",
                &[
                    ("descriptors", TensorRef::F32(&[vertices, width], &descriptors)),
                    ("pose", TensorRef::F32(&[1, POSE], &pose)),
                    ("shape", TensorRef::F32(&[1, shape.len()], &shape)),
                ],
            )?;
            offsets.append(&mut only("deepsd-concat/dynamic", answer, vertices * 3)?);
        }
        Ok(Placement::Rest { offsets, joints: &statics.rig.joints, weights: &statics.rig.weights })
    }
}
