//! Linear blend skinning with the body's own weights, diffused: the baseline of every table.

use super::{Method, Placement, PosedSkeleton};
use crate::error::DrapeError;
use crate::network::Networks;
use crate::static_pass::StaticPass;

/// Skinning without any network.
pub struct Skinning;

impl Method for Skinning {
    fn dynamic_pass<'s>(
        &self,
        statics: &'s StaticPass,
        _posed: &PosedSkeleton<'_>,
        _networks: &mut dyn Networks,
    ) -> Result<Placement<'s>, DrapeError> {
        let rig = &statics.rig;
        Ok(Placement::Rest { offsets: Vec::new(), joints: &rig.prior_joints, weights: &rig.prior_weights })
    }
}
