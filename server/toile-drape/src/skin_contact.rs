//! What draped cloth lacks to its distance from the skin.

use glam::Vec3;

use crate::contact::{Collider, Contact};
use crate::fitted::{COARSE_EDGE, Coarse};
use crate::push_out::Push;
use crate::resolve::{STILL, TOLERANCE};
use crate::static_pass::StaticPass;
use crate::stretch::{self, Limit};

/// Distance that draped cloth keeps from the skin, metres, where its rest pose does too.
const SKIN_GAP: f32 = 0.003;
/// Distance that cloth keeps from the surface across a fold, metres: both sides may leave no more room.
const FOLD_GAP: f32 = 0.001;
/// Radius of the body's tightest curve that cloth spans, metres: decides how far a flat triangle can sink in.
const TIGHTEST_CURVE: f32 = 0.03;
/// Cloth further than this from the body needs no closer look, metres: centroids of triangles of 8 cm ask.
const FAR: f32 = 0.03;
/// Distance from the skin within which cloth may lack some, metres: more than any gap.
const WATCHED: f32 = 0.004;

/// The skin at every cloth vertex, kept up to date as vertices move.
pub struct SkinContact<'a> {
    statics: &'a StaticPass,
    body: &'a Collider<'a>,
    contacts: Vec<Contact>,
    /// Vertices near the skin; some are named twice.
    watched: Vec<u32>,
    /// Whether each vertex moved since the cloth between vertices was last looked at.
    moved: Vec<bool>,
    /// What each coarse triangle and edge lacked in its middle then, metres.
    between: (Vec<Vec3>, Vec<Vec3>),
    /// Edges that became so long that they can sink in between their ends.
    stretched: Vec<[usize; 2]>,
}

impl<'a> SkinContact<'a> {
    /// At world `positions` of the cloth, welded order.
    pub fn new(statics: &'a StaticPass, body: &'a Collider<'a>, positions: &[Vec3]) -> Self {
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
        let contacts: Vec<Contact> = positions.iter().enumerate().map(at).collect();
        let near = |v: &u32| contacts[*v as usize].is_nearer(WATCHED);
        let watched = (0..contacts.len() as u32).filter(near).collect();
        let moved = vec![true; contacts.len()];
        Self { statics, body, contacts, watched, moved, between: Default::default(), stretched: vec![] }
    }

    /// The skin at every vertex.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Moves vertices at `positions`.
    pub fn push(&mut self, positions: &mut [Vec3], push: &[Push]) {
        for &(v, way) in push.iter().filter(|p| p.1.length_squared() > STILL * STILL) {
            positions[v as usize] += way;
            self.update(v as usize, positions[v as usize]);
        }
    }

    fn update(&mut self, v: usize, position: Vec3) {
        if let (Some(contact), Some(moved)) = (self.contacts.get_mut(v), self.moved.get_mut(v)) {
            *moved = true;
            let was_watched = contact.is_nearer(WATCHED);
            // It moved by little: what was nearest is near what is.
            let from = contact.hit.as_ref().map(std::slice::from_ref);
            *contact = self.body.contact(position, from.unwrap_or_else(|| self.statics.candidates_of(v)));
            if contact.is_nearer(WATCHED) && !was_watched {
                self.watched.push(v as u32);
            }
        }
    }

    /// Shortens the edges beyond the limit.
    pub fn shorten(&mut self, positions: &mut [Vec3], lengths: &[f32], limit: Limit) {
        let found = stretch::shorten(positions, &self.statics.edges, lengths, limit);
        for v in found.moved {
            self.update(v, positions[v]);
        }
        let is_long =
            |[a, b]: &[usize; 2]| positions[*a].distance_squared(positions[*b]) > COARSE_EDGE * COARSE_EDGE;
        self.stretched = found.near.into_iter().filter(is_long).collect();
    }

    /// How many vertices are inside the body.
    pub fn inside(&self) -> usize {
        self.contacts.iter().filter(|c| c.depth() > 0.0).count()
    }

    fn gap(&self, v: usize) -> f32 {
        self.statics.clearance.get(v).map_or(SKIN_GAP, |c| c.clamp(0.001, SKIN_GAP))
    }

    /// How much nearer to the skin a vertex may come, metres.
    pub fn room(&self, v: usize) -> f32 {
        self.contacts.get(v).map_or(0.0, |c| (c.distance - self.gap(v)).min(c.across - FOLD_GAP).max(0.0))
    }

    /// What each vertex lacks to its distance from the skin, on both sides of a fold.
    pub fn needs(&self, need: &mut [Vec3]) {
        need.fill(Vec3::ZERO);
        for v in self.watched.iter().map(|v| *v as usize) {
            need[v] = self.contacts[v].way_out(self.gap(v), FOLD_GAP, TOLERANCE);
        }
    }

    /// Vertices that may lie in a limb other than their own.
    pub fn strayed(&self, positions: &[Vec3]) -> Vec<u32> {
        let strays =
            |v: &u32| self.body.may_be_in_another(positions[*v as usize], &self.contacts[*v as usize]);
        (0..positions.len() as u32).filter(strays).collect()
    }

    /// Adds what they lack to lie outside of it.
    pub fn add_needs_of_strayed(&self, strayed: &[u32], positions: &[Vec3], need: &mut [Vec3]) {
        for v in strayed.iter().map(|v| *v as usize) {
            if let Some(way) = self.body.way_out_of_another(positions[v], &self.contacts[v], FOLD_GAP) {
                need[v] += way;
            }
        }
    }

    /// Whether an edge of a pushed vertex is beyond the limit.
    pub fn tears(&self, pushed: &[Push], positions: &[Vec3], rest: &[Vec3], limit: Limit) -> bool {
        let mut ends =
            pushed.iter().flat_map(|(v, _)| self.statics.ring.of(*v as usize).iter().map(|w| (*v, *w)));
        let between = |p: &[Vec3], (v, w): (u32, u32)| p[v as usize].distance(p[w as usize]);
        ends.any(|ends| between(positions, ends) > limit.stretch * between(rest, ends))
    }

    /// Adds what cloth between vertices near the skin lacks, to these vertices.
    pub fn add_needs_between(&mut self, positions: &[Vec3], coarse: &Coarse, need: &mut [Vec3]) {
        let (mut triangles, mut edges) = std::mem::take(&mut self.between);
        self.add_needs_of(&coarse.triangles, positions, &mut triangles, need);
        self.add_needs_of(&coarse.edges, positions, &mut edges, need);
        self.between = (triangles, edges);
        for &ends in &self.stretched {
            keep_longer(self.lack_in_the_middle(positions, ends), ends, need);
        }
        self.moved.fill(false);
    }

    /// The same of some pieces; `ways` is what each of them lacked when it was last looked at.
    fn add_needs_of<const N: usize>(
        &self,
        pieces: &[[u32; N]],
        positions: &[Vec3],
        ways: &mut Vec<Vec3>,
        need: &mut [Vec3],
    ) {
        ways.resize(pieces.len(), Vec3::ZERO);
        for (piece, way) in pieces.iter().zip(ways) {
            let corners = piece.map(|i| i as usize);
            if corners.iter().any(|&v| self.moved[v]) {
                *way = self.lack_in_the_middle(positions, corners);
            }
            keep_longer(*way, corners, need);
        }
    }

    /// What the middle of some corners lacks to its distance from the skin, metres.
    fn lack_in_the_middle<const N: usize>(&self, positions: &[Vec3], corners: [usize; N]) -> Vec3 {
        let at = corners.map(|v| positions[v]);
        let longest = (0..N).map(|i| at[i].distance_squared(at[(i + 1) % N])).fold(0.0, f32::max);
        let sinks = SKIN_GAP + longest / (8.0 * TIGHTEST_CURVE);
        if corners.iter().all(|&v| self.contacts[v].distance > sinks) {
            return Vec3::ZERO;
        }
        let middle = at.into_iter().sum::<Vec3>() / N as f32;
        let gap = 0.5 * self.gap(corners[0]);
        let contact = self.contact_between(corners, middle);
        contact.map_or(Vec3::ZERO, |contact| contact.way_out(gap, 0.5 * FOLD_GAP, TOLERANCE))
    }

    /// The skin at a point between vertices, looked for from what is nearest to each of them.
    fn contact_between<const N: usize>(&self, corners: [usize; N], point: Vec3) -> Option<Contact> {
        let hits = corners.map(|v| self.contacts.get(v).and_then(|c| c.hit));
        let first = hits.into_iter().flatten().next()?;
        Some(self.body.contact(point, &hits.map(|hit| hit.unwrap_or(first))))
    }
}

/// Lets corners `need` a way where it is longer than what they need already.
fn keep_longer<const N: usize>(way: Vec3, corners: [usize; N], need: &mut [Vec3]) {
    for v in corners {
        if need[v].length_squared() < way.length_squared() {
            need[v] = way;
        }
    }
}

#[cfg(test)]
mod tests {
    use toile_geometry::mesh::Adjacency;

    use super::*;
    use crate::test_meshes::limb;

    #[test]
    fn an_edge_that_became_long_clears_what_stands_between_its_ends() {
        let skin = [Vec3::ZERO, Vec3::new(0.03, 0.03, 0.0), Vec3::X * 0.06];
        let (normals, ring) = ([Vec3::Y; 3], Adjacency::new(3, &[[0, 1, 2]]));
        let body = limb(&skin, &normals, &ring);
        let statics = StaticPass { edges: vec![[0, 1]], ..StaticPass::default() };
        let mut cloth = [Vec3::new(0.0, 0.015, 0.0), Vec3::new(0.06, 0.015, 0.0)];
        let mut lack = |rest: f32| {
            let (mut contacts, mut need) = (SkinContact::new(&statics, &body, &cloth), vec![Vec3::ZERO; 2]);
            contacts.shorten(&mut cloth, &[rest], Limit { stretch: 2.9, rounds: 1 });
            contacts.add_needs_between(&cloth, &Coarse::default(), &mut need);
            need[0].y
        };
        assert_eq!(lack(0.055), 0.0);
        assert!(lack(0.022) > 0.014);
    }
}
