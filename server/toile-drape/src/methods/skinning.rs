//! Linear blend skinning with the body's own weights, diffused: the baseline of every table.

use super::{Method, Placement, Wearer};
use crate::error::DrapeError;
use crate::network::Networks;

/// Skinning without any network.
pub struct Skinning;

impl Method for Skinning {
    fn dynamic_pass<'s>(
        &self,
        wearer: &Wearer<'s>,
        _networks: &mut dyn Networks,
    ) -> Result<Placement<'s>, DrapeError> {
        let rig = &wearer.statics.rig;
        Ok(Placement::Rest { offsets: Vec::new(), joints: &rig.prior_joints, weights: &rig.prior_weights })
    }
}
