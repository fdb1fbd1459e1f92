//! The feet, of which cloth that knows the shin only knows nothing: seen from there, toes are behind a hollow.

use glam::Vec3;

use super::hanging::Hanging;
use crate::contact::{Collider, Contact};
use crate::graph::Links;
use crate::static_pass::StaticPass;

/// Of how many vertices of a foot one is looked at first.
const SPARSE: usize = 32;
/// How far from a foot it is looked for, metres.
const REACH: f32 = 0.05;
/// Distance from a vertex of the foot at which cloth is between toes, metres.
const BETWEEN: f32 = 0.008;
/// Length of the steps along the cloth's normal, metres, and how many there are at most: half a foot.
const STEP: f32 = 0.005;
const MOST: usize = 24;
/// How far in front of it cloth comes to lie, metres.
const AHEAD: f32 = 0.015;
/// Share of a node's lift that those beside it follow, and how far that goes.
const FOLLOW: f32 = 0.85;
const ROUNDS: usize = 5;

/// The feet of a posed body.
pub(super) struct Feet<'a> {
    pub(super) body: &'a Collider<'a>,
    feet: [Foot; 2],
}

struct Foot {
    /// Vertices from which the nearest is looked for.
    seeds: Vec<u32>,
    /// Corners of the box around it, world metres.
    low: Vec3,
    high: Vec3,
}

impl Foot {
    /// Whether it may be nearer than `reach` metres.
    fn is_near(&self, p: Vec3, reach: f32) -> bool {
        p.cmpge(self.low - reach).all() && p.cmple(self.high + reach).all()
    }
}

impl<'a> Feet<'a> {
    pub(super) fn of(body: &'a Collider<'a>) -> Self {
        let foot = |vertices: &[u32]| {
            let points = || vertices.iter().filter_map(|v| body.vertices.get(*v as usize));
            Foot {
                seeds: vertices.iter().copied().step_by(SPARSE).collect(),
                low: points().fold(Vec3::INFINITY, |low, p| low.min(*p)),
                high: points().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p)),
            }
        };
        Self { body, feet: body.feet.map(foot) }
    }

    /// The skin near `p` of what is `known` there and of a foot.
    pub(super) fn or_foot(&self, p: Vec3, known: Contact) -> Contact {
        let near = self.feet.iter().filter(|foot| foot.is_near(p, REACH));
        near.map(|foot| self.body.contact(p, &foot.seeds))
            .fold(known, |a, b| if b.away < a.away { b } else { a })
    }

    /// Adds to `moves` how far the hanging nodes `at` their places that lie in a foot are from in front of it along the
    /// cloth's normal, and what those around them follow: cloth that is pushed out of toes one by one stays around them.
    pub(super) fn lift(&self, hanging: &Hanging, statics: &StaticPass, at: &[Vec3], moves: &mut [Vec3]) {
        let members = || hanging.clusters().map(|c| &hanging.members[c]);
        let is_near = |n: &u32| self.feet.iter().any(|foot| foot.is_near(at[*n as usize], BETWEEN));
        let near: Vec<&Vec<u32>> = members().filter(|all| all.iter().any(is_near)).collect();
        let mut lifts = vec![Vec3::ZERO; at.len()];
        let mut lifted = Vec::new();
        for all in near {
            let nodes = || all.iter().map(|n| *n as usize);
            let normal = nodes().map(|n| statics.settle.normal(n, at)).sum::<Vec3>().normalize_or_zero();
            for n in nodes() {
                lifts[n] = self.way_out(at[n], normal);
            }
            lifted.extend(nodes().filter(|n| lifts[*n] != Vec3::ZERO));
        }
        if lifted.is_empty() {
            return;
        }
        pass_on(&mut lifts, lifted, &statics.near);
        members().flatten().for_each(|n| moves[*n as usize] += lifts[*n as usize]);
    }

    /// The way of cloth at `p` along its `normal` to in front of the foot that it is in.
    fn way_out(&self, p: Vec3, normal: Vec3) -> Vec3 {
        let Some(foot) = self.feet.iter().find(|foot| foot.is_near(p, BETWEEN)) else { return Vec3::ZERO };
        let is_in = |way: &f32| {
            let contact = self.body.contact(p + normal * *way, &foot.seeds);
            contact.distance < 0.0 || contact.away < BETWEEN
        };
        let last = (0..MOST).map(|k| STEP * k as f32).take_while(is_in).last();
        last.filter(|way| *way > 0.0).map_or(Vec3::ZERO, |way| normal * (way + AHEAD))
    }
}

/// Gives nodes beside those that are `lifted` a share of their lifts, where these are longer than their own.
fn pass_on(lifts: &mut [Vec3], mut lifted: Vec<usize>, near: &Links) {
    for _ in 0..ROUNDS {
        let mut next = Vec::new();
        for (n, lift) in lifted.into_iter().map(|n| (n, lifts[n] * FOLLOW)).collect::<Vec<_>>() {
            for (m, _) in near.row(n) {
                if lift.length_squared() > lifts[m].length_squared() {
                    lifts[m] = lift;
                    next.push(m);
                }
            }
        }
        next.sort_unstable();
        next.dedup();
        lifted = next;
    }
}

#[cfg(test)]
mod tests {
    use toile_geometry::mesh::Adjacency;

    use super::*;
    use crate::settle::tests::hung;
    use crate::test_meshes::{limb, sheet};

    #[test]
    fn cloth_over_a_foot_sees_it_from_where_it_knows_the_shin() {
        let (floor, triangles) = sheet(10);
        let count = floor.len() as u32;
        let shin = floor.iter().map(|p| Vec3::new(-0.02, p.x, p.z));
        let vertices: Vec<Vec3> = floor.iter().copied().chain(shin).collect();
        let normals: Vec<Vec3> = (0..2 * count).map(|v| if v < count { Vec3::Y } else { Vec3::X }).collect();
        let both: Vec<[u32; 3]> =
            [0, count].iter().flat_map(|n| triangles.iter().map(move |t| t.map(|v| v + n))).collect();
        let ring = Adjacency::new(vertices.len(), &both);
        let foot: Vec<u32> = (0..count).collect();
        let body = Collider { feet: [&foot, &[]], ..limb(&vertices, &normals, &ring) };
        let feet = Feet::of(&body);
        let seen = |p: Vec3| feet.or_foot(p, body.contact(p, &[count]));
        let under = floor[44] - Vec3::Y * 0.004;
        assert!((seen(under).distance + 0.004).abs() < 1e-6, "it is in the foot");
        let at_shin = Vec3::new(-0.01, 0.04, 0.05);
        assert!(seen(at_shin).hit.is_some_and(|v| v >= count), "the shin is nearer");
        assert!(seen(floor[44] + Vec3::Y * 0.02).hit.is_some_and(|v| v < count), "the foot is nearer");
        let above = Vec3::new(0.09, 0.06, 0.05);
        assert!(seen(above).hit.is_some_and(|v| v >= count), "no foot is looked for from far away");
    }

    #[test]
    fn toes_that_came_through_a_hem_end_up_behind_it() {
        let (statics, fitted) = hung(0.1);
        let nodes = fitted.node_edges.at(&fitted.rest);
        let toe = Vec3::new(0.15, 0.2, 0.0);
        let (ends, triangles) = sheet(9);
        // A plate from behind the cloth to 3 cm in front of it.
        let vertices: Vec<Vec3> =
            ends.iter().map(|p| toe + Vec3::new(p.x - 0.053, 0.0, p.z - 0.043)).collect();
        let normals = vec![Vec3::Y; vertices.len()];
        let ring = Adjacency::new(vertices.len(), &triangles);
        let foot: Vec<u32> = (0..vertices.len() as u32).collect();
        let body = Collider { feet: [&foot, &[]], ..limb(&vertices, &normals, &ring) };
        let mut moves = vec![Vec3::ZERO; nodes.len()];
        Feet::of(&body).lift(&fitted.hanging, &statics, &nodes, &mut moves);
        let at_toe = |p: &Vec3| p.x > 0.1 && (p.y - 0.2).abs() < 0.006 && p.z.abs() < 0.03;
        let lifted: Vec<Vec3> =
            nodes.iter().zip(&moves).filter(|(p, _)| at_toe(p)).map(|(p, moved)| *p + *moved).collect();
        assert!(!lifted.is_empty() && lifted.iter().all(|p| p.x > 0.18), "{lifted:?}");
        let far = nodes.iter().zip(&moves).filter(|(p, _)| p.x < 0.0);
        assert!(far.map(|(_, moved)| moved.length()).sum::<f32>() < 1e-6);
    }
}
