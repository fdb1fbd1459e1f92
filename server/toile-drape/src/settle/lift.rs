//! Cloth that a limb passes through is lifted over the limb, before it falls.
//!
//! Pushed out of a knee that came through a skirt, the cloth in the knee is stretched over it and torn open while the cloth
//! around stays. Here what lies around comes along.

use glam::{Vec3, Vec3A};

use super::fall::{GAP, Skin};
use super::hanging::Hanging;
use crate::contact::{Collider, Contact};
use crate::static_pass::StaticPass;

/// Depth from which cloth is lifted, metres: what is less deep finds its way out by itself. And how near the skin is at
/// most, as limbs are no thicker.
const DEEP: f32 = 0.012;
const THICKEST: f32 = 0.1;
/// Cosine of the angle between cloth and nearest skin from which this is the side that the cloth lies on. In folds of the
/// body it is not.
const AGREE: f32 = 0.45;
/// Length of the steps along the cloth's normal, metres, and how many there are at most.
const STEP: f32 = 0.01;
const MOST: usize = 12;
/// Share of a cluster's lift that those beside it follow, and how far that goes.
const FOLLOW: f32 = 0.85;
const ROUNDS: usize = 5;

impl Hanging {
    /// Lifts clusters at `p` that lie deep in the body along the cloth's normal, and those around them; `nodes`: where the
    /// nodes are. World metres.
    pub(super) fn lift(
        &self,
        statics: &StaticPass,
        body: &Collider<'_>,
        nodes: &[Vec3],
        skin: &mut Skin,
        p: &mut [Vec3A],
    ) {
        let is_deep = |c: &Contact| c.distance < -DEEP && c.away < THICKEST;
        let deep: Vec<usize> = self.clusters().filter(|c| is_deep(&skin.contacts[*c])).collect();
        if deep.is_empty() {
            return;
        }
        let normals: Vec<Vec3A> = statics.settle.normals(nodes).map(Vec3A::from).collect();
        let mut lifts = vec![Vec3A::ZERO; p.len()];
        for c in deep {
            let normal: Vec3A = self.members[c].iter().map(|n| normals[*n as usize]).sum();
            lifts[c] = out(body, p[c], normal.normalize_or_zero(), skin, c);
        }
        self.pass_on(&mut lifts);
        for c in self.clusters() {
            p[c] += lifts[c];
            skin.last[c] = p[c];
        }
    }

    /// Gives clusters beside those that are lifted a share of their lifts, where these are longer than their own.
    fn pass_on(&self, lifts: &mut [Vec3A]) {
        for _ in 0..ROUNDS {
            let before = lifts.to_vec();
            for edge in &self.edges {
                let [a, b] = edge.ends.map(|c| c as usize);
                for (from, to) in [(a, b), (b, a)] {
                    let lift = before[from] * FOLLOW;
                    if lift.length_squared() > lifts[to].length_squared() {
                        lifts[to] = lift;
                    }
                }
            }
        }
    }
}

/// The way of a cluster at `p` along the cloth's `normal` to where it is out of the body, where this is its side of it.
fn out(body: &Collider<'_>, p: Vec3A, normal: Vec3A, skin: &mut Skin, c: usize) -> Vec3A {
    let mut contact = skin.contacts[c];
    if normal.dot(contact.normal.into()) < AGREE {
        return Vec3A::ZERO;
    }
    for step in 1..=MOST {
        let way = normal * (STEP * step as f32);
        contact = body.contact((p + way).into(), contact.hit.as_slice());
        if contact.distance > GAP {
            skin.contacts[c] = contact;
            return way;
        }
    }
    Vec3A::ZERO
}

#[cfg(test)]
mod tests {
    use std::f32::consts::PI;

    use toile_geometry::mesh::Adjacency;

    use super::*;
    use crate::settle::feet::Feet;
    use crate::settle::hanging::means;
    use crate::settle::tests::hung;
    use crate::test_meshes::limb;

    /// How far the clusters of a tube 30 cm wide are lifted, and where from, by a ball of 6 cm around `x`, metres,
    /// whose first vertex is the farthest `out` or in, 1 or -1.
    fn lifted(x: f32, out: f32) -> Vec<(Vec3A, Vec3A)> {
        let centre = Vec3::new(x, 0.2, 0.0);
        // Rings of eight around the poles.
        let at = |i: u32| {
            let (down, around) = (PI * (i / 8) as f32 / 8.0, 0.25 * PI * (i % 8) as f32);
            Vec3::new(out * down.cos(), down.sin() * around.cos(), down.sin() * around.sin())
        };
        let quad = |i: u32| {
            let next = i - i % 8 + (i + 1) % 8;
            [[i, i + 8, next], [next, i + 8, next + 8]]
        };
        let normals: Vec<Vec3> = (0..72).map(at).collect();
        let triangles: Vec<[u32; 3]> = (0..64).flat_map(quad).collect();
        let vertices: Vec<Vec3> = normals.iter().map(|n| centre + *n * 0.06).collect();
        let ring = Adjacency::new(vertices.len(), &triangles);
        let body = limb(&vertices, &normals, &ring);
        let (statics, fitted) = hung(0.1);
        let (hanging, nodes) = (&fitted.hanging, fitted.node_edges.at(&fitted.rest));
        let before: Vec<Vec3A> = means(&hanging.members, &nodes).into_iter().map(Vec3A::from).collect();
        let (mut skin, mut p) = (hanging.skin(&statics, &Feet::of(&body), &before), before.clone());
        hanging.lift(&statics, &body, &nodes, &mut skin, &mut p);
        before.iter().zip(p).map(|(before, p)| (*before, p - before)).collect()
    }

    #[test]
    fn cloth_around_a_limb_that_came_through_is_lifted_with_what_lies_in_it() {
        let all = lifted(0.13, 1.0);
        let beside = |(p, _): &&(Vec3A, Vec3A)| {
            p.x > 0.0 && (0.07..0.1).contains(&p.with_x(0.0).distance(Vec3A::Y * 0.2))
        };
        let least = all.iter().filter(beside).map(|(_, lift)| lift.x).reduce(f32::min);
        assert!(least.is_some_and(|least| least > 0.01), "{least:?}");
        let most = all.iter().map(|(_, lift)| lift.x).fold(0.0, f32::max);
        assert!((0.04..0.1).contains(&most), "{most}");
        assert!(all.iter().filter(|(p, _)| p.x < -0.1).all(|(_, lift)| lift.length() < 1e-6));
    }

    #[test]
    fn cloth_that_lies_on_the_other_side_of_a_limb_is_not_lifted_through_it() {
        assert!(lifted(0.19, -1.0).iter().all(|(_, lift)| *lift == Vec3A::ZERO));
    }
}
