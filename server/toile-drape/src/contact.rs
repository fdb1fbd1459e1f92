//! What a surface says about the cloth near it, and the way out of it.

use glam::Vec3;
use toile_geometry::mesh::Adjacency;
use toile_geometry::nearest::descend;

use crate::folds;
use crate::skin_cells::SkinCells;

/// A surface that cloth stays outside of.
#[derive(Clone, Copy)]
pub struct Collider<'a> {
    /// Vertices in the space of the cloth, metres.
    pub vertices: &'a [Vec3],
    /// Unit vertex normals, outwards.
    pub normals: &'a [Vec3],
    /// Edges of the surface.
    pub ring: &'a Adjacency,
    /// For every vertex the one that faces it across a fold; empty where the surface has none.
    pub facing: &'a [u32],
    /// Which vertex is near a place; none where the surface is all one limb.
    pub cells: Option<&'a SkinCells>,
    /// Vertices of the left and of the right foot.
    pub feet: [&'a [u32]; 2],
}

/// Square of the sine of a fold's angle below which its mouth is not looked for.
const NARROWEST: f32 = 0.05;
/// Vertices of one limb are within this distance of each other where cells know one of them, metres.
const SAME_LIMB: f32 = 0.05;
/// Nor is it the same one, the foot seen from the shin, where what the contact knows is so many times as far away.
const CLEARLY_FARTHER: f32 = 1.2;
/// Cloth this near to its own limb is in no other, metres.
const CLOSE: f32 = 0.008;
/// Deeper in another limb cloth is left alone, metres: the limb has passed through it.
const PASSED: f32 = 0.02;
/// Longest way out of a fold taken at once, metres.
const LONGEST_WAY: f32 = 0.02;

/// What a surface says about a point near it.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// The nearest vertex, as far as it was looked for.
    pub hit: Option<u32>,
    /// Distance to the nearest vertex, metres.
    pub away: f32,
    /// Signed distance along that vertex's normal, metres.
    pub distance: f32,
    /// The normal.
    pub normal: Vec3,
    /// The same signed distance of the surface across a fold, infinite where there is none.
    pub across: f32,
    /// Its normal.
    pub across_normal: Vec3,
}

impl Contact {
    /// How deep the point lies in the body, on either side of a fold, metres; 0 outside.
    #[must_use]
    pub fn depth(&self) -> f32 {
        (-self.distance.min(self.across)).max(0.0)
    }

    /// Whether either surface is nearer than some metres.
    #[must_use]
    pub fn is_nearer(&self, metres: f32) -> bool {
        self.distance.min(self.across) < metres
    }

    /// The shortest way to `gap` in front of this surface and `fold_gap` in front of the one across the fold, metres;
    /// none where neither lacks more than `tolerance`. Where the surfaces meet, it leads to the fold's mouth.
    #[must_use]
    pub fn way_out(&self, gap: f32, fold_gap: f32, tolerance: f32) -> Vec3 {
        let (lack, lack_across) = (gap - self.distance, fold_gap - self.across);
        if lack <= tolerance && lack_across <= tolerance {
            return Vec3::ZERO;
        }
        let between = self.normal.dot(self.across_normal);
        if lack_across <= between * lack.max(0.0) {
            return self.normal * lack;
        }
        if lack <= between * lack_across.max(0.0) {
            return self.across_normal * lack_across;
        }
        let square = (1.0 - between * between).max(NARROWEST);
        let way = self.normal * (lack - between * lack_across)
            + self.across_normal * (lack_across - between * lack);
        (way / square).clamp_length_max(LONGEST_WAY)
    }

    /// A point at least `away` metres from the surface, outside.
    #[must_use]
    pub const fn far(away: f32) -> Self {
        Self {
            hit: None,
            away,
            distance: away,
            normal: Vec3::Y,
            across: f32::INFINITY,
            across_normal: Vec3::ZERO,
        }
    }
}

impl Collider<'_> {
    /// Signed distance of `point` along the normal of its nearest vertex, and that normal.
    #[must_use]
    pub fn clearance(&self, point: Vec3, candidates: &[u32]) -> (f32, Vec3) {
        let hit = descend(point, self.vertices, candidates, self.ring);
        let (_, distance, normal) = self.plane(point, hit);
        (distance, normal)
    }

    /// The same, and that of the surface across the fold in which the point may lie.
    #[must_use]
    pub fn contact(&self, point: Vec3, candidates: &[u32]) -> Contact {
        let hit = descend(point, self.vertices, candidates, self.ring);
        let (away, distance, normal) = self.plane(point, hit);
        let opposite = self.facing.get(hit as usize).copied().unwrap_or(folds::NONE);
        let (mut across, mut across_normal) = (f32::INFINITY, Vec3::ZERO);
        if opposite != folds::NONE {
            let (reach, d, n) = self.plane(point, descend(point, self.vertices, &[opposite], self.ring));
            if reach < folds::REACH {
                (across, across_normal) = (d, n);
            }
        }
        Contact { hit: Some(hit), away, distance, normal, across, across_normal }
    }

    /// Whether a point may lie in a limb that its contact does not know of.
    #[must_use]
    pub fn may_be_in_another(&self, point: Vec3, known: &Contact) -> bool {
        if known.away < CLOSE {
            return false;
        }
        let at = |v: u32| Some((*self.vertices.get(v as usize)?, *self.normals.get(v as usize)?));
        let Some(found) = self.cells.and_then(|cells| cells.at(point)).and_then(at) else { return false };
        let same = |hit: (Vec3, Vec3)| {
            hit.0.distance_squared(found.0) < SAME_LIMB * SAME_LIMB
                && hit.1.dot(found.1) > 0.0
                && known.away < CLEARLY_FARTHER * point.distance(found.0)
        };
        !known.hit.and_then(at).is_some_and(same)
    }

    /// The way to `gap` in front of a limb that a point lies in and that its contact does not know of, metres; none where
    /// this would lead into the limb that it knows.
    #[must_use]
    pub fn way_out_of_another(&self, point: Vec3, known: &Contact, gap: f32) -> Option<Vec3> {
        let vertex = self.cells?.at(point)?;
        let (away, distance, normal) = self.plane(point, descend(point, self.vertices, &[vertex], self.ring));
        let way = normal * (gap - distance);
        let is_inside = away < known.away && distance < 0.0 && distance > -PASSED;
        (is_inside && known.distance + way.dot(known.normal) > 0.0).then_some(way)
    }

    /// Distance of a point to a vertex, its signed distance along the vertex's normal, and the normal.
    fn plane(&self, point: Vec3, vertex: u32) -> (f32, f32, Vec3) {
        match (self.vertices.get(vertex as usize), self.normals.get(vertex as usize)) {
            (Some(v), Some(n)) => (point.distance(*v), (point - *v).dot(*n), *n),
            _ => (f32::INFINITY, f32::INFINITY, Vec3::Y),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{limb, sheet};

    #[test]
    fn clearance_is_negative_behind_the_surface() {
        let (vertices, triangles) = sheet(10);
        let ring = Adjacency::new(vertices.len(), &triangles);
        let normals = vec![Vec3::Y; vertices.len()];
        let surface = limb(&vertices, &normals, &ring);
        let below = Vec3::new(0.052, -0.004, 0.047);
        let (distance, normal) = surface.clearance(below, &[0]);
        assert!((distance + 0.004).abs() < 1e-6);
        assert_eq!(normal, Vec3::Y);
    }

    fn between(distance: f32, normal: Vec3, across: f32, across_normal: Vec3) -> Contact {
        Contact { hit: None, away: 0.0, distance, normal, across, across_normal }
    }

    #[test]
    fn the_way_out_of_one_surface_is_along_its_normal() {
        let one = between(-0.004, Vec3::Y, f32::INFINITY, Vec3::ZERO);
        assert!(one.way_out(0.003, 0.001, 0.0).distance(Vec3::Y * 0.007) < 1e-7);
        let clear = between(0.004, Vec3::Y, 0.002, Vec3::X);
        assert_eq!(clear.way_out(0.003, 0.001, 0.0), Vec3::ZERO);
        let across = between(0.01, Vec3::Y, -0.002, Vec3::X);
        assert!(across.way_out(0.003, 0.001, 0.0).distance(Vec3::X * 0.003) < 1e-7);
    }

    #[test]
    fn the_way_out_of_a_fold_leads_out_of_both_its_surfaces() {
        let (left, right) = (Vec3::new(0.96, 0.28, 0.0), Vec3::new(-0.6, 0.8, 0.0));
        let fold = between(-0.004, left, -0.001, right);
        let way = fold.way_out(0.003, 0.001, 0.0);
        assert!((way.dot(left) - 0.007).abs() < 1e-6 && (way.dot(right) - 0.002).abs() < 1e-6, "{way}");
        let closed = between(-0.01, Vec3::X, -0.01, Vec3::NEG_X);
        assert!(
            closed.way_out(0.003, 0.001, 0.0).length() <= LONGEST_WAY + 1e-6,
            "no jump where there is none"
        );
    }

    /// A sheet that faces up and another, some metres above it, without edges, that faces another way.
    fn two_sheets(above: f32, facing: Vec3) -> (Vec<Vec3>, Vec<Vec3>, Adjacency) {
        let (floor, triangles) = sheet(10);
        let normals = [vec![Vec3::Y; floor.len()], vec![facing; floor.len()]].concat();
        let other = floor.iter().map(|p| *p + Vec3::Y * above);
        let vertices: Vec<Vec3> = floor.iter().copied().chain(other).collect();
        let ring = Adjacency::new(vertices.len(), &triangles);
        (vertices, normals, ring)
    }

    #[test]
    fn cloth_in_a_limb_that_it_does_not_know_finds_its_way_out() {
        let (vertices, normals, ring) = two_sheets(0.026, Vec3::NEG_Y);
        let cells = SkinCells::new(&vertices, &normals);
        let surface = Collider { cells: Some(&cells), ..limb(&vertices, &normals, &ring) };
        let way = |height: f32| {
            let point = vertices[44] + Vec3::Y * height;
            let known = surface.contact(point, &[44]);
            let way = surface.way_out_of_another(point, &known, 0.001);
            surface.may_be_in_another(point, &known).then_some(way).flatten()
        };
        let out = way(0.031).expect("a way out");
        assert!(out.distance(Vec3::NEG_Y * 0.006) < 1e-6, "{out}");
        assert_eq!(way(0.0255), None, "in front of both");
        assert_eq!(way(-0.002), None, "that is for its own limb");
        assert!(cells.at(vertices[44] + Vec3::Y * 0.048).is_some());
        assert_eq!(way(0.048), None, "it has passed through");
    }

    #[test]
    fn cloth_in_a_foot_that_knows_the_shin_finds_its_way_out() {
        let (vertices, normals, ring) = two_sheets(0.03, Vec3::Y);
        let cells = SkinCells::new(&vertices, &normals);
        let surface = Collider { cells: Some(&cells), ..limb(&vertices, &normals, &ring) };
        let point = vertices[44] + Vec3::Y * 0.026;
        let known = surface.contact(point, &[44]);
        assert!(surface.may_be_in_another(point, &known), "the foot is near the shin and faces the same way");
        let out = surface.way_out_of_another(point, &known, 0.001).expect("a way out");
        assert!(out.distance(Vec3::Y * 0.005) < 1e-6, "{out}");
    }

    #[test]
    fn in_a_fold_both_surfaces_are_asked() {
        let (vertices, normals, ring) = two_sheets(-0.002, Vec3::NEG_Y);
        let count = vertices.len() as u32 / 2;
        let facing: Vec<u32> = (0..2 * count).map(|v| (v + count) % (2 * count)).collect();
        let surface = Collider { facing: &facing, ..limb(&vertices, &normals, &ring) };
        let contact = surface.contact(vertices[44] - Vec3::Y * 0.0005, &[44]);
        assert!((contact.distance + 0.0005).abs() < 1e-6);
        assert!((contact.across + 0.0015).abs() < 1e-6, "{contact:?}");
        assert_eq!(contact.across_normal, Vec3::NEG_Y);
        let far = surface.contact(vertices[44] + Vec3::Y * 0.1, &[44]);
        assert_eq!(far.across, f32::INFINITY, "out of the fold's reach");
    }
}
