//! The parameters of a body.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;

use super::phenotypes::{AGE, LOCAL_CHANGES, PARAMETERS, PHENOTYPES};
use super::{Body, BodyError};

/// Age of the reference body as a phenotype: a young adult.
pub const REFERENCE_AGE: f32 = 2.0 / 3.0;

/// How the surface of one person differs from the parameters' (a scan's).
#[derive(Clone, Debug)]
pub struct Detail {
    /// Tells it from others.
    pub id: String,
    /// Offsets of the rest vertices, metres.
    pub offsets: Vec<Vec3>,
}

impl PartialEq for Detail {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

/// The parameters of a body. The default is the reference body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyShape {
    /// Phenotypes, each 0 to 1, in the order of [`Body::phenotype_names`].
    pub phenotypes: [f32; PHENOTYPES],
    /// Local changes, each -1 to 1, in the order of [`Body::local_change_names`].
    pub local_changes: [f32; LOCAL_CHANGES],
    /// What a scan knows beyond them.
    pub detail: Option<Arc<Detail>>,
}

impl Default for BodyShape {
    fn default() -> Self {
        let mut phenotypes = [0.5; PHENOTYPES];
        phenotypes[AGE] = REFERENCE_AGE;
        Self { phenotypes, local_changes: [0.0; LOCAL_CHANGES], detail: None }
    }
}

impl BodyShape {
    /// The reference body with some phenotypes and local changes set by name.
    ///
    /// # Errors
    /// [`BodyError::UnknownPhenotype`] and [`BodyError::PhenotypeOutOfRange`].
    pub fn from_values(body: &Body, values: &BTreeMap<String, f32>) -> Result<Self, BodyError> {
        let mut out = Self::default();
        for (name, &value) in values {
            let (slot, min) =
                out.slot(body, name).ok_or_else(|| BodyError::UnknownPhenotype { name: name.clone() })?;
            if !(min..=1.0).contains(&value) {
                return Err(BodyError::PhenotypeOutOfRange { name: name.clone(), value, min, max: 1.0 });
            }
            *slot = value;
        }
        Ok(out)
    }

    /// The parameter of that name, and its smallest value.
    fn slot(&mut self, body: &Body, name: &str) -> Option<(&mut f32, f32)> {
        let position = |names: &[String]| names.iter().position(|n| n == name);
        if let Some(k) = position(body.phenotype_names()) {
            return self.phenotypes.get_mut(k).map(|slot| (slot, 0.0));
        }
        let k = position(body.local_change_names())?;
        self.local_changes.get_mut(k).map(|slot| (slot, -1.0))
    }

    /// Every parameter by name.
    #[must_use]
    pub fn values(&self, body: &Body) -> BTreeMap<String, f32> {
        let names = body.phenotype_names().iter().chain(body.local_change_names());
        names.cloned().zip(self.phenotypes.into_iter().chain(self.local_changes)).collect()
    }

    /// Offsets of the rest vertices beyond the parameters, metres; empty where there are none.
    #[must_use]
    pub fn offsets(&self) -> &[Vec3] {
        self.detail.as_ref().map_or(&[], |detail| &detail.offsets)
    }

    /// Phenotypes, then local changes.
    pub(crate) fn parameters(&self) -> [f64; PARAMETERS] {
        let mut out = [0.0; PARAMETERS];
        let values = self.phenotypes.iter().chain(&self.local_changes);
        out.iter_mut().zip(values).for_each(|(o, &v)| *o = f64::from(v));
        out
    }

    /// The inverse of [`Self::parameters`].
    pub(crate) fn from_parameters(parameters: &[f64; PARAMETERS]) -> Self {
        let at = |k: usize| parameters[k] as f32;
        Self {
            phenotypes: std::array::from_fn(at),
            local_changes: std::array::from_fn(|k| at(PHENOTYPES + k)),
            detail: None,
        }
    }
}
