//! Bodies from scans: a mesh of a person becomes the body that is nearest to it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use toile_geometry::body::{BodyShape, Detail};
use toile_geometry::mesh::Mesh;
use toile_geometry::scan::fit;
use toile_gltf::{Format, preflight, read};

use crate::assets::Assets;
use crate::errors::ApiError;
use crate::hash::short_hash;
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

/// The body nearest to the meshes of a file, kept for drapes to come. Takes a second: not for a tokio thread.
///
/// # Errors
/// When the file cannot be read or is no scan of a person.
pub fn body(
    assets: &Assets,
    file: &[u8],
    file_name: Option<&str>,
    metadata: &ScanMetadata,
) -> Result<(BodyShape, ScanView), ApiError> {
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
    let found = fit(assets.body(), &scan)?;
    let stated = [&metadata.units, &metadata.up].map(|text| text.as_deref().unwrap_or("").as_bytes());
    let id = short_hash([file, stated[0], stated[1]]);
    let detail = Some(Arc::new(Detail { id: id.clone(), offsets: found.offsets }));
    let shape = BodyShape { detail, ..found.shape };
    let view = ScanView { distance_mm: 1e3 * found.distance, unseen_percent: found.unseen_percent };
    assets.scans.keep(id, shape.clone());
    Ok((shape, view))
}
