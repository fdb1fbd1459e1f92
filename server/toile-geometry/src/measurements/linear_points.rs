//! Points of the surface as a linear function of shape coefficients.

use glam::Vec3;

use crate::body::ShapeBasis;

/// Points with their own part of the shape basis.
#[derive(Debug)]
pub(super) struct LinearPoints {
    /// x, y, z, x, …, metres.
    template: Vec<f32>,
    /// How `template` moves with each coefficient, (coefficients, template), row-major.
    basis: Vec<f32>,
    /// The edge of the body that each point lies on, and how far along it.
    ends: Vec<([u32; 2], f32)>,
}

impl LinearPoints {
    /// Points on edges of the body (two vertices, and how far along); `None` where there is no vertex.
    pub fn new(points: &[([u32; 2], f32)], template: &[f32], basis: &ShapeBasis) -> Option<Self> {
        let width = points.len() * 3;
        let mut out = Self {
            template: Vec::with_capacity(width),
            basis: vec![0.0; width * basis.coefficient_count()],
            ends: points.to_vec(),
        };
        for (k, &([a, b], t)) in points.iter().enumerate() {
            let at = |v: u32| template.get(v as usize * 3..v as usize * 3 + 3).map(Vec3::from_slice);
            out.template.extend_from_slice(&at(a)?.lerp(at(b)?, t).to_array());
            let moves = basis.of_vertex(a as usize).into_iter().zip(basis.of_vertex(b as usize));
            for (row, (a, b)) in out.basis.chunks_exact_mut(width).zip(moves) {
                let moved = Vec3::from(a).lerp(b.into(), t);
                row.get_mut(k * 3..k * 3 + 3)?.copy_from_slice(&moved.to_array());
            }
        }
        Some(out)
    }

    /// Their positions for shape coefficients.
    pub fn at(&self, coefficients: &[f32]) -> Vec<Vec3> {
        let mut out = self.template.clone();
        for (row, &c) in self.rows().zip(coefficients).filter(|(_, c)| **c != 0.0) {
            out.iter_mut().zip(row).for_each(|(o, v)| *o += c * v);
        }
        out.chunks_exact(3).map(Vec3::from_slice).collect()
    }

    /// Moves the points by the offsets of the body's vertices, none where the body has none.
    pub fn offset(&self, points: &mut [Vec3], offsets: &[Vec3]) {
        let of = |v: u32| offsets.get(v as usize).copied().unwrap_or_default();
        points.iter_mut().zip(&self.ends).for_each(|(p, ([a, b], t))| *p += of(*a).lerp(of(*b), *t));
    }

    /// Derivative by the coefficients of what has a `gradient` by the points from `first` on.
    pub fn pull_back(&self, first: usize, gradient: &[Vec3]) -> Vec<f64> {
        let flat: Vec<f32> = gradient.iter().flat_map(|g| g.to_array()).collect();
        let span = first * 3..first * 3 + flat.len();
        self.rows().map(|row| row.get(span.clone()).map_or(0.0, |row| dot(row, &flat))).collect()
    }

    fn rows(&self) -> impl Iterator<Item = &[f32]> {
        self.basis.chunks_exact(self.template.len().max(1))
    }
}

/// Dot product in eight lanes, which the compiler turns into vector instructions.
fn dot(a: &[f32], b: &[f32]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut lanes = [0.0_f32; 8];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..8 {
            lanes[lane] += a[lane] * b[lane];
        }
    }
    let rest: f32 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    f64::from(lanes.iter().sum::<f32>() + rest)
}
