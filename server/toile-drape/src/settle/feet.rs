//! The feet, of which cloth that knows the shin only knows nothing: seen from there, toes are behind a hollow.

use glam::Vec3;

use crate::contact::{Collider, Contact};

/// Of how many vertices of a foot one is looked at first.
const SPARSE: usize = 16;
/// How far from a foot it is looked for, metres.
const REACH: f32 = 0.05;

/// The feet of a posed body.
pub(super) struct Feet<'a> {
    body: &'a Collider<'a>,
    feet: [Foot; 2],
}

struct Foot {
    /// Vertices from which the nearest is looked for.
    seeds: Vec<u32>,
    /// Corners of the box around what is near, world metres.
    low: Vec3,
    high: Vec3,
}

impl<'a> Feet<'a> {
    pub(super) fn of(body: &'a Collider<'a>) -> Self {
        let foot = |vertices: &[u32]| {
            let points = || vertices.iter().filter_map(|v| body.vertices.get(*v as usize));
            Foot {
                seeds: vertices.iter().copied().step_by(SPARSE).collect(),
                low: points().fold(Vec3::INFINITY, |low, p| low.min(*p)) - REACH,
                high: points().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p)) + REACH,
            }
        };
        Self { body, feet: body.feet.map(foot) }
    }

    /// The skin near `p` of what is `known` there and of a foot.
    pub(super) fn or_foot(&self, p: Vec3, known: Contact) -> Contact {
        let near = self.feet.iter().filter(|foot| p.cmpge(foot.low).all() && p.cmple(foot.high).all());
        near.map(|foot| self.body.contact(p, &foot.seeds))
            .fold(known, |a, b| if b.away < a.away { b } else { a })
    }
}

#[cfg(test)]
mod tests {
    use toile_geometry::mesh::Adjacency;

    use super::*;
    use crate::test_meshes::sheet;

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
        let body = Collider {
            vertices: &vertices,
            normals: &normals,
            ring: &ring,
            facing: &[],
            cells: None,
            feet: [&foot, &[]],
        };
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
}
