//! Tapes on the body: lengths and mass of a shape, and how they change with its coefficients.
//!
//! A tape is a list of points of the surface, laid once on the reference body. Its points, and the
//! vertices of the coarse closed mesh whose volume stands for the body's, are linear in the shape
//! coefficients, so a measurement costs some hundred points, not the whole body. Rest space.

use std::ops::Range;

use glam::Vec3;
use serde::Deserialize;

use super::MEASUREMENTS;
use super::linear_points::LinearPoints;
use crate::body::ShapeBasis;

const CENTIMETRES: f64 = 100.0;

/// How a tape measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TapeKind {
    /// Length around through all points and back to the first.
    Ring,
    /// Length from the first point to the last.
    Polyline,
    /// Height of the first point above the mean of the others.
    Height,
    /// Body mass, from the volume.
    Weight,
}

/// Body volume and mass from those of the coarse mesh.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct VolumeFit {
    /// Mean density of a body, kg/m³.
    pub density: f64,
    /// Body volume for one m³ of the coarse mesh.
    pub scale: f64,
    /// Body volume where the coarse mesh has none, m³.
    pub offset: f64,
}

/// Tapes as the body file has them. Vertices are the body's.
#[derive(Clone, Debug)]
pub struct TapeSource {
    /// The edge that each point lies on, and how far along it.
    pub points: Vec<([u32; 2], f32)>,
    /// Kind and points of each measurement.
    pub tapes: Vec<(TapeKind, Range<usize>)>,
    /// Vertices of the coarse mesh.
    pub coarse: Vec<u32>,
    /// Its triangles, over `coarse`.
    pub triangles: Vec<[u32; 3]>,
    /// From its volume to the body's.
    pub fit: VolumeFit,
}

/// Tapes with their own shape basis.
#[derive(Debug)]
pub struct Tape {
    tapes: [(TapeKind, Range<usize>); MEASUREMENTS],
    triangles: Vec<[u32; 3]>,
    fit: VolumeFit,
    points: LinearPoints,
    coarse: LinearPoints,
}

/// The points of all tapes, and the vertices of the coarse mesh (none unless asked for), metres.
#[derive(Debug, Default)]
pub(super) struct TapePoints {
    tapes: Vec<Vec3>,
    coarse: Vec<Vec3>,
}

impl Tape {
    /// Takes the tapes' share of the body's template and basis.
    ///
    /// `None` when there are not as many tapes as measurements, or an index or a size does not fit.
    #[must_use]
    pub fn new(source: TapeSource, template: &[f32], basis: &ShapeBasis) -> Option<Self> {
        let (points, coarse) = (source.points.len(), source.coarse.len());
        let fits = |kind: TapeKind, range: &Range<usize>| match kind {
            TapeKind::Weight => true,
            _ => range.start < range.end && range.end <= points && range.len() >= 2,
        };
        let mut corners = source.triangles.iter().flatten();
        if !source.tapes.iter().all(|(k, r)| fits(*k, r)) || corners.any(|&v| v as usize >= coarse) {
            return None;
        }
        let corners: Vec<_> = source.coarse.iter().map(|&v| ([v, v], 0.0)).collect();
        Some(Self {
            tapes: source.tapes.try_into().ok()?,
            triangles: source.triangles,
            fit: source.fit,
            points: LinearPoints::new(&source.points, template, basis)?,
            coarse: LinearPoints::new(&corners, template, basis)?,
        })
    }

    /// All measurements of shape coefficients, cm and kg, with the rest vertices moved by `offsets` (none: empty).
    #[must_use]
    pub fn measure(&self, coefficients: &[f32], offsets: &[Vec3]) -> [f64; MEASUREMENTS] {
        let mut points = self.points(coefficients, true);
        self.points.offset(&mut points.tapes, offsets);
        self.coarse.offset(&mut points.coarse, offsets);
        std::array::from_fn(|m| self.value(m, &points))
    }

    /// The points of shape coefficients; the coarse mesh's only when the body is `weighed`.
    pub(super) fn points(&self, coefficients: &[f32], weighed: bool) -> TapePoints {
        let coarse = if weighed { self.coarse.at(coefficients) } else { Vec::new() };
        TapePoints { tapes: self.points.at(coefficients), coarse }
    }

    /// Measurement `m` at points, cm or kg.
    pub(super) fn value(&self, m: usize, points: &TapePoints) -> f64 {
        let (kind, range) = &self.tapes[m];
        let tape = points.tapes.get(range.clone()).unwrap_or(&[]);
        match kind {
            TapeKind::Ring => length(tape, true) * CENTIMETRES,
            TapeKind::Polyline => length(tape, false) * CENTIMETRES,
            TapeKind::Height => height(tape) * CENTIMETRES,
            TapeKind::Weight => {
                self.fit.density * (self.fit.scale * self.volume(&points.coarse) + self.fit.offset)
            }
        }
    }

    /// Volume inside the coarse mesh by the divergence theorem, m³; 0 without its vertices.
    fn volume(&self, coarse: &[Vec3]) -> f64 {
        let at = |v: u32| coarse.get(v as usize).copied().unwrap_or(Vec3::ZERO);
        let six = |&[a, b, c]: &[u32; 3]| f64::from(at(a).dot(at(b).cross(at(c))));
        self.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    /// Derivative of measurement `m` by every coefficient, cm or kg, (coefficients,).
    pub(super) fn gradient(&self, m: usize, points: &TapePoints) -> Vec<f64> {
        let (kind, range) = &self.tapes[m];
        if *kind == TapeKind::Weight {
            return self.coarse.pull_back(0, &self.volume_gradient(&points.coarse));
        }
        let tape = points.tapes.get(range.clone()).unwrap_or(&[]);
        self.points.pull_back(range.start, &tape_gradient(*kind, tape))
    }

    /// Of the mass by the vertices of the coarse mesh, kg/m.
    fn volume_gradient(&self, coarse: &[Vec3]) -> Vec<Vec3> {
        let mut out = vec![Vec3::ZERO; coarse.len()];
        let scale = (self.fit.density * self.fit.scale / 6.0) as f32;
        let at = |v: u32| coarse.get(v as usize).copied().unwrap_or(Vec3::ZERO);
        for &[i, j, k] in &self.triangles {
            let (a, b, c) = (at(i) * scale, at(j) * scale, at(k));
            let sides = [(i, b.cross(c)), (j, c.cross(a)), (k, a.cross(at(j)))];
            for (v, side) in sides {
                if let Some(slot) = out.get_mut(v as usize) {
                    *slot += side;
                }
            }
        }
        out
    }
}

/// Gradient of a length by its points, cm/m.
fn tape_gradient(kind: TapeKind, tape: &[Vec3]) -> Vec<Vec3> {
    let mut out = vec![Vec3::ZERO; tape.len()];
    if kind == TapeKind::Height {
        out.fill(Vec3::NEG_Y * (CENTIMETRES as f32 / (tape.len().max(2) - 1) as f32));
        out.iter_mut().take(1).for_each(|first| *first = Vec3::Y * CENTIMETRES as f32);
        return out;
    }
    for (a, b) in steps(tape, kind == TapeKind::Ring) {
        let step = (tape[b] - tape[a]).normalize_or_zero() * CENTIMETRES as f32;
        out[b] += step;
        out[a] -= step;
    }
    out
}

/// Index pairs of the pieces of a tape; a closed one returns to its first point.
fn steps(tape: &[Vec3], closed: bool) -> impl Iterator<Item = (usize, usize)> {
    let count = tape.len();
    let pieces = if closed { count } else { count.saturating_sub(1) };
    (0..pieces).map(move |k| (k, (k + 1) % count))
}

fn length(tape: &[Vec3], closed: bool) -> f64 {
    steps(tape, closed).map(|(a, b)| f64::from(tape[a].distance(tape[b]))).sum()
}

/// Height of the first point above the mean of the others.
fn height(tape: &[Vec3]) -> f64 {
    let Some((first, others)) = tape.split_first() else { return 0.0 };
    let mean = others.iter().map(|p| f64::from(p.y)).sum::<f64>() / others.len().max(1) as f64;
    f64::from(first.y) - mean
}
