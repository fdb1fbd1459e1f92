//! What all drapes share: the body, its reference surface, and recently used shapes.

use std::sync::Arc;

use toile_geometry::body::{Body, BodyShape, ShapedBody};
use toile_geometry::pose::Pose;

use crate::arm_room::ArmRoom;
use crate::error::DrapeError;
use crate::garnet_tables::SeenPoints;
use crate::hero::Hero;
use crate::network::Networks;
use crate::outfit::Outfit;
use crate::posed_body::PosedBody;
use crate::recent::Recent;
use crate::reference::ReferenceBody;
use crate::static_pass::StaticPass;

const SHAPES: usize = 16;
const POSED: usize = 32;

/// Things shared by every drape.
pub struct Studio {
    /// The body model.
    pub body: Body,
    /// The reference body's surface.
    pub reference: ReferenceBody,
    /// The reference body in the A-pose.
    pub reference_body: ShapedBody,
    /// Points of the body that networks see.
    pub seen: SeenPoints,
    /// Garments that have a pixel-cloth network.
    pub heroes: Vec<Hero>,
    /// What a wider body does to arms that hang.
    pub arm_room: ArmRoom,
    /// Parents of the garment joints.
    pub garment_parents: Vec<Option<usize>>,
    /// Recently asked body shapes, half a megabyte each.
    pub shapes: Recent<BodyShape, ShapedBody>,
    /// Recently posed bodies, a third of a megabyte each: shoppers try many outfits in the same pose.
    pub posed: Recent<(BodyShape, Pose), PosedBody>,
}

impl Studio {
    /// Prepares the body for draping.
    ///
    /// # Errors
    /// When the body's skeleton lacks a limb joint.
    pub fn new(body: Body, heroes: Vec<Hero>) -> Result<Arc<Self>, DrapeError> {
        let reference = ReferenceBody::new(&body)?;
        let reference_body = body.shape(&BodyShape::default());
        let arm_room = ArmRoom::new(&body, &reference_body, Arc::clone(&reference.parts));
        let seen = SeenPoints::of(&reference.vertices);
        let garment_parents = body.skeleton().garment_parents().to_vec();
        Ok(Arc::new(Self {
            body,
            reference,
            reference_body,
            seen,
            heroes,
            arm_room,
            garment_parents,
            shapes: Recent::new(SHAPES),
            posed: Recent::new(POSED),
        }))
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
