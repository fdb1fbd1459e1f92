//! Carrying an outfit to another body shape: made to measure, bone lengths and girth.

use glam::Vec3;
use toile_geometry::body::{Body, BodyShape};
use toile_geometry::nearest::PointTree;
use toile_geometry::normals::vertex_normals;

use crate::graph::Links;
use crate::outfit::Outfit;
use crate::push_out::{Collider, Field};
use crate::reference::ReferenceBody;
use crate::static_pass::StaticPass;

/// Cloth keeps at most this much of its rest distance to the skin on another body, metres.
const MARGIN: f32 = 0.003;
const ROUNDS: usize = 4;

/// The rest pose of an outfit on another body shape, pushed out where the carried cloth would enter the skin.
///
/// `apose`: vertices of the shape in the A-pose, metres.
#[must_use]
pub fn carried(statics: &StaticPass, reference: &ReferenceBody, apose: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let moved: Vec<Vec3> = apose.iter().zip(&reference.vertices).map(|(a, r)| *a - *r).collect();
    let mut out = displaced(&statics.rest, &statics.shape, &moved);
    let normals = vertex_normals(apose, triangles);
    let skin = Collider { vertices: apose, normals: &normals, ring: &reference.ring };
    let field = Field { vertex_from_node: &statics.vertex_from_node, near: &statics.near };
    for round in 0..ROUNDS {
        let need: Vec<Vec3> = out
            .iter()
            .enumerate()
            .map(|(v, p)| {
                let (distance, normal) = skin.clearance(*p, statics.candidates_of(v));
                normal * (statics.clearance[v].clamp(0.001, MARGIN) - distance).max(0.0)
            })
            .collect();
        let push = if round + 1 < ROUNDS { field.spread(&need) } else { need };
        out.iter_mut().zip(push).for_each(|(p, d)| *p += d);
    }
    out
}

/// Adds to each position the weighted displacements of the body vertices that it follows.
fn displaced(positions: &[Vec3], links: &Links, moved: &[Vec3]) -> Vec<Vec3> {
    let follow = |v: usize| links.row(v).fold(Vec3::ZERO, |sum, (b, w)| sum + moved[b] * w);
    positions.iter().enumerate().map(|(v, p)| *p + follow(v)).collect()
}

/// Body vertices whose displacement a vertex follows when an outfit comes from another body.
const FOLLOWED: usize = 24;

/// An outfit fitted on another shape, moved to the reference body: welded positions, rest space.
#[must_use]
pub fn carried_to_reference(
    outfit: &Outfit,
    reference: &ReferenceBody,
    body: &Body,
    fitted_on: &BodyShape,
) -> Vec<Vec3> {
    if *fitted_on == BodyShape::default() {
        return outfit.positions.clone();
    }
    let from = body.shape(fitted_on).apose_vertices;
    let Some(tree) = PointTree::new(&from, |_| true) else { return outfit.positions.clone() };
    let follow = |p: &Vec3| {
        let hits = tree.nearest_n(*p, FOLLOWED);
        let least = hits.first().map_or(0.0, |h| h.distance);
        let spread = (0.5 * least).max(0.02);
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        for hit in hits {
            let weight = (-0.5 * ((hit.distance - least) / spread).powi(2)).exp();
            sum += (reference.vertices[hit.index as usize] - from[hit.index as usize]) * weight;
            total += weight;
        }
        *p + sum / total.max(f32::MIN_POSITIVE)
    };
    outfit.positions.iter().map(follow).collect()
}
