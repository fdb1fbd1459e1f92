//! Hanging cloth falls: its weight in a few steps, tethers to what holds it (Kim, Chentanez and Müller, Long Range
//! Attachments, 2012), edges that neither stretch nor shorten much (Müller et al., Position Based Dynamics, 2007), and the
//! skin, on which it hardly slides.

use glam::{Vec3, Vec3A};

use super::feet::Feet;
use super::hanging::{Edge, Hanging, Tether, means};
use crate::binding::CANDIDATES;
use crate::contact::{Collider, Contact};
use crate::static_pass::StaticPass;

/// Steps under weight, and those without it afterwards.
const STEPS: usize = 10;
const REST: usize = 3;
/// How far cloth would fall in all steps together, metres; more lets it collapse where nothing spreads it.
const FALL: f32 = 0.072;
/// Share of its length that an edge keeps; flutes give the cloth its width back.
const LEAST: f32 = 0.95;
/// Distance kept from the skin, metres, and the same on both sides of a fold of the body.
pub(super) const GAP: f32 = 0.006;
const FOLD_GAP: f32 = 0.001;
/// Distance from the skin up to which it holds cloth back, metres, and the share of the way that it takes.
const TOUCHING: f32 = 0.012;
const FRICTION: f32 = 0.7;
/// Steps from look to look at the skin, and how near it must be for one, metres.
const LOOKED: usize = 2;
const NEAR: f32 = 0.03;

impl Hanging {
    /// How far each node falls from `positions`, world metres.
    #[must_use]
    pub(super) fn fall(&self, statics: &StaticPass, feet: &Feet<'_>, positions: &[Vec3]) -> Vec<Vec3> {
        let body = feet.body;
        let before = means(&self.members, positions);
        let mut p: Vec<Vec3A> = before.iter().copied().map(Vec3A::from).collect();
        let mut skin = self.skin(statics, feet, &p);
        self.lift(statics, body, positions, &mut skin, &mut p);
        for step in 0..STEPS + REST {
            let left = (1.0 - step as f32 / STEPS as f32).max(0.0);
            let metres = 2.0 * FALL / STEPS as f32 * left;
            self.tethers.iter().for_each(|tether| tether.fall(metres, &mut p));
            self.edges.iter().for_each(|edge| edge.hold(&mut p));
            if step % LOOKED == 0 {
                self.clusters().for_each(|c| skin.keep_out(body, c, &mut p[c]));
            }
        }
        let moves: Vec<Vec3> = p.into_iter().zip(before).map(|(p, before)| Vec3::from(p) - before).collect();
        (0..positions.len()).map(|n| statics.settle.node_from_cluster.blended(n, &moves)).collect()
    }

    /// Clusters that fall.
    pub(super) fn clusters(&self) -> impl Iterator<Item = usize> {
        self.tethers.iter().map(|tether| tether.cluster as usize)
    }

    /// The skin near clusters at `p`.
    pub(super) fn skin(&self, statics: &StaticPass, feet: &Feet<'_>, p: &[Vec3A]) -> Skin {
        let mut contacts = vec![Contact::far(f32::INFINITY); p.len()];
        for c in self.clusters() {
            let node = self.members[c].first().map_or(0, |n| *n as usize);
            let near = statics.candidates.get(node * CANDIDATES..(node + 1) * CANDIDATES).unwrap_or(&[]);
            contacts[c] = feet.or_foot(p[c].into(), feet.body.contact(p[c].into(), near));
        }
        Skin { last: p.to_vec(), contacts }
    }
}

impl Tether {
    /// Lets a cluster fall by some metres, as far as the tether lets it.
    fn fall(&self, metres: f32, p: &mut [Vec3A]) {
        let from = p[self.anchor as usize];
        let between = p[self.cluster as usize] - Vec3A::Y * (metres * self.free) - from;
        let (square, most) = (between.length_squared(), self.length * self.length);
        p[self.cluster as usize] = from + between * (1.0 - first_order(square.min(most), square));
    }
}

impl Edge {
    /// Brings an edge back to its length if it is longer, and to the least if it is shorter than that.
    fn hold(&self, p: &mut [Vec3A]) {
        let [a, b] = self.ends.map(|n| n as usize);
        let between = p[b] - p[a];
        let (square, wanted) = (between.length_squared(), self.length * self.length);
        let way = between * first_order(square.clamp(LEAST * LEAST * wanted, wanted), square);
        p[a] += way * self.shares[0];
        p[b] -= way * self.shares[1];
    }
}

/// 1 less the root of `target` over `square`, without the root (Jakobsen, Advanced Character Physics, 2001).
fn first_order(target: f32, square: f32) -> f32 {
    1.0 - 2.0 * target / (target + square).max(f32::MIN_POSITIVE)
}

/// What is known of the skin near each cluster.
pub(super) struct Skin {
    /// Where the cluster was at the last look.
    pub last: Vec<Vec3A>,
    /// What was seen there.
    pub contacts: Vec<Contact>,
}

impl Skin {
    /// Moves a cluster at `p` out of the body and holds it back on the skin.
    fn keep_out(&mut self, body: &Collider<'_>, c: usize, p: &mut Vec3A) {
        let (last, known) = (self.last[c], &self.contacts[c]);
        if known.away - p.distance(last) > NEAR {
            return;
        }
        let contact = body.contact((*p).into(), known.hit.as_slice());
        *p += Vec3A::from(contact.way_out(GAP, FOLD_GAP, 0.0));
        if contact.distance < TOUCHING {
            let moved = *p - last;
            let normal = Vec3A::from(contact.normal);
            *p -= (moved - normal * moved.dot(normal)) * FRICTION;
        }
        (self.last[c], self.contacts[c]) = (*p, contact);
    }
}

#[cfg(test)]
mod tests {
    use toile_geometry::mesh::Adjacency;

    use super::*;
    use crate::settle::tests::hung;
    use crate::test_meshes::limb;

    /// A tube 30 cm wide and 50 cm high at rest, and where it falls from where it is `posed`, around a body that is one
    /// vertex; `clearance` of all its vertices at rest, metres.
    fn fallen(clearance: f32, posed: impl Fn(&Vec3) -> Vec3) -> (Vec<Vec3>, Vec<Vec3>) {
        let (statics, fitted) = hung(clearance);
        let (skin, ring) = ([Vec3::Y * 9.0], Adjacency::new(1, &[]));
        let body = limb(&skin, &[Vec3::NEG_Y], &ring);
        let mut positions: Vec<Vec3> = fitted.rest.iter().map(posed).collect();
        let moves = fitted.hanging.fall(&statics, &Feet::of(&body), &fitted.node_edges.at(&positions));
        fitted.node_edges.carry(&statics, &moves, &mut positions);
        (fitted.rest, positions)
    }

    /// A bell: the lower a point, the farther out, with the length of what hangs.
    fn bell(p: &Vec3) -> Vec3 {
        let below = (0.44 - p.y).max(0.0);
        Vec3::new(p.x, p.y, p.z) + p.with_y(0.0).normalize() * 0.6 * below + Vec3::Y * 0.2 * below
    }

    #[test]
    fn a_bell_comes_down_and_in_and_its_top_stays() {
        let (rest, after) = fallen(0.1, bell);
        for ((rest, before), after) in rest.iter().map(|p| (p, bell(p))).zip(after) {
            if rest.y > 0.48 {
                assert!(after.distance(before) < 0.01, "{before} {after}");
            } else if rest.y < 0.05 {
                assert!(after.y < before.y - 0.02 && after.y > rest.y - 0.02, "{before} {after}");
                assert!(after.with_y(0.0).length() < before.with_y(0.0).length() - 0.01, "{before} {after}");
            }
        }
    }

    #[test]
    fn cloth_that_hangs_already_and_cloth_on_the_skin_stay() {
        let moved = |(rest, after): (Vec<Vec3>, Vec<Vec3>)| {
            rest.iter().zip(after).map(|(p, q)| p.distance(q)).fold(0.0, f32::max)
        };
        assert!(moved(fallen(0.1, |p| *p)) < 0.01);
        assert!(moved(fallen(0.01, |p| *p)) == 0.0);
    }
}
