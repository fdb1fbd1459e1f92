//! Phenotypes and local changes -> shape coefficients.
//!
//! Every phenotype is interpolated linearly between anchors (`minweight`, `averageweight`, …). A term is
//! a product of anchor levels, at most one for each phenotype; coefficients are sums of terms. A local
//! change has one coefficient for its positive and one for its negative part.

use super::BodyShape;

/// Number of phenotypes.
pub const PHENOTYPES: usize = 6;
/// Number of local changes.
pub const LOCAL_CHANGES: usize = 20;
/// Number of parameters of a shape.
pub const PARAMETERS: usize = PHENOTYPES + LOCAL_CHANGES;
/// Index of age among the phenotypes.
pub(crate) const AGE: usize = 1;
/// Index of muscle.
pub(crate) const MUSCLE: usize = 2;
const MOST_ANCHORS: usize = 5;

/// Phenotypes in order: name, value at the first anchor (the last is at 1), anchors.
const SCALES: [(&str, f64, &[&str]); PHENOTYPES] = [
    ("gender", 0.0, &["male", "female"]),
    ("age", -1.0 / 3.0, &["newborn", "baby", "child", "young", "old"]),
    ("muscle", 0.0, &["minmuscle", "averagemuscle", "maxmuscle"]),
    ("weight", 0.0, &["minweight", "averageweight", "maxweight"]),
    ("height", 0.0, &["minheight", "maxheight"]),
    ("proportions", 0.0, &["idealproportions", "uncommonproportions"]),
];

/// The names of the phenotypes, in order.
pub(super) fn names() -> [&'static str; PHENOTYPES] {
    SCALES.map(|(name, ..)| name)
}

/// The phenotype and the anchor's place on its scale, of an anchor's name.
pub(super) fn anchor(name: &str) -> Option<(usize, usize)> {
    SCALES
        .iter()
        .enumerate()
        .find_map(|(p, (_, _, anchors))| anchors.iter().position(|a| *a == name).map(|k| (p, k)))
}

/// How shape coefficients follow from a shape.
#[derive(Debug, Default)]
pub struct PhenotypeTerms {
    /// Anchors (phenotype, place on its scale) that each term multiplies.
    pub(super) terms: Vec<Vec<(usize, usize)>>,
    /// What each term adds to the coefficients that phenotypes drive, (terms, coefficients), row-major.
    pub(super) projection: Vec<f32>,
    /// Number of coefficients that phenotypes drive; those of the local changes follow.
    pub(super) phenotype_coefficients: usize,
}

/// Level of each anchor of a phenotype.
type Levels = [f64; MOST_ANCHORS];

impl PhenotypeTerms {
    /// Number of coefficients.
    #[must_use]
    pub fn coefficient_count(&self) -> usize {
        self.phenotype_coefficients + 2 * LOCAL_CHANGES
    }

    /// Coefficients of a shape, (coefficients,).
    #[must_use]
    pub fn coefficients(&self, shape: &BodyShape) -> Vec<f32> {
        self.evaluate(&shape.parameters()).iter().map(|&c| c as f32).collect()
    }

    /// Coefficients of parameters (phenotypes, then local changes) in double precision.
    #[must_use]
    pub fn evaluate(&self, parameters: &[f64; PARAMETERS]) -> Vec<f64> {
        let levels: [Levels; PHENOTYPES] = std::array::from_fn(|p| levels(p, parameters[p]).0);
        let product = |term: &Vec<(usize, usize)>| term.iter().map(|&(p, k)| levels[p][k]).product();
        let mut out = self.project(self.terms.iter().map(product));
        for &change in &parameters[PHENOTYPES..] {
            out.extend([change.max(0.0), (-change).max(0.0)]);
        }
        out
    }

    /// Derivative of the coefficients by the parameters.
    ///
    /// Coefficients have kinks at anchors; there the derivative is the mean of both sides.
    #[must_use]
    pub fn jacobian(&self, parameters: &[f64; PARAMETERS]) -> CoefficientJacobian {
        let scales: [(Levels, Levels); PHENOTYPES] = std::array::from_fn(|p| levels(p, parameters[p]));
        let phenotypes = std::array::from_fn(|by| {
            self.project(self.terms.iter().map(|term| {
                let mut parts =
                    term.iter().map(|&(p, k)| if p == by { scales[p].1[k] } else { scales[p].0[k] });
                if term.iter().any(|(p, _)| *p == by) { parts.by_ref().product() } else { 0.0 }
            }))
        });
        let positive = std::array::from_fn(|k| match parameters[PHENOTYPES + k] {
            0.0 => 0.5,
            change => f64::from(u8::from(change > 0.0)),
        });
        CoefficientJacobian { phenotypes, positive }
    }

    /// Terms × projection, (coefficients that phenotypes drive,).
    fn project(&self, terms: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut out = vec![0.0; self.phenotype_coefficients];
        let rows = self.projection.chunks_exact(self.phenotype_coefficients.max(1));
        for (term, row) in terms.zip(rows).filter(|(term, _)| *term != 0.0) {
            out.iter_mut().zip(row).for_each(|(o, &factor)| *o += term * f64::from(factor));
        }
        out
    }
}

/// Derivative of the coefficients by the parameters, without its zeros.
#[derive(Debug)]
pub struct CoefficientJacobian {
    /// Of the coefficients that phenotypes drive, by each phenotype.
    phenotypes: [Vec<f64>; PHENOTYPES],
    /// Of a local change's positive part; its negative part has this less 1.
    positive: [f64; LOCAL_CHANGES],
}

impl CoefficientJacobian {
    /// Derivative by the parameters of what has a `gradient` by the coefficients.
    #[must_use]
    pub fn pull_back(&self, gradient: &[f64]) -> [f64; PARAMETERS] {
        let mut out = [0.0; PARAMETERS];
        for (slot, row) in out.iter_mut().zip(&self.phenotypes) {
            *slot = row.iter().zip(gradient).map(|(d, g)| d * g).sum();
        }
        let local = gradient.get(self.phenotypes[0].len()..).unwrap_or(&[]).as_chunks::<2>().0;
        for ((slot, positive), [up, down]) in out[PHENOTYPES..].iter_mut().zip(self.positive).zip(local) {
            *slot = up * positive + down * (positive - 1.0);
        }
        out
    }
}

/// Level of every anchor of phenotype `p` at `value`, and its derivative.
fn levels(p: usize, value: f64) -> (Levels, Levels) {
    let (_, first, anchors) = SCALES[p];
    let spacing = (1.0 - first) / (anchors.len() - 1) as f64;
    let at = ((value - first) / spacing).clamp(0.0, (anchors.len() - 1) as f64);
    // Phenotypes come as f32, in which an anchor such as 2/3 is not exact.
    let at = if (at - at.round()).abs() < 1e-6 { at.round() } else { at };
    let below = (at.floor() as usize).min(anchors.len() - 2);
    let share = at - below as f64;
    let (mut level, mut slope) = ([0.0; MOST_ANCHORS], [0.0; MOST_ANCHORS]);
    (level[below], level[below + 1]) = (1.0 - share, share);
    if share == 0.0 && below > 0 {
        (slope[below - 1], slope[below + 1]) = (-0.5 / spacing, 0.5 / spacing);
    } else {
        (slope[below], slope[below + 1]) = (-1.0 / spacing, 1.0 / spacing);
    }
    (level, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> PhenotypeTerms {
        PhenotypeTerms {
            terms: vec![vec![(0, 1), (3, 2)], vec![(1, 3)], vec![(0, 0), (1, 4), (4, 1)]],
            projection: vec![2.0, 0.0, -1.0, 0.0, 0.0, 0.5],
            phenotype_coefficients: 2,
        }
    }

    #[test]
    fn the_reference_is_half_way_and_of_age_young() {
        let shape = BodyShape {
            local_changes: std::array::from_fn(|k| if k == 1 { -0.25 } else { 0.0 }),
            ..Default::default()
        };
        let c = sample().coefficients(&shape);
        assert_eq!(c.len(), 42);
        assert_eq!(&c[..6], &[-1.0, 0.0, 0.0, 0.0, 0.0, 0.25]);
    }

    #[test]
    fn at_a_kink_the_slope_is_the_mean_of_both_sides() {
        let at: [f64; PARAMETERS] = BodyShape::default().parameters();
        let by = |coefficient: usize| {
            let mut gradient = vec![0.0; 42];
            gradient[coefficient] = 1.0;
            sample().jacobian(&at).pull_back(&gradient)
        };
        assert_eq!(by(0)[AGE], 0.0);
        // Factor × male × maxheight × half of the slope to `old`.
        assert!((by(1)[AGE] - 0.5 * 0.5 * 0.5 * 1.5).abs() < 1e-12);
        assert_eq!((by(2)[PHENOTYPES], by(3)[PHENOTYPES]), (0.5, -0.5));
    }

    #[test]
    fn the_jacobian_agrees_with_finite_differences() {
        let terms = sample();
        let at: [f64; PARAMETERS] =
            std::array::from_fn(|k| if k < 6 { 0.13 + 0.14 * k as f64 } else { 0.31 - 0.03 * k as f64 });
        let gradient: Vec<f64> = (0..42).map(|c| 1.0 + 0.1 * c as f64).collect();
        let found = terms.jacobian(&at).pull_back(&gradient);
        let value = |at| terms.evaluate(&at).iter().zip(&gradient).map(|(c, g)| c * g).sum::<f64>();
        for (k, found) in found.into_iter().enumerate() {
            let (mut above, mut below) = (at, at);
            above[k] += 1e-6;
            below[k] -= 1e-6;
            let expected = (value(above) - value(below)) / 2e-6;
            assert!((found - expected).abs() < 1e-6, "by {k}: {found}, not {expected}");
        }
    }
}
