//! The body of given measurements: bounded, regularised least squares (Levenberg-Marquardt).
//!
//! Unknowns x are the phenotypes that are not fixed (age stays the reference's unless given) and the
//! local changes. With m(x) in cm and kg and targets t it minimises
//!
//! ```text
//! Σ (m(x) − t)² + PHENOTYPE_PULL Σ (x_p − ½)² + LOCAL_PULL Σ x_l²
//! ```
//!
//! so that what the measurements leave open stays average. Bounds: projected steps over the unknowns
//! that no bound holds (Kelley, *Iterative Methods for Optimization*, 1999, §5.5). The same as
//! `model/body/measure_solver.py`.

use std::collections::BTreeMap;

use super::tape::TapePoints;
use super::{MEASUREMENTS, Measurement, MeasurementError, Measurements, Miss, cholesky, units};
use crate::body::{AGE, Body, BodyShape, PARAMETERS, PHENOTYPES};

/// How strongly unknowns are drawn to the middle, cm².
const PHENOTYPE_PULL: f64 = 0.3;
const LOCAL_PULL: f64 = 0.1;
const ITERATIONS: usize = 25;
const FIRST_DAMPING: f64 = 1e-3;
const LEAST_DAMPING: f64 = 1e-7;
const MOST_DAMPING: f64 = 1e4;
/// Relative decrease of the cost that is no longer worth a step.
const ENOUGH: f64 = 1e-4;
/// A length that misses by more than this share and these centimetres cannot be had.
const LENGTH_TOLERANCE: (f32, f32) = (0.03, 2.0);
/// Mass likewise, in kg. Wider, because density and build differ between people of one shape.
const MASS_TOLERANCE: (f32, f32) = (0.08, 4.0);

/// Unknowns, with those in place that are fixed.
type Parameters = [f64; PARAMETERS];

/// A body of given measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// The body.
    pub shape: BodyShape,
    /// What it measures.
    pub achieved: Measurements,
    /// Achieved − requested of what was requested, cm or kg.
    pub residuals: BTreeMap<Measurement, f32>,
    /// Steps that it took.
    pub iterations: usize,
}

/// The body nearest to the requested measurements (cm or kg), with some phenotypes or local changes
/// `fixed` by name.
///
/// # Errors
/// [`MeasurementError`]: a value out of range, a fixed parameter that there is not or that is out of its
/// range, and measurements that no body has together.
pub fn solve(
    body: &Body,
    requested: &BTreeMap<Measurement, f32>,
    fixed: &BTreeMap<String, f32>,
) -> Result<Solution, MeasurementError> {
    for (&name, &value) in requested {
        if let Some(info) = body.measurements().get(name as usize) {
            units::check(name, value, info)?;
        }
    }
    let mut problem = Problem::new(body, requested, fixed)?;
    let iterations = problem.minimise();
    let shape = problem.shape();
    let achieved =
        Measurements(body.tape().measure(&body.terms().coefficients(&shape), &[]).map(|v| v as f32));
    let residuals = requested.iter().map(|(&name, &value)| (name, achieved.get(name) - value)).collect();
    let solution = Solution { shape, achieved, residuals, iterations };
    let misses = misses(&solution, requested);
    if misses.is_empty() { Ok(solution) } else { Err(MeasurementError::Unreachable { misses }) }
}

/// What misses by more than its tolerance, the worst first.
fn misses(solution: &Solution, requested: &BTreeMap<Measurement, f32>) -> Vec<Miss> {
    let excess = |miss: &Miss| {
        let (share, least) = if miss.name == Measurement::Weight { MASS_TOLERANCE } else { LENGTH_TOLERANCE };
        (miss.achieved - miss.requested).abs() / (miss.requested * share).max(least)
    };
    let all = requested.iter().map(|(&name, &requested)| Miss {
        name,
        requested,
        achieved: solution.achieved.get(name),
    });
    let mut out: Vec<Miss> = all.filter(|miss| excess(miss) > 1.0).collect();
    out.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
    out
}

/// Measurements requested of a body, and the best parameters so far.
struct Problem<'a> {
    body: &'a Body,
    targets: Vec<(usize, f64)>,
    /// Parameters that are not fixed.
    free: Vec<usize>,
    at: Parameters,
}

impl<'a> Problem<'a> {
    fn new(
        body: &'a Body,
        requested: &BTreeMap<Measurement, f32>,
        fixed: &BTreeMap<String, f32>,
    ) -> Result<Self, MeasurementError> {
        let at = BodyShape::from_values(body, fixed)?.parameters();
        let names = body.phenotype_names().iter().chain(body.local_change_names());
        let free = names.enumerate().filter(|(k, name)| *k != AGE && !fixed.contains_key(*name));
        let free = free.map(|(k, _)| k).collect();
        let targets = requested.iter().map(|(&m, &value)| (m as usize, f64::from(value))).collect();
        Ok(Self { body, targets, free, at })
    }

    fn shape(&self) -> BodyShape {
        BodyShape::from_parameters(&self.at)
    }

    /// Levenberg-Marquardt; the number of steps.
    fn minimise(&mut self) -> usize {
        let (mut best, mut damping) = (self.evaluate(&self.at), FIRST_DAMPING);
        for iteration in 0..ITERATIONS {
            let equations = self.normal_equations(&best);
            let before = best.cost;
            if self.promise(&equations) <= ENOUGH * before {
                return iteration;
            }
            while best.cost == before && damping < MOST_DAMPING {
                let trial = self.projected_step(&equations, damping);
                let evaluated = self.evaluate(&trial);
                if evaluated.cost < before {
                    (self.at, best, damping) = (trial, evaluated, (damping / 5.0).max(LEAST_DAMPING));
                } else {
                    damping *= 4.0;
                }
            }
            if before - best.cost <= ENOUGH * before {
                return iteration + 1;
            }
        }
        ITERATIONS
    }

    /// How much the cost could still fall.
    ///
    /// By the undamped step or, since clamping to the bounds may turn that away from the descent, by
    /// steps of each parameter alone, which clamping only shortens.
    fn promise(&self, equations: &Equations) -> f64 {
        let mut alone = self.at;
        for &k in &self.free {
            alone[k] = (alone[k] - equations.gradient[k] / equations.matrix[k][k]).clamp(low(k), 1.0);
        }
        let together = self.projected_step(equations, LEAST_DAMPING);
        equations.decrease(&self.at, &together).max(equations.decrease(&self.at, &alone))
    }

    fn evaluate(&self, at: &Parameters) -> Evaluation {
        let coefficients: Vec<f32> = self.body.terms().evaluate(at).iter().map(|&c| c as f32).collect();
        let points = self.body.tape().points(&coefficients, self.weighed());
        let miss = |&(m, target): &(usize, f64)| (self.body.tape().value(m, &points) - target).powi(2);
        let pulled = self.free.iter().map(|&k| pull(k) * (at[k] - middle(k)).powi(2));
        let cost = self.targets.iter().map(miss).sum::<f64>() + pulled.sum::<f64>();
        Evaluation { points, cost }
    }

    /// Whether mass counts: only then is the coarse mesh needed.
    fn weighed(&self) -> bool {
        self.targets.iter().any(|(m, _)| *m == Measurement::Weight as usize)
    }

    /// The Gauss-Newton equations at the best parameters.
    fn normal_equations(&self, best: &Evaluation) -> Equations {
        let points = &best.points;
        let coefficient_jacobian = self.body.terms().jacobian(&self.at);
        let mut out = Equations { matrix: [[0.0; PARAMETERS]; PARAMETERS], gradient: [0.0; PARAMETERS] };
        for &(m, target) in &self.targets {
            let miss = self.body.tape().value(m, points) - target;
            let row = coefficient_jacobian.pull_back(&self.body.tape().gradient(m, points));
            out.add(&row, miss);
        }
        for &k in &self.free {
            out.matrix[k][k] += pull(k);
            out.gradient[k] += pull(k) * (self.at[k] - middle(k));
        }
        out
    }

    /// The damped step over the parameters that no bound holds, clamped to the bounds.
    fn projected_step(&self, equations: &Equations, damping: f64) -> Parameters {
        let gradient = &equations.gradient;
        let held = |k: usize| {
            (self.at[k] <= low(k) && gradient[k] > 0.0) || (self.at[k] >= 1.0 && gradient[k] < 0.0)
        };
        let open: Vec<usize> = self.free.iter().copied().filter(|&k| !held(k)).collect();
        let damped = |i: usize, j: usize| equations.matrix[i][j] * if i == j { 1.0 + damping } else { 1.0 };
        let matrix = open.iter().map(|&i| open.iter().map(|&j| damped(i, j)).collect()).collect();
        let step = cholesky::solve(matrix, open.iter().map(|&k| gradient[k]).collect());
        let mut out = self.at;
        for (&k, step) in open.iter().zip(step.unwrap_or_default()) {
            out[k] = (out[k] - step).clamp(low(k), 1.0);
        }
        out
    }
}

/// The cost of some parameters, and the tapes' points that it took.
struct Evaluation {
    points: TapePoints,
    cost: f64,
}

/// Gauss-Newton matrix, and half the gradient of the cost.
struct Equations {
    matrix: [[f64; PARAMETERS]; PARAMETERS],
    gradient: [f64; PARAMETERS],
}

impl Equations {
    /// How much the cost should fall from one place to another near it.
    fn decrease(&self, from: &Parameters, to: &Parameters) -> f64 {
        self.gradient.iter().zip(from.iter().zip(to)).map(|(g, (from, to))| g * (from - to)).sum()
    }

    /// Adds a measurement that misses, with its derivative by the parameters.
    fn add(&mut self, derivative: &Parameters, miss: f64) {
        for ((row, gradient), d) in self.matrix.iter_mut().zip(&mut self.gradient).zip(derivative) {
            row.iter_mut().zip(derivative).for_each(|(entry, other)| *entry += d * other);
            *gradient += d * miss;
        }
    }
}

fn low(k: usize) -> f64 {
    if k < PHENOTYPES { 0.0 } else { -1.0 }
}

fn middle(k: usize) -> f64 {
    if k < PHENOTYPES { 0.5 } else { 0.0 }
}

fn pull(k: usize) -> f64 {
    if k < PHENOTYPES { PHENOTYPE_PULL } else { LOCAL_PULL }
}

/// Every measurement has its index below this.
const _: () = assert!(Measurement::Thigh as usize + 1 == MEASUREMENTS);
