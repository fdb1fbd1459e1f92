//! Whose body.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use toile_geometry::body::BodyShape;

use crate::assets::Assets;
use crate::errors::ApiError;

/// How a body is described.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BodyKind {
    /// By phenotypes and local changes.
    Phenotypes,
    /// By a tailor's measurements.
    Measurements,
}

/// A body.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BodyRequest {
    kind: BodyKind,
    #[serde(default)]
    values: BTreeMap<String, f32>,
}

impl BodyRequest {
    /// Phenotypes and local changes that another request may use.
    pub fn of_shape(shape: &BodyShape, assets: &Assets) -> Self {
        Self { kind: BodyKind::Phenotypes, values: shape.values(assets.body()) }
    }

    /// The shape. Solving measurements takes milliseconds: not for a tokio thread.
    ///
    /// # Errors
    /// When a name is not known, a value is out of range or no body has the measurements.
    pub fn shape(&self, assets: &Assets) -> Result<BodyShape, ApiError> {
        let shape = match self.kind {
            BodyKind::Phenotypes => {
                BodyShape::from_values(assets.body(), &self.values).map_err(ApiError::from)
            }
            BodyKind::Measurements => crate::measurements::solve(assets, &self.values, &BTreeMap::new())
                .map(|solution| solution.shape),
        };
        shape.map_err(|error| error.under("/values"))
    }
}
