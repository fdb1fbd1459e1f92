//! After the dynamic pass: edges near their lengths, then cloth out of the body and outer garments out of inner ones,
//! smoothly.

use glam::Vec3;

use crate::contact::{Collider, Contact};
use crate::fitted::Fitted;
use crate::layer_contact::LayerContact;
use crate::outfit::Outfit;
use crate::push_out::pushes;
use crate::skin_contact::SkinContact;
use crate::static_pass::StaticPass;
use crate::straighten::{FEWEST_SWEEPS, straighten, sweeps};
use crate::stretch::Limit;

/// How often cloth is moved out.
#[derive(Clone, Copy)]
struct Rounds {
    /// Smoothly.
    smooth: usize,
    /// Then vertex by vertex.
    exact: usize,
}

/// Of meshes that are moved out once.
const ROUNDS: Rounds = Rounds { smooth: 7, exact: 5 };
/// Of those that are moved out twice.
const FIRST_ROUNDS: Rounds = Rounds { smooth: 3, exact: 0 };
const THEN_ROUNDS: Rounds = Rounds { smooth: 5, exact: 7 };
/// Rounds of such pushes after the last spikes are shortened, which may bring cloth back in.
const LAST_ROUNDS: usize = 3;
/// Rounds after which the layers' nearest vertices and normals are looked for anew; cloth moves by millimetres.
const REFRESHED: usize = 4;
/// Meshes of at most this many edges are drawn to their lengths once more when they are out, and moved out once more:
/// pushes have stretched their long edges most, and the resolve of fine ones has no time for half as much again.
const AGAIN: usize = 10_000;
/// How long edges may be before single vertices move.
const STRETCH: Limit = Limit { stretch: 1.8, rounds: 1 };
/// The same at the end, where a spike is worse than a vertex under the skin.
const SPIKE: Limit = Limit { stretch: 2.9, rounds: 6 };
/// A lack smaller than this is left alone, metres.
pub const TOLERANCE: f32 = 3e-4;
/// A vertex that moved less than this is where it was and is not tested again, metres.
pub const STILL: f32 = 1e-5;

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
    straighten(statics, fitted, body, positions, sweeps(statics.edges.len()));
    let mut contacts = Contacts::new(outfit, statics, fitted, body, positions);
    let depth_before: Vec<f32> = contacts.skin.contacts().iter().map(Contact::depth).collect();
    let inside_before = contacts.skin.inside();
    let mut rounds = ROUNDS;
    if statics.edges.len() <= AGAIN {
        contacts.push_out(FIRST_ROUNDS, positions);
        straighten(statics, fitted, body, positions, FEWEST_SWEEPS);
        contacts = Contacts::new(outfit, statics, fitted, body, positions);
        rounds = THEN_ROUNDS;
    }
    contacts.push_out(rounds, positions);
    contacts.skin.shorten(positions, &fitted.lengths, SPIKE);
    contacts.leave_body(positions);
    Resolved { inside_before, inside_after: contacts.skin.inside(), depth_before }
}

/// What the cloth touches, kept up to date as it is moved.
struct Contacts<'a> {
    statics: &'a StaticPass,
    fitted: &'a Fitted,
    skin: SkinContact<'a>,
    layers: LayerContact<'a>,
    /// What each vertex lacks, metres.
    need: Vec<Vec3>,
}

impl<'a> Contacts<'a> {
    fn new(
        outfit: &'a Outfit,
        statics: &'a StaticPass,
        fitted: &'a Fitted,
        body: &'a Collider<'a>,
        positions: &[Vec3],
    ) -> Self {
        let skin = SkinContact::new(statics, body, positions);
        let layers = LayerContact::new(statics, &outfit.triangles, &fitted.sags);
        Self { statics, fitted, skin, layers, need: vec![Vec3::ZERO; positions.len()] }
    }

    /// Moves the cloth out of the body and the layers below, in rounds: smoothly at first, then single vertices.
    fn push_out(&mut self, rounds: Rounds, positions: &mut [Vec3]) {
        for round in 0..rounds.smooth + rounds.exact {
            if round >= rounds.smooth {
                self.skin.shorten(positions, &self.fitted.lengths, STRETCH);
            }
            self.skin.needs(&mut self.need);
            self.skin.add_needs_between(positions, &self.fitted.coarse, &mut self.need);
            let room = |v| self.skin.room(v);
            self.layers.add_needs(room, positions, round % REFRESHED == 0, &mut self.need);
            let need = pushes(&self.need);
            if need.is_empty() {
                break;
            }
            let push = if round < rounds.smooth { self.statics.field().spread(&need) } else { need };
            self.skin.push(positions, &push);
        }
    }

    /// Moves what is still inside out of the body, out of other limbs too, without new spikes.
    fn leave_body(&mut self, positions: &mut [Vec3]) {
        let strayed = self.skin.strayed(positions);
        for _ in 0..LAST_ROUNDS {
            self.skin.needs(&mut self.need);
            self.skin.add_needs_between(positions, &self.fitted.coarse, &mut self.need);
            self.skin.add_needs_of_strayed(&strayed, positions, &mut self.need);
            let need = pushes(&self.need);
            if need.is_empty() {
                break;
            }
            self.skin.push(positions, &need);
            if self.skin.tears(&need, positions, &self.fitted.rest, SPIKE) {
                self.skin.shorten(positions, &self.fitted.lengths, SPIKE);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::binding::CANDIDATES;
    use crate::fitted::{Coarse, lengths, sags};
    use crate::graph::OutfitGraph;
    use crate::layers::layer_contacts;
    use crate::push_out::followers;
    use crate::settle::Hanging;
    use crate::straighten::NodeEdges;
    use crate::test_meshes::{limb, sheet, sheets};
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
            followers: followers(&graph.vertex_from_node, graph.near.len()),
            vertex_from_node: graph.vertex_from_node,
            near: graph.near,
            ..StaticPass::default()
        };
        let lengths = lengths(&statics.rest, &statics.edges);
        let fitted = Fitted {
            rest: statics.rest.clone(),
            coarse: Coarse::new(&outfit.triangles, &statics.rest, &statics.edges, &lengths),
            sags: sags(moved.len(), &statics.edges, &lengths),
            lengths,
            node_edges: NodeEdges::default(),
            hanging: Hanging::default(),
        };
        let body = limb(&vertices, &normals, &ring);
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

    /// How much the edges of a sheet change, on average, that a bump lifts, beside another of some rows far above it.
    fn change_over_a_bump(rows: u32) -> f32 {
        let outfit = sheets(&[(0.0, 12), (5.0, rows)]);
        let moved = outfit.positions.iter().map(|p| *p + Vec3::Y * 0.01).collect();
        let after = resolved(&outfit, |x| 0.02 - 16.0 * (x - 0.05).powi(2), moved);
        let (now, rest) = (&after[..120], &outfit.positions[..120]);
        let edges: Vec<_> = edges(&outfit.triangles).into_iter().filter(|[a, b]| a.max(b) < &120).collect();
        let pairs = lengths(now, &edges).into_iter().zip(lengths(rest, &edges));
        pairs.map(|(now, rest)| (now / rest - 1.0).abs()).sum::<f32>() / edges.len() as f32
    }

    #[test]
    fn a_small_mesh_is_drawn_to_its_lengths_again_once_it_is_out() {
        // 9 818 and 10 098 edges.
        let (small, large) = (change_over_a_bump(340), change_over_a_bump(350));
        assert!(small < 0.95 * large, "{small} {large}");
    }

    /// Corners of a flat triangle at `at`, x and z, 25 mm high, resolved over a ridge 30 mm high at `x`, metres.
    fn over_a_ridge(at: [(f32, f32); 3], x: f32) -> Vec<Vec3> {
        let positions = at.map(|(x, z)| Vec3::new(x, 0.025, z)).to_vec();
        let outfit = Outfit { positions: positions.clone(), triangles: vec![[0, 1, 2]], ..Outfit::default() };
        resolved(&outfit, |at| 0.03 - 0.6 * (at - x).abs(), positions)
    }

    #[test]
    fn a_coarse_triangle_clears_a_ridge_between_its_corners() {
        let after = over_a_ridge([(0.0, 0.0), (0.0, 0.06), (0.06, 0.03)], 0.02);
        let height = after.iter().sum::<Vec3>().y / 3.0;
        assert!(height > 0.03 && height < 0.035, "{after:?}");
    }

    #[test]
    fn a_long_edge_clears_a_ridge_that_its_triangles_middle_does_not_reach() {
        let after = over_a_ridge([(0.0, 0.0), (0.06, 0.0), (0.0, 0.06)], 0.03);
        let height = 0.5 * (after[0] + after[1]).y;
        assert!(height > 0.03 && height < 0.035, "{after:?}");
    }
}
