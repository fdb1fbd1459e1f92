//! After the dynamic pass: edges near their lengths, then cloth out of the body and outer garments out of inner ones,
//! smoothly.

use glam::Vec3;

use crate::contact::{Collider, Contact};
use crate::fitted::Fitted;
use crate::layer_contact::LayerContact;
use crate::outfit::Outfit;
use crate::push_out::Field;
use crate::static_pass::StaticPass;
use crate::straighten::straighten;
use crate::stretch::{self, Limit};

/// Distance that draped cloth keeps from the skin, metres, where its rest pose does too.
const SKIN_GAP: f32 = 0.003;
/// Distance that cloth keeps from the surface across a fold, metres: both sides may leave no more room.
const FOLD_GAP: f32 = 0.001;
/// Rounds of smooth pushes; the last ones move single vertices.
const SMOOTH_ROUNDS: usize = 7;
const EXACT_ROUNDS: usize = 5;
/// Rounds after which the layers' nearest vertices and normals are looked for anew; cloth moves by millimetres.
const REFRESHED: usize = 4;
/// How long edges may be before single vertices move.
const STRETCH: Limit = Limit { stretch: 1.8, rounds: 1 };
/// The same at the end, where a spike is worse than a vertex under the skin.
const SPIKE: Limit = Limit { stretch: 2.9, rounds: 6 };
/// Radius of the body's tightest curve that cloth spans, metres: decides how far a flat triangle can sink in.
const TIGHTEST_CURVE: f32 = 0.03;
/// A lack smaller than this is left alone, metres.
pub const TOLERANCE: f32 = 3e-4;
/// Cloth further than this from the body needs no closer look, metres: centroids ask within 5 cm.
const FAR: f32 = 0.06;
/// A vertex that moved less than this is not tested again, metres.
const STILL: f32 = 1e-5;

/// What the resolve found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resolved {
    /// Depth of every vertex in the body before it is moved out, metres; 0 outside.
    pub depth_before: Vec<f32>,
    /// Vertices inside the body before.
    pub inside_before: usize,
    /// Vertices inside the body after.
    pub inside_after: usize,
}

/// Draws the edges of world `positions` (welded order) towards their lengths at rest on the same body, then moves the
/// cloth out of the body and the layers below.
pub fn resolve(
    outfit: &Outfit,
    statics: &StaticPass,
    fitted: &Fitted,
    body: &Collider<'_>,
    positions: &mut [Vec3],
) -> Resolved {
    straighten(statics, fitted, body, positions);
    let lengths = &fitted.lengths;
    let field = Field { vertex_from_node: &statics.vertex_from_node, near: &statics.near };
    let mut skin = SkinContact::new(statics, body, positions);
    let depth_before: Vec<f32> = skin.contacts.iter().map(Contact::depth).collect();
    let inside_before = skin.inside();
    let mut layers = LayerContact::new(statics, &outfit.triangles);
    for round in 0..SMOOTH_ROUNDS + EXACT_ROUNDS {
        if round >= SMOOTH_ROUNDS {
            skin.shorten(positions, lengths, STRETCH);
        }
        let mut need = skin.needs();
        add_centroid_needs(&skin, positions, &fitted.coarse, &mut need);
        layers.add_needs(|v| skin.room(v), positions, round % REFRESHED == 0, &mut need);
        if need.iter().all(|n| *n == Vec3::ZERO) {
            break;
        }
        let push = if round < SMOOTH_ROUNDS { field.spread(&need) } else { need };
        for (v, (p, d)) in positions.iter_mut().zip(push).enumerate() {
            if d.length_squared() > STILL * STILL {
                *p += d;
                skin.update(v, *p);
            }
        }
    }
    skin.shorten(positions, lengths, SPIKE);
    Resolved { inside_before, inside_after: skin.inside(), depth_before }
}

/// The skin at every cloth vertex, kept up to date as vertices move.
struct SkinContact<'a> {
    statics: &'a StaticPass,
    body: &'a Collider<'a>,
    contacts: Vec<Contact>,
}

impl<'a> SkinContact<'a> {
    fn new(statics: &'a StaticPass, body: &'a Collider<'a>, positions: &[Vec3]) -> Self {
        let mut first: Vec<Option<(Vec3, Contact)>> = vec![None; statics.near.len()];
        let at = |(v, p): (usize, &Vec3)| {
            let Some(seen) = statics.node_of(v).and_then(|node| first.get_mut(node)) else {
                return body.contact(*p, statics.candidates_of(v));
            };
            // No vertex is nearer than another one of its node less the way between them.
            let away = seen.map_or(0.0, |(q, contact)| contact.away - p.distance(q));
            if away > FAR {
                return Contact::far(away);
            }
            // What is nearest to the last one is near what is nearest to this one.
            let from = seen.as_ref().and_then(|(_, contact)| contact.hit.as_ref()).map(std::slice::from_ref);
            let contact = body.contact(*p, from.unwrap_or_else(|| statics.candidates_of(v)));
            *seen = Some((*p, contact));
            contact
        };
        Self { statics, body, contacts: positions.iter().enumerate().map(at).collect() }
    }

    fn update(&mut self, v: usize, position: Vec3) {
        if let Some(contact) = self.contacts.get_mut(v) {
            *contact = self.body.contact(position, self.statics.candidates_of(v));
        }
    }

    /// The skin at a point between the corners of a triangle, looked for from what is nearest to each of them.
    fn between(&self, corners: [usize; 3], point: Vec3) -> Option<Contact> {
        let [a, b, c] = corners.map(|v| self.contacts.get(v).and_then(|c| c.hit));
        let first = a.or(b).or(c)?;
        Some(self.body.contact(point, &[a.unwrap_or(first), b.unwrap_or(first), c.unwrap_or(first)]))
    }

    /// Shortens the edges beyond the limit.
    fn shorten(&mut self, positions: &mut [Vec3], lengths: &[f32], limit: Limit) {
        for v in stretch::shorten(positions, &self.statics.edges, lengths, limit) {
            self.update(v, positions[v]);
        }
    }

    fn inside(&self) -> usize {
        self.contacts.iter().filter(|c| c.depth() > 0.0).count()
    }

    fn gap(&self, v: usize) -> f32 {
        self.statics.clearance.get(v).map_or(SKIN_GAP, |c| c.clamp(0.001, SKIN_GAP))
    }

    /// How much nearer to the skin a vertex may come, metres.
    fn room(&self, v: usize) -> f32 {
        self.contacts.get(v).map_or(0.0, |c| (c.distance - self.gap(v)).min(c.across - FOLD_GAP).max(0.0))
    }

    /// What each vertex lacks to its distance from the skin, on both sides of a fold.
    fn needs(&self) -> Vec<Vec3> {
        let need = |(v, c): (usize, &Contact)| c.way_out(self.gap(v), FOLD_GAP, TOLERANCE);
        self.contacts.iter().enumerate().map(need).collect()
    }
}

/// Adds what coarse triangles near the skin lack at their centroids, to their corners.
fn add_centroid_needs(skin: &SkinContact<'_>, positions: &[Vec3], coarse: &[[u32; 3]], need: &mut [Vec3]) {
    for triangle in coarse {
        let corner = triangle.map(|i| i as usize);
        let [a, b, c] = corner.map(|v| positions[v]);
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        let sinks = SKIN_GAP + longest / (8.0 * TIGHTEST_CURVE);
        if corner.iter().all(|&v| skin.contacts[v].distance > sinks) {
            continue;
        }
        let centroid = (a + b + c) / 3.0;
        let Some(contact) = skin.between(corner, centroid) else { continue };
        let way = contact.way_out(0.5 * skin.gap(corner[0]), 0.5 * FOLD_GAP, TOLERANCE);
        for v in corner {
            if need[v].length_squared() < way.length_squared() {
                need[v] = way;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::binding::CANDIDATES;
    use crate::graph::OutfitGraph;
    use crate::layers::layer_contacts;
    use crate::settle::Hanging;
    use crate::straighten::NodeEdges;
    use crate::test_meshes::{sheet, sheets};
    use toile_geometry::mesh::{Adjacency, edges};
    use toile_geometry::nearest::PointTree;
    use toile_geometry::normals::vertex_normals;

    /// A body surface of 1 cm quads, 20 cm each way around the cloth, at the height `y(x)`, with its edges.
    fn ground(y: impl Fn(f32) -> f32) -> (Vec<Vec3>, Vec<Vec3>, Adjacency) {
        let (flat, triangles) = sheet(20);
        let moved = flat.into_iter().map(|p| p - Vec3::new(0.053, 0.0, 0.053));
        let vertices: Vec<Vec3> = moved.map(|p| p.with_y(y(p.x))).collect();
        let ring = Adjacency::new(vertices.len(), &triangles);
        (vertices.clone(), vertex_normals(&vertices, &triangles), ring)
    }

    /// Resolves `moved` cloth whose rest pose is the outfit's, over a ground of the height `y(x)`.
    fn resolved(outfit: &Outfit, y: impl Fn(f32) -> f32, mut moved: Vec<Vec3>) -> Vec<Vec3> {
        let (vertices, normals, ring) = ground(y);
        let tree = PointTree::new(&vertices, |_| true).expect("a ground");
        let graph = OutfitGraph::new(&outfit.positions, &outfit.triangles, &vec![0; moved.len()]);
        let near = |p: &Vec3| [tree.nearest(*p).index; CANDIDATES];
        let statics = StaticPass {
            rest: outfit.positions.clone(),
            clearance: vec![0.01; moved.len()],
            candidates: graph.nodes.positions.iter().flat_map(near).collect(),
            layers: layer_contacts(outfit, &outfit.positions),
            edges: edges(&outfit.triangles),
            ring: Adjacency::new(moved.len(), &outfit.triangles),
            vertex_from_node: graph.vertex_from_node,
            near: graph.near,
            ..StaticPass::default()
        };
        let lengths = vec![0.02; statics.edges.len()];
        let fitted = Fitted {
            rest: statics.rest.clone(),
            lengths,
            node_edges: NodeEdges::default(),
            hanging: Hanging::default(),
            coarse: vec![],
        };
        let body = Collider { vertices: &vertices, normals: &normals, ring: &ring, facing: &[] };
        resolve(outfit, &statics, &fitted, &body, &mut moved);
        moved
    }

    /// An inner sheet whose hem came 6 mm through the longer sheet over it.
    fn hem_out() -> (Outfit, Vec<Vec3>) {
        let outfit = sheets(&[(0.0, 6), (0.01, 12)]);
        let mut moved = outfit.positions.clone();
        moved[40..60].iter_mut().for_each(|p| p.y = 0.016);
        (outfit, moved)
    }

    #[test]
    fn a_hem_that_came_out_goes_back_where_it_has_room() {
        let (outfit, moved) = hem_out();
        let after = resolved(&outfit, |_| -0.1, moved);
        let highest = after[40..60].iter().map(|p| p.y).fold(f32::MIN, f32::max);
        let over = after[60..].iter().map(|p| p.y).fold(f32::MAX, f32::min);
        assert!(highest < over, "the hem at {highest} lies under the cloth at {over}");
        assert!(highest < 0.012, "most of the way is the hem's");
    }

    #[test]
    fn over_the_skin_the_outer_cloth_gives_way_to_a_hem() {
        let (outfit, moved) = hem_out();
        let after = resolved(&outfit, |_| 0.012, moved);
        let lowest = after[50..60].iter().map(|p| p.y).fold(f32::MAX, f32::min);
        assert!(lowest > 0.014, "the hem keeps out of the skin at 0.012: {lowest}");
        let above = |v: usize| after[60 + v].y - after[v].y;
        assert!((51..59).all(|v| above(v) > 0.0), "{:?}", (50..60).map(above).collect::<Vec<_>>());
    }

    #[test]
    fn a_coarse_triangle_clears_a_ridge_between_its_corners() {
        let corner = |x: f32, z: f32| Vec3::new(x, 0.025, z);
        let positions = vec![corner(0.0, 0.0), corner(0.0, 0.06), corner(0.06, 0.03)];
        let triangles = vec![[0, 1, 2]];
        let outfit = Outfit { positions: positions.clone(), triangles, ..Outfit::default() };
        let ridge = |x: f32| 0.03 - 0.6 * (x - 0.02).abs();
        let after = resolved(&outfit, ridge, positions.clone());
        let height = |p: &[Vec3]| p.iter().sum::<Vec3>().y / 3.0;
        assert!(height(&positions) < 0.03 && height(&after) > 0.03, "{after:?}");
    }
}
