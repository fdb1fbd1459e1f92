//! The ways to drape, one file a paper, behind one trait.

pub mod deepsd;
pub mod deepsd_concat;
pub mod garnet;
mod kinds;
pub mod pixel_cloth;
pub mod simulation;
pub mod skinning;

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use toile_geometry::body::{Body, BodyShape, ShapedBody};
use toile_geometry::pose::Pose;

use crate::error::DrapeError;
use crate::garnet_tables::SeenPoints;
use crate::hero::Hero;
use crate::network::Networks;
use crate::outfit::Outfit;
use crate::posed_body::PosedBody;
use crate::static_pass::{INFLUENCES, StaticPass};

pub use kinds::{GarmentKind, UnknownKind};
pub use simulation::SimulatedDrape;

/// Names of the methods, as in the API.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MethodKind {
    /// `DeePSD` with a static basis.
    #[default]
    Deepsd,
    /// `DeePSD` as printed: a fully connected network on every vertex.
    DeepsdConcat,
    /// `GarNet++`: a network of every kind of garment, which sees the body as points.
    Garnet,
    /// Pixel-based cloth: a network of one garment, which draws it as images.
    PixelCloth,
    /// What a simulation left at rest, where one was kept.
    Simulation,
    /// Linear blend skinning with the body's own weights.
    Skinning,
}

impl MethodKind {
    /// Every method, in the order of the API.
    pub const ALL: [Self; 6] =
        [Self::Deepsd, Self::DeepsdConcat, Self::Garnet, Self::PixelCloth, Self::Simulation, Self::Skinning];

    /// The name in the API.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Deepsd => "deepsd",
            Self::DeepsdConcat => "deepsd-concat",
            Self::Garnet => "garnet",
            Self::PixelCloth => "pixel_cloth",
            Self::Simulation => "simulation",
            Self::Skinning => "skinning",
        }
    }

    /// Whether cloth settles after it ([`crate::settle`]): what one network for every outfit leaves hanging too high and
    /// without folds.
    #[must_use]
    pub const fn settles(self) -> bool {
        matches!(self, Self::Deepsd | Self::DeepsdConcat)
    }

    /// What drapes by this name.
    #[must_use]
    pub fn method(self) -> &'static dyn Method {
        match self {
            Self::Deepsd => &deepsd::Deepsd,
            Self::DeepsdConcat => &deepsd_concat::DeepsdConcat,
            Self::Garnet => &garnet::Garnet,
            Self::PixelCloth => &pixel_cloth::PixelCloth,
            Self::Simulation => &simulation::Simulation,
            Self::Skinning => &skinning::Skinning,
        }
    }
}

impl fmt::Display for MethodKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// No such method.
#[derive(Debug, thiserror::Error)]
#[error("there is no method {0:?}; use deepsd, deepsd-concat, garnet, pixel_cloth, simulation or skinning")]
pub struct UnknownMethod(String);

impl FromStr for MethodKind {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL.into_iter().find(|m| m.name() == name).ok_or_else(|| UnknownMethod(name.to_owned()))
    }
}

/// An outfit on a body in every frame, as the methods see it.
#[derive(Clone, Copy)]
pub struct Wearer<'a> {
    /// The outfit.
    pub outfit: &'a Outfit,
    /// Its static pass.
    pub statics: &'a StaticPass,
    /// Kind of every garment, or empty where the method needs none.
    pub kinds: &'a [GarmentKind],
    /// Its rest pose on this body, welded order, metres.
    pub rest: &'a [Vec3],
    /// Shape of the body.
    pub shape: &'a BodyShape,
    /// The body model.
    pub body: &'a Body,
    /// The body in the A-pose.
    pub shaped: &'a ShapedBody,
    /// The reference body in the A-pose.
    pub reference: &'a ShapedBody,
    /// One a frame.
    pub poses: &'a [Pose],
    /// For each frame the garment joints' world-from-A-pose transforms.
    pub transforms: &'a [Vec<Affine3A>],
    /// Parents of the garment joints.
    pub parents: &'a [Option<usize>],
    /// The body in each frame.
    pub bodies: &'a [Arc<PosedBody>],
    /// Points of it that networks see.
    pub seen: &'a SeenPoints,
    /// Garments that have a pixel-cloth network.
    pub heroes: &'a [&'a Hero],
    /// Kept simulations of this outfit.
    pub simulated: &'a [SimulatedDrape],
}

/// Where a method puts the cloth, before it is turned into world positions in one place
/// ([`crate::skinning::place`]).
pub enum Placement<'a> {
    /// Offsets in rest space, row-major (frames, vertices, 3), metres (none: empty), then linear blend
    /// skinning with these influences.
    Rest {
        /// Offsets of every frame.
        offsets: Vec<f32>,
        /// Joints of each vertex.
        joints: &'a [[u8; INFLUENCES]],
        /// Their weights.
        weights: &'a [[f32; INFLUENCES]],
    },
    /// World positions of every frame, metres.
    World(Vec<Vec<Vec3>>),
    /// The same, where nothing may be moved any more.
    Finished(Vec<Vec<Vec3>>),
    /// The same, read from cloth images.
    Pixels {
        /// World positions of every frame, metres.
        frames: Vec<Vec<Vec3>>,
        /// Images of the first frame, one entry a garment.
        first: Vec<ClothImages>,
    },
}

/// What a pixel-cloth network says of a garment in one pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClothImages {
    /// Name of the garment.
    pub garment: String,
    /// Pixels of a side.
    pub side: usize,
    /// Offsets along the pattern's u and v and off the skin, m: (panels, 3, side, side), row-major.
    pub values: Vec<f32>,
    /// Pixels on the cloth or its padding, (panels, side, side).
    pub mask: Vec<bool>,
}

/// A way to drape.
pub trait Method: Sync {
    /// Runs the dynamic pass over all frames.
    ///
    /// # Errors
    /// When a network fails or answers with an unexpected shape.
    fn dynamic_pass<'s>(
        &self,
        wearer: &Wearer<'s>,
        networks: &mut dyn Networks,
    ) -> Result<Placement<'s>, DrapeError>;
}
