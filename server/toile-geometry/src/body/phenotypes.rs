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
pub(super) const AGE: usize = 1;
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
    /// (term, coefficient, factor), only what is not zero.
    pub(super) projection: Vec<(usize, usize, f64)>,
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
        self.evaluate(&parameters(shape)).iter().map(|&c| c as f32).collect()
    }

    /// Coefficients of parameters (phenotypes, then local changes) in double precision.
    #[must_use]
    pub fn evaluate(&self, parameters: &[f64; PARAMETERS]) -> Vec<f64> {
        let levels: [Levels; PHENOTYPES] = std::array::from_fn(|p| levels(p, parameters[p]).0);
        let products: Vec<f64> =
            self.terms.iter().map(|term| term.iter().map(|&(p, k)| levels[p][k]).product()).collect();
        let mut out = vec![0.0; self.coefficient_count()];
        for &(term, coefficient, factor) in &self.projection {
            out[coefficient] += products[term] * factor;
        }
        for (k, &change) in parameters[PHENOTYPES..].iter().enumerate() {
            out[self.phenotype_coefficients + 2 * k] = change.max(0.0);
            out[self.phenotype_coefficients + 2 * k + 1] = (-change).max(0.0);
        }
        out
    }

    /// Derivative of every coefficient by every parameter, (coefficients, parameters).
    ///
    /// Coefficients have kinks at anchors; there the derivative is that of the side above.
    #[must_use]
    pub fn jacobian(&self, parameters: &[f64; PARAMETERS]) -> Vec<[f64; PARAMETERS]> {
        let scales: [(Levels, Levels); PHENOTYPES] = std::array::from_fn(|p| levels(p, parameters[p]));
        let mut out = vec![[0.0; PARAMETERS]; self.coefficient_count()];
        for &(term, coefficient, factor) in &self.projection {
            for &(by, at) in &self.terms[term] {
                let others: f64 =
                    self.terms[term].iter().filter(|(p, _)| *p != by).map(|&(p, k)| scales[p].0[k]).product();
                out[coefficient][by] += scales[by].1[at] * others * factor;
            }
        }
        for (k, &change) in parameters[PHENOTYPES..].iter().enumerate() {
            let (positive, negative) = if change >= 0.0 { (1.0, 0.0) } else { (0.0, -1.0) };
            out[self.phenotype_coefficients + 2 * k][PHENOTYPES + k] = positive;
            out[self.phenotype_coefficients + 2 * k + 1][PHENOTYPES + k] = negative;
        }
        out
    }
}

/// Phenotypes, then local changes.
pub(crate) fn parameters(shape: &BodyShape) -> [f64; PARAMETERS] {
    let mut out = [0.0; PARAMETERS];
    let values = shape.phenotypes.iter().chain(&shape.local_changes);
    out.iter_mut().zip(values).for_each(|(o, &v)| *o = f64::from(v));
    out
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
    (slope[below], slope[below + 1]) = (-1.0 / spacing, 1.0 / spacing);
    (level, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> PhenotypeTerms {
        PhenotypeTerms {
            terms: vec![vec![(0, 1), (3, 2)], vec![(1, 3)], vec![(0, 0), (1, 4), (4, 1)]],
            projection: vec![(0, 0, 2.0), (1, 0, -1.0), (2, 1, 0.5)],
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
    fn the_jacobian_agrees_with_finite_differences() {
        let terms = sample();
        let at: [f64; PARAMETERS] =
            std::array::from_fn(|k| if k < 6 { 0.13 + 0.14 * k as f64 } else { 0.31 - 0.03 * k as f64 });
        let jacobian = terms.jacobian(&at);
        for k in 0..PARAMETERS {
            let (mut above, mut below) = (at, at);
            above[k] += 1e-6;
            below[k] -= 1e-6;
            let (above, below) = (terms.evaluate(&above), terms.evaluate(&below));
            for (c, row) in jacobian.iter().enumerate() {
                let expected = (above[c] - below[c]) / 2e-6;
                assert!(
                    (row[k] - expected).abs() < 1e-6,
                    "coefficient {c} by {k}: {} not {expected}",
                    row[k]
                );
            }
        }
    }
}
