//! Where a surface passes through itself or through another.

use glam::{UVec3, Vec3};

/// Cells of a grid at most.
const CELLS: f32 = 1e6;
/// Side of a cell over the mean length of the triangles' sides.
const SIDE: f32 = 1.0;

/// What an edge passes through.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Crossing {
    /// A triangle of its own piece.
    pub own: bool,
    /// A triangle of another piece.
    pub other: bool,
}

/// For every edge what it passes through, but for triangles that it touches at a vertex.
///
/// `piece` tells the piece of every vertex. Indices beyond the positions are ignored.
#[must_use]
pub fn crossings(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    edges: &[[u32; 2]],
    piece: &[u32],
) -> Vec<Crossing> {
    let corners: Vec<Option<[Vec3; 3]>> = triangles.iter().map(|t| points(positions, t)).collect();
    let grid = Grid::new(&corners);
    let of = |v: u32| piece.get(v as usize);
    let through = |edge: &[u32; 2]| {
        let mut out = Crossing::default();
        let Some(ends) = points(positions, edge) else { return out };
        grid.visit(&ends, |index| {
            let (Some(triangle), Some(Some(corner))) = (triangles.get(index), corners.get(index)) else {
                return;
            };
            let own = of(edge[0]) == of(triangle[0]);
            let known = if own { out.own } else { out.other };
            let apart = edge.iter().all(|v| !triangle.contains(v));
            if !known && apart && passes_through(ends, *corner) {
                *(if own { &mut out.own } else { &mut out.other }) = true;
            }
        });
        out
    };
    edges.iter().map(through).collect()
}

/// Whether a segment passes through a triangle (Möller and Trumbore 1997).
#[must_use]
pub fn passes_through([from, to]: [Vec3; 2], [a, b, c]: [Vec3; 3]) -> bool {
    let (along, u, v) = (to - from, b - a, c - a);
    let h = along.cross(v);
    let det = u.dot(h);
    if det.abs() < 1e-14 {
        return false;
    }
    let s = from - a;
    let x = s.dot(h) / det;
    if x <= 0.0 || x >= 1.0 {
        return false;
    }
    let q = s.cross(u);
    let (y, at) = (along.dot(q) / det, v.dot(q) / det);
    y > 0.0 && x + y < 1.0 && at > 0.0 && at < 1.0
}

fn points<const N: usize>(positions: &[Vec3], indices: &[u32; N]) -> Option<[Vec3; N]> {
    let mut out = [Vec3::ZERO; N];
    for (point, &i) in out.iter_mut().zip(indices) {
        *point = *positions.get(i as usize)?;
    }
    Some(out)
}

fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)))
}

/// Triangles by the cells of a regular grid that their boxes meet, packed.
struct Grid {
    low: Vec3,
    side: f32,
    size: UVec3,
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Grid {
    fn new(corners: &[Option<[Vec3; 3]>]) -> Self {
        let all: Vec<Vec3> = corners.iter().flatten().flatten().copied().collect();
        let (low, high) = bounds(&all);
        let extent = if all.is_empty() { Vec3::ZERO } else { high - low };
        let sides =
            corners.iter().flatten().map(|[a, b, c]| a.distance(*b) + b.distance(*c) + c.distance(*a));
        let mean = sides.sum::<f32>() / (all.len().max(1) as f32);
        let side = (SIDE * mean)
            .max((extent.x * extent.y * extent.z / CELLS).cbrt())
            .max(1e-4 + extent.max_element() / 1e3);
        let size = (extent / side).floor().as_uvec3() + UVec3::ONE;
        let mut grid = Self { low, side, size, starts: Vec::new(), triangles: Vec::new() };
        grid.fill(corners);
        grid
    }

    fn fill(&mut self, corners: &[Option<[Vec3; 3]>]) {
        let mut entries = Vec::new();
        for (index, corner) in corners.iter().enumerate() {
            if let Some(corner) = corner {
                entries.extend(self.cells(corner).map(|cell| (cell, index as u32)));
            }
        }
        self.starts = vec![0; (self.size.x * self.size.y * self.size.z) as usize + 1];
        for (cell, _) in &entries {
            self.starts[*cell + 1] += 1;
        }
        for i in 1..self.starts.len() {
            self.starts[i] += self.starts[i - 1];
        }
        let mut next = self.starts.clone();
        self.triangles = vec![0; entries.len()];
        for (cell, index) in entries {
            self.triangles[next[cell] as usize] = index;
            next[cell] += 1;
        }
    }

    /// Cells that the box around some points meets.
    fn cells(&self, points: &[Vec3]) -> impl Iterator<Item = usize> + use<> {
        let (low, high) = bounds(points);
        let cell =
            |p: Vec3| ((p - self.low) / self.side).max(Vec3::ZERO).as_uvec3().min(self.size - UVec3::ONE);
        let (first, last, size) = (cell(low), cell(high), self.size);
        (first.z..=last.z).flat_map(move |z| {
            (first.y..=last.y)
                .flat_map(move |y| (first.x..=last.x).map(move |x| ((z * size.y + y) * size.x + x) as usize))
        })
    }

    /// Triangles near some points, some more than once.
    fn visit(&self, points: &[Vec3], mut found: impl FnMut(usize)) {
        for cell in self.cells(points) {
            if let (Some(&from), Some(&to)) = (self.starts.get(cell), self.starts.get(cell + 1)) {
                for &index in self.triangles.get(from as usize..to as usize).unwrap_or(&[]) {
                    found(index as usize);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::edges;

    /// A strip of ten squares of 1 cm along x, at height `y`.
    fn strip(y: f32, first: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let positions = (0..22).map(|i| Vec3::new((i / 2) as f32 * 0.01, y, (i % 2) as f32 * 0.01)).collect();
        let squares = (0..10).map(|i| first + 2 * i);
        (positions, squares.flat_map(|a| [[a, a + 1, a + 2], [a + 2, a + 1, a + 3]]).collect())
    }

    fn two_strips() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let ((mut positions, mut triangles), (above, more)) = (strip(0.0, 0), strip(0.005, 22));
        positions.extend(above);
        triangles.extend(more);
        (positions, triangles)
    }

    fn counts(positions: &[Vec3], triangles: &[[u32; 3]], piece: &[u32]) -> (usize, usize) {
        let found = crossings(positions, triangles, &edges(triangles), piece);
        (found.iter().filter(|c| c.own).count(), found.iter().filter(|c| c.other).count())
    }

    #[test]
    fn strips_apart_do_not_cross_and_a_vertex_pushed_through_does() {
        let (mut positions, triangles) = two_strips();
        let pieces: Vec<u32> = (0..44).map(|i| i / 22).collect();
        assert_eq!(counts(&positions, &triangles, &pieces), (0, 0));
        positions[8] += Vec3::new(0.003, 0.01, 0.003);
        let (own, other) = counts(&positions, &triangles, &pieces);
        assert_eq!(own, 0);
        assert!(other >= 3, "the edges of the vertex and none far from it: {other}");
        assert_eq!(counts(&positions, &triangles, &[0; 44]), (other, 0), "as one piece it crosses itself");
    }

    #[test]
    fn every_pair_is_found_that_comparing_all_finds() {
        let (mut positions, triangles) = two_strips();
        for (i, p) in positions.iter_mut().enumerate() {
            p.y += 0.01 * (i as f32 * 2.4).sin();
        }
        let all = edges(&triangles);
        let slow = |e: &[u32; 2]| {
            let hit = |t: &&[u32; 3]| {
                let corner = [positions[t[0] as usize], positions[t[1] as usize], positions[t[2] as usize]];
                e.iter().all(|v| !t.contains(v))
                    && passes_through([positions[e[0] as usize], positions[e[1] as usize]], corner)
            };
            triangles.iter().any(|t| hit(&t))
        };
        let found = crossings(&positions, &triangles, &all, &[0; 44]);
        assert!(found.iter().any(|c| c.own));
        assert!(found.iter().zip(&all).all(|(c, e)| c.own == slow(e)));
    }

    #[test]
    fn no_triangles_and_wrong_indices_are_harmless() {
        assert!(crossings(&[], &[], &[], &[]).is_empty());
        assert_eq!(crossings(&[Vec3::ZERO], &[[0, 1, 2]], &[[0, 9]], &[]), [Crossing::default()]);
    }
}
