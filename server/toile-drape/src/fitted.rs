//! An outfit's rest pose on recently asked body shapes.

use std::sync::Arc;

use glam::Vec3;
use toile_geometry::body::{BodyShape, ShapedBody};

use crate::outfit::Outfit;
use crate::recent::Recent;
use crate::settle::Hanging;
use crate::shape::carried;
use crate::static_pass::StaticPass;
use crate::straighten::NodeEdges;
use crate::studio::Studio;

/// Triangles with an edge longer than this can sink in between their corners, metres.
const COARSE_EDGE: f32 = 0.022;
/// Shapes kept for each outfit.
const KEPT: usize = 4;

/// The rest pose of an outfit on one body shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Rest positions on that shape, welded order, metres.
    pub rest: Vec<Vec3>,
    /// Length of each edge of the static pass, metres.
    pub lengths: Vec<f32>,
    /// The canonical graph's edges.
    pub node_edges: NodeEdges,
    /// What of it hangs, and from where.
    pub hanging: Hanging,
    /// Triangles that are tested for collisions at their centroids too.
    pub coarse: Vec<[u32; 3]>,
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
    pub fn fitted(
        &self,
        studio: &Studio,
        outfit: &Outfit,
        shape: &BodyShape,
        shaped: &ShapedBody,
    ) -> Arc<Fitted> {
        self.fitted_shapes.0.get(shape.clone(), |_| {
            let rest = carried(self, &studio.reference, &shaped.apose_vertices, studio.body.triangles());
            let node_edges = NodeEdges::new(self, &rest);
            Fitted {
                lengths: lengths(&rest, &self.edges),
                hanging: Hanging::new(self, &rest, &node_edges),
                node_edges,
                coarse: coarse_triangles(outfit, &rest),
                rest,
            }
        })
    }
}

fn coarse_triangles(outfit: &Outfit, rest: &[Vec3]) -> Vec<[u32; 3]> {
    let at = |i: u32| rest.get(i as usize).copied().unwrap_or_default();
    let longest = |t: &[u32; 3]| {
        let [a, b, c] = t.map(at);
        a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
    };
    outfit.triangles.iter().filter(|t| longest(t) > COARSE_EDGE * COARSE_EDGE).copied().collect()
}

/// Length of each edge, metres.
#[must_use]
pub fn lengths(positions: &[Vec3], edges: &[[u32; 2]]) -> Vec<f32> {
    let at = |i: u32| positions.get(i as usize).copied().unwrap_or_default();
    edges.iter().map(|[a, b]| at(*a).distance(at(*b))).collect()
}
