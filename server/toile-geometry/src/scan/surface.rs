//! A scan as evenly spread points with normals, whatever its triangles are like.

use glam::{Vec2, Vec3};

use crate::mesh::Mesh;
use crate::nearest::PointTree;

/// Points that a surface is sampled at.
const SAMPLES: usize = 8000;
/// Nearest samples that a normal is the mean of, with itself: triangles of noisy corners are tilted by tens of degrees.
const SMOOTHED: usize = 8;
/// Least cosine of two such normals: a thin hand has two sides.
const ALIKE: f32 = 0.3;
/// Nearest points among which those that face the same way are looked for.
const NEIGHBOURS: usize = 6;
/// How many of these count.
const FACING: usize = 2;
/// Cosine from which two surfaces face the same way.
const SAME_WAY: f32 = 0.5;
/// Steps of the two-dimensional golden sequence (Roberts, *The unreasonable effectiveness of quasirandom sequences*).
const GOLDEN: Vec2 = Vec2::new(0.754_877_7, 0.569_840_3);

/// Points on a surface.
pub(super) struct Surface {
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
    tree: PointTree,
}

impl Surface {
    /// Samples the triangles evenly; `None` where none has an area.
    pub(super) fn new(mesh: &Mesh) -> Option<Self> {
        let corner = |i: u32| mesh.positions.get(i as usize).copied();
        let corners =
            mesh.triangles.iter().filter_map(|&[a, b, c]| Some([corner(a)?, corner(b)?, corner(c)?]));
        let faces: Vec<([Vec3; 3], Vec3)> = corners
            .map(|[a, b, c]| ([a, b, c], (b - a).cross(c - a)))
            .filter(|(_, n)| n.length() > 0.0)
            .collect();
        let total: f64 = faces.iter().map(|(_, n)| f64::from(n.length())).sum();
        let (mut points, mut normals, mut passed) = (Vec::new(), Vec::new(), 0.0);
        for ([a, b, c], normal) in &faces {
            let before = passed;
            passed += f64::from(normal.length()) / total * SAMPLES as f64;
            // Every whole number that the running area passes is a sample of this triangle.
            for k in before.round() as usize..passed.round() as usize {
                let at = (GOLDEN * (k + 1) as f32).fract_gl();
                let at = if at.x + at.y > 1.0 { Vec2::ONE - at } else { at };
                points.push(*a + (*b - *a) * at.x + (*c - *a) * at.y);
                normals.push(normal.normalize_or_zero());
            }
        }
        let tree = PointTree::new(&points, |_| true)?;
        let normals = smoothed(&points, &normals, &tree);
        Some(Self { tree, points, normals })
    }

    /// Turned about the vertical by quarters.
    pub(super) fn turned(&self, quarters: usize) -> Option<Self> {
        let turn = |p: &Vec3| (0..quarters).fold(*p, |p, _| Vec3::new(p.z, p.y, -p.x));
        let points: Vec<Vec3> = self.points.iter().map(turn).collect();
        Some(Self {
            tree: PointTree::new(&points, |_| true)?,
            points,
            normals: self.normals.iter().map(turn).collect(),
        })
    }

    /// Corners of the bounding box.
    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        let bound =
            |pick: fn(Vec3, Vec3) -> Vec3| self.points.iter().copied().reduce(pick).unwrap_or_default();
        (bound(Vec3::min), bound(Vec3::max))
    }

    /// Where the nearest points that face the same way as a body's `normal` at `point` have the surface, and its normal
    /// there. Heights over a curved surface are as much too large by the surface's own normals beside the point as they
    /// are too small by the body's, so their mean counts (Rusinkiewicz, *A symmetric objective function for ICP*, 2019).
    pub(super) fn facing(&self, point: Vec3, normal: Vec3) -> Option<(Vec3, Vec3)> {
        let hits = self.tree.nearest_n(point, NEIGHBOURS);
        let found = hits.iter().filter_map(|h| {
            Some((*self.points.get(h.index as usize)?, *self.normals.get(h.index as usize)?))
        });
        let alike: Vec<_> = found.filter(|(_, n)| n.dot(normal) > SAME_WAY).take(FACING).collect();
        if alike.is_empty() {
            return None;
        }
        let height: f32 = alike.iter().map(|(p, n)| (point - *p).dot(0.5 * (*n + normal))).sum();
        let mean = alike.iter().map(|(_, n)| *n).sum::<Vec3>().normalize_or_zero();
        Some((point - mean * (height / alike.len() as f32), mean))
    }

    /// Turns all normals over where most of them face away from the `normals` at `points` of a body about as large.
    pub(super) fn turned_like(mut self, points: &[Vec3], normals: &[Vec3]) -> Self {
        let agrees = |(p, n): (&Vec3, &Vec3)| {
            self.normals.get(self.tree.nearest(*p).index as usize).is_some_and(|m| m.dot(*n) > 0.0)
        };
        let agreeing = points.iter().zip(normals).filter(|pair| agrees(*pair)).count();
        if 2 * agreeing < points.len() {
            self.normals.iter_mut().for_each(|n| *n = -*n);
        }
        self
    }
}

/// Every normal as the mean of those of the nearest samples on its side.
fn smoothed(points: &[Vec3], normals: &[Vec3], tree: &PointTree) -> Vec<Vec3> {
    let mean = |(point, normal): (&Vec3, &Vec3)| {
        let near = tree.nearest_n(*point, SMOOTHED);
        let others = near.iter().filter_map(|h| normals.get(h.index as usize));
        others.filter(|n| n.dot(*normal) > ALIKE).sum::<Vec3>().normalize_or_zero()
    };
    points.iter().zip(normals).map(mean).collect()
}
