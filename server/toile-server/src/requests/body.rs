//! Whose body.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use toile_geometry::body::BodyShape;

use crate::assets::Assets;
use crate::errors::{ApiError, Code};

use super::unused;

/// How a body is described.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BodyKind {
    /// By phenotypes and local changes.
    Phenotypes,
    /// By a tailor's measurements.
    Measurements,
    /// By a scan that was sent before.
    Scan,
}

/// A body.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BodyRequest {
    kind: BodyKind,
    #[serde(default)]
    values: BTreeMap<String, f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    id: Option<String>,
}

impl BodyRequest {
    /// Phenotypes and local changes that another request may use.
    pub fn of_shape(shape: &BodyShape, assets: &Assets) -> Self {
        match &shape.detail {
            Some(detail) => {
                Self { kind: BodyKind::Scan, values: BTreeMap::new(), id: Some(detail.id.clone()) }
            }
            None => Self { kind: BodyKind::Phenotypes, values: shape.values(assets.body()), id: None },
        }
    }

    /// Whether it is described by a scan, which is not kept for long.
    pub fn is_scan(&self) -> bool {
        self.kind == BodyKind::Scan
    }

    /// The shape. Solving measurements takes milliseconds: not for a tokio thread.
    ///
    /// # Errors
    /// When a name is not known, a value is out of range or no body has the measurements.
    pub fn shape(&self, assets: &Assets) -> Result<BodyShape, ApiError> {
        match (self.kind, &self.id) {
            (BodyKind::Scan, Some(id)) if self.values.is_empty() => return of_scan(id, assets),
            (BodyKind::Scan, None) => {
                return Err(ApiError::new(Code::MissingField, "The body of a scan needs its `id`."));
            }
            (BodyKind::Scan, _) => return Err(unused("values", "The body of a scan has no `values`.")),
            (_, Some(_)) => return Err(unused("id", "Only the body of a scan has an `id`.")),
            _ => {}
        }
        let shape = match self.kind {
            BodyKind::Phenotypes => {
                BodyShape::from_values(assets.body(), &self.values).map_err(ApiError::from)
            }
            BodyKind::Measurements | BodyKind::Scan => {
                crate::measurements::solve(assets, &self.values, &BTreeMap::new())
                    .map(|solution| solution.shape)
            }
        };
        shape.map_err(|error| error.under("/values"))
    }
}

fn of_scan(id: &String, assets: &Assets) -> Result<BodyShape, ApiError> {
    let unknown = || {
        let detail = "There is no body of this scan any more; send the scan to POST /v1/bodies again.";
        ApiError::new(Code::UnknownScan, detail).at("/id")
    };
    assets.scans.find(id).map(|shape| (*shape).clone()).ok_or_else(unknown)
}
