//! What all drapes share: the body, its reference surface, and recently used shapes.

use std::sync::Arc;

use toile_geometry::body::{Body, BodyShape};

use crate::error::DrapeError;
use crate::network::Networks;
use crate::outfit::Outfit;
use crate::reference::ReferenceBody;
use crate::static_pass::StaticPass;

/// Immutable things shared by every drape.
pub struct Studio {
    /// The body model.
    pub body: Body,
    /// The reference body's surface.
    pub reference: ReferenceBody,
    /// Parents of the garment joints.
    pub garment_parents: Vec<Option<usize>>,
}

impl Studio {
    /// Prepares the body for draping.
    ///
    /// # Errors
    /// When the body's skeleton lacks a limb joint.
    pub fn new(body: Body) -> Result<Arc<Self>, DrapeError> {
        let reference = ReferenceBody::new(&body)?;
        let garment_parents = body.skeleton().garment_parents().to_vec();
        Ok(Arc::new(Self { body, reference, garment_parents }))
    }

    /// The static pass of an outfit fitted on `fitted_on`.
    ///
    /// # Errors
    /// When a network fails or answers with an unexpected shape.
    pub fn static_pass(
        &self,
        outfit: &Outfit,
        fitted_on: &BodyShape,
        networks: &mut dyn Networks,
    ) -> Result<StaticPass, DrapeError> {
        StaticPass::compute_on(outfit, &self.reference, &self.body, fitted_on, networks)
    }
}
