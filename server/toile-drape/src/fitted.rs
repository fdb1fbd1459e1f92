//! An outfit's rest pose on recently asked body shapes.

use std::sync::{Arc, Mutex, PoisonError};

use glam::Vec3;
use toile_geometry::body::{BodyShape, ShapedBody};

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

/// A few fitted rest poses, the latest first.
#[derive(Debug, Default)]
pub struct FittedShapes(Mutex<Vec<(BodyShape, Arc<Fitted>)>>);

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
        let mut kept = self.fitted_shapes.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = kept.iter().position(|(s, _)| s == shape) {
            let entry = kept.remove(at);
            let fitted = Arc::clone(&entry.1);
            kept.insert(0, entry);
            return fitted;
        }
        drop(kept);
        let rest = carried(self, &studio.reference, &shaped.apose_vertices, studio.body.triangles());
        let fitted = Arc::new(Fitted { lengths: lengths(&rest, &self.edges), rest });
        let mut kept = self.fitted_shapes.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.insert(0, (shape.clone(), Arc::clone(&fitted)));
        kept.truncate(KEPT);
        fitted
    }
}

/// Length of each edge, metres.
#[must_use]
pub fn lengths(positions: &[Vec3], edges: &[[u32; 2]]) -> Vec<f32> {
    let at = |i: u32| positions.get(i as usize).copied().unwrap_or_default();
    edges.iter().map(|[a, b]| at(*a).distance(at(*b))).collect()
}
