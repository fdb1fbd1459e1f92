//! Bodies from scans: a mesh of a person becomes the body that is nearest to it.

use serde::{Deserialize, Serialize};
use toile_geometry::mesh::Mesh;
use toile_geometry::scan::{ScanFit, fit};
use toile_gltf::{Format, preflight, read};

use crate::assets::Assets;
use crate::errors::ApiError;
use crate::upload::hints;

/// What is stated about a scan's file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScanMetadata {
    /// `m`, `cm`, `mm` or `in`; detected by default.
    units: Option<String>,
    /// `y` or `z`; detected by default.
    up: Option<String>,
}

/// How near the body is to the scan.
#[derive(Debug, Serialize)]
pub struct ScanView {
    /// Mean distance where the scan has a counterpart, millimetres.
    distance_mm: f32,
    /// Share of the body without one, percent.
    unseen_percent: f32,
}

impl ScanView {
    /// Of a fit.
    pub fn new(fit: &ScanFit) -> Self {
        Self { distance_mm: 1e3 * fit.distance, unseen_percent: fit.unseen_percent }
    }
}

/// The body nearest to the meshes of a file. Takes a second: not for a tokio thread.
///
/// # Errors
/// When the file cannot be read or is no scan of a person.
pub fn body(
    assets: &Assets,
    file: &[u8],
    file_name: Option<&str>,
    metadata: &ScanMetadata,
) -> Result<ScanFit, ApiError> {
    let hints = hints(metadata.units.as_deref(), metadata.up.as_deref())?;
    let format = Format::sniff(file, file_name)?;
    preflight(file, format)?;
    let mut scan = Mesh::default();
    for mesh in read(file, format, &hints, None)?.meshes {
        let first = scan.positions.len() as u32;
        let triangles = mesh.parts.iter().flat_map(|part| &part.triangles);
        scan.triangles.extend(triangles.map(|triangle| triangle.map(|i| first + i)));
        scan.positions.extend(mesh.positions);
    }
    Ok(fit(assets.body(), &scan)?)
}
