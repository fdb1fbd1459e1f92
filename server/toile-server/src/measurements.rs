//! Bodies from a tailor's measurements, and bodies as answers show them.

use std::collections::BTreeMap;

use serde::Serialize;
use toile_geometry::body::BodyShape;
use toile_geometry::measurements::{self, Solution};

use crate::assets::Assets;
use crate::errors::ApiError;

/// The body nearest to measurements in cm and kg. Takes milliseconds: not for a tokio thread.
///
/// # Errors
/// When a name is not known, a value cannot be, or no body has them together.
pub fn solve(
    assets: &Assets,
    requested: &BTreeMap<String, f32>,
    fixed: &BTreeMap<String, f32>,
) -> Result<Solution, ApiError> {
    Ok(measurements::solve(assets.body(), &measurements::by_measurement(requested)?, fixed)?)
}

/// Parameters of a body as answers show them.
#[derive(Debug, Serialize)]
pub struct ParameterView {
    phenotypes: BTreeMap<String, f32>,
    local_changes: BTreeMap<String, f32>,
}

impl ParameterView {
    /// Of `shape`.
    pub fn new(assets: &Assets, shape: &BodyShape) -> Self {
        let names = assets.body().phenotype_names();
        let (phenotypes, local_changes) =
            shape.values(assets.body()).into_iter().partition(|(name, _)| names.contains(name));
        Self { phenotypes, local_changes }
    }
}

/// A body as the answer to a drape shows it.
#[derive(Debug, Serialize)]
pub struct BodyView {
    #[serde(flatten)]
    parameters: ParameterView,
    measurements: BTreeMap<&'static str, f32>,
}

/// Parameters and measurements of `shape`.
pub fn view(assets: &Assets, shape: &BodyShape) -> BodyView {
    let measured = measurements::measure(assets.body(), &assets.body().shape(shape));
    BodyView {
        parameters: ParameterView::new(assets, shape),
        measurements: measured.iter().map(|(measurement, value)| (measurement.name(), value)).collect(),
    }
}
