//! An outfit's rest pose on recently asked body shapes.

use std::sync::Arc;

use glam::Vec3;
use toile_geometry::body::{BodyShape, ShapedBody};

use crate::recent::Recent;
use crate::shape::carried;
use crate::static_pass::StaticPass;
use crate::studio::Studio;

/// Shapes kept for each outfit.
const KEPT: usize = 4;

/// The rest pose of an outfit on one body shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Rest positions on that shape, welded order, metres.
    pub rest: Vec<Vec3>,
    /// Length of each edge of the static pass, metres.
    pub lengths: Vec<f32>,
}

/// A few fitted rest poses; they are not part of a static pass's value.
#[derive(Debug)]
pub struct FittedShapes(Recent<BodyShape, Fitted>);

impl Default for FittedShapes {
    fn default() -> Self {
        Self(Recent::new(KEPT))
    }
}

impl Clone for FittedShapes {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for FittedShapes {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl StaticPass {
    /// The rest pose on a shape, kept for the next drape on the same shape.
    #[must_use]
    pub fn fitted(&self, studio: &Studio, shape: &BodyShape, shaped: &ShapedBody) -> Arc<Fitted> {
        self.fitted_shapes.0.get(shape.clone(), |_| {
            let rest = carried(self, &studio.reference, &shaped.apose_vertices, studio.body.triangles());
            Fitted { lengths: lengths(&rest, &self.edges), rest }
        })
    }
}

/// Length of each edge, metres.
#[must_use]
pub fn lengths(positions: &[Vec3], edges: &[[u32; 2]]) -> Vec<f32> {
    let at = |i: u32| positions.get(i as usize).copied().unwrap_or_default();
    edges.iter().map(|[a, b]| at(*a).distance(at(*b))).collect()
}
