//! Coarse outfits, cut finer for the network's graph: it is trained on edges of one to three centimetres.
//!
//! Training cuts the same way (`model/garment/refine.py`). `rest` space, metres.

use std::collections::HashMap;

use glam::Vec3;
use toile_geometry::mesh::edges;

/// Edges longer than this are halved, metres.
pub const LONGEST: f32 = 0.03;
/// Times that an edge is halved at most.
const ROUNDS: usize = 4;
/// Vertices from which nothing is halved any more.
const ENOUGH: usize = 60_000;

/// A mesh whose long edges are halved. The vertices of the coarse mesh come first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refined {
    /// Positions, metres.
    pub positions: Vec<Vec3>,
    /// Triangles, wound as before.
    pub triangles: Vec<[u32; 3]>,
    /// A vertex of the coarse mesh whose garment each vertex shares.
    pub origin: Vec<u32>,
}

impl Refined {
    /// Halves the long edges of a mesh until none is left, or the mesh is large enough.
    #[must_use]
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let mut mesh = Self {
            positions: positions.to_vec(),
            triangles: triangles.to_vec(),
            origin: (0..positions.len() as u32).collect(),
        };
        for _ in 0..ROUNDS {
            if mesh.positions.len() >= ENOUGH || !mesh.halve() {
                break;
            }
        }
        mesh
    }

    /// `values` of the coarse vertices, at all vertices.
    #[must_use]
    pub fn spread<T: Copy + Default>(&self, values: &[T]) -> Vec<T> {
        self.origin.iter().map(|&o| values.get(o as usize).copied().unwrap_or_default()).collect()
    }

    /// Halves every long edge once; whether there was one.
    fn halve(&mut self) -> bool {
        let mut middle = HashMap::new();
        for [a, b] in edges(&self.triangles) {
            let (Some(&p), Some(&q)) = (self.positions.get(a as usize), self.positions.get(b as usize))
            else {
                continue;
            };
            if p.distance(q) > LONGEST {
                middle.insert([a, b], self.positions.len() as u32);
                self.positions.push((p + q) / 2.0);
                self.origin.push(self.origin.get(a as usize).copied().unwrap_or_default());
            }
        }
        if !middle.is_empty() {
            self.triangles = self.triangles.iter().flat_map(|t| cut(*t, &middle)).collect();
        }
        !middle.is_empty()
    }
}

/// One triangle as one to four, by which of its edges have a middle.
fn cut([a, b, c]: [u32; 3], middle: &HashMap<[u32; 2], u32>) -> Vec<[u32; 3]> {
    let on = |p: u32, q: u32| middle.get(&[p.min(q), p.max(q)]).copied();
    match (on(a, b), on(b, c), on(c, a)) {
        (None, None, None) => vec![[a, b, c]],
        (Some(m), None, None) => vec![[a, m, c], [m, b, c]],
        (None, Some(m), None) => vec![[b, m, a], [m, c, a]],
        (None, None, Some(m)) => vec![[c, m, b], [m, a, b]],
        (Some(m), Some(n), None) => vec![[m, b, n], [a, m, n], [a, n, c]],
        (None, Some(m), Some(n)) => vec![[m, c, n], [b, m, n], [b, n, a]],
        (Some(n), None, Some(m)) => vec![[m, a, n], [c, m, n], [c, n, b]],
        (Some(l), Some(m), Some(n)) => vec![[a, l, n], [l, b, m], [n, m, c], [l, m, n]],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(mesh: &Refined) -> Vec3 {
        let at = |i: u32| mesh.positions[i as usize];
        mesh.triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)) / 2.0).sum()
    }

    #[test]
    fn long_edges_are_halved_until_none_is_left_and_the_surface_stays() {
        let corners = [Vec3::ZERO, Vec3::X * 0.2, Vec3::new(0.05, 0.09, 0.0), Vec3::new(0.21, 0.05, 0.0)];
        let coarse = [[0, 1, 2], [1, 3, 2]];
        let before =
            area(&Refined { positions: corners.to_vec(), triangles: coarse.to_vec(), origin: vec![] });
        let mesh = Refined::new(&corners, &coarse);
        assert_eq!(&mesh.positions[..4], &corners);
        assert!((area(&mesh) - before).length() < 1e-6);
        for [a, b] in edges(&mesh.triangles) {
            assert!(mesh.positions[a as usize].distance(mesh.positions[b as usize]) <= LONGEST);
        }
    }

    #[test]
    fn fine_meshes_stay_as_they_are() {
        let positions = [Vec3::ZERO, Vec3::X * 0.02, Vec3::Y * 0.02];
        let mesh = Refined::new(&positions, &[[0, 1, 2]]);
        assert_eq!(mesh.triangles, vec![[0, 1, 2]]);
        assert_eq!(mesh.spread(&[7, 8, 9]), vec![7, 8, 9]);
    }
}
