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
pub const COARSE_EDGE: f32 = 0.022;
/// Longer ones can sink in themselves, metres.
const LONG_EDGE: f32 = 0.035;
/// Radius of the body's curves that one garment spans over another, metres.
const CURVE: f32 = 0.1;
/// How far its triangles are taken to sink in there at most, metres.
const MOST_SAG: f32 = 0.003;
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
    /// What is tested for collisions between its vertices too.
    pub coarse: Coarse,
    /// How far the cloth around each vertex may sink into cloth below it, between its corners, metres.
    pub sags: Vec<f32>,
}

/// Pieces of cloth that can sink into the body while their vertices are outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coarse {
    /// Triangles, tested at their centroids.
    pub triangles: Vec<[u32; 3]>,
    /// Edges, tested at their middles.
    pub edges: Vec<[u32; 2]>,
}

impl Coarse {
    /// Of cloth at `rest`, metres, with the `lengths` of its edges there.
    #[must_use]
    pub fn new(triangles: &[[u32; 3]], rest: &[Vec3], edges: &[[u32; 2]], lengths: &[f32]) -> Self {
        let at = |i: u32| rest.get(i as usize).copied().unwrap_or_default();
        let longest = |t: &[u32; 3]| {
            let [a, b, c] = t.map(at);
            a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
        };
        let is_coarse = |t: &&[u32; 3]| longest(t) > COARSE_EDGE * COARSE_EDGE;
        let edges = edges.iter().zip(lengths).filter(|(_, length)| **length > LONG_EDGE);
        Self {
            triangles: triangles.iter().filter(is_coarse).copied().collect(),
            edges: edges.map(|(edge, _)| *edge).collect(),
        }
    }
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
            let lengths = lengths(&rest, &self.edges);
            Fitted {
                sags: sags(rest.len(), &self.edges, &lengths),
                hanging: Hanging::new(self, &rest, &node_edges),
                node_edges,
                coarse: Coarse::new(&outfit.triangles, &rest, &self.edges, &lengths),
                lengths,
                rest,
            }
        })
    }
}

/// How far flat triangles at each of `count` vertices lie below the body's curve through their corners, metres, from the
/// `lengths` of their edges.
#[must_use]
pub fn sags(count: usize, edges: &[[u32; 2]], lengths: &[f32]) -> Vec<f32> {
    let mut longest = vec![0.0_f32; count];
    for (ends, length) in edges.iter().zip(lengths) {
        for v in ends.map(|v| v as usize) {
            if let Some(longest) = longest.get_mut(v) {
                *longest = longest.max(*length);
            }
        }
    }
    longest.into_iter().map(|length| (length * length / (8.0 * CURVE)).min(MOST_SAG)).collect()
}

/// Length of each edge, metres.
#[must_use]
pub fn lengths(positions: &[Vec3], edges: &[[u32; 2]]) -> Vec<f32> {
    let at = |i: u32| positions.get(i as usize).copied().unwrap_or_default();
    edges.iter().map(|[a, b]| at(*a).distance(at(*b))).collect()
}
