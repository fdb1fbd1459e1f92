//! The body: its parameters, the reference body, solving for measurements.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use toile_geometry::body::BodyShape;
use toile_geometry::measurements::Solution;
use toile_gltf::write_body;

use super::App;
use super::answer::{Etag, GLB, REVALIDATE};
use crate::assets::Assets;
use crate::errors::ApiError;
use crate::json::JsonBody;
use crate::measurements::{ParameterView, solve as solve_measurements};
use crate::requests::BodyRequest;

/// Name, label, what 0 is and what 1 is.
const PHENOTYPES: [(&str, &str, &str, &str); 6] = [
    ("gender", "Gender", "male", "female"),
    ("age", "Age", "baby", "old"),
    ("muscle", "Muscle", "slack", "muscular"),
    ("weight", "Weight", "slim", "heavy"),
    ("height", "Height", "short", "tall"),
    ("proportions", "Proportions", "ideal", "uncommon"),
];

/// `GET /v1/body`
pub async fn parameters(State(app): State<App>) -> Json<Value> {
    let (body, reference) = (app.service.assets.body(), BodyShape::default());
    let phenotypes = body.phenotype_names().iter().zip(reference.phenotypes).map(|(name, default)| {
        let known = PHENOTYPES.into_iter().find(|known| known.0 == name);
        let (_, label, low, high) = known.unwrap_or((name, name, "", ""));
        json!({"name": name, "label": label, "min": 0.0, "max": 1.0, "default": default, "low": low, "high": high})
    });
    let local_changes = body.local_change_names().iter();
    let local_changes =
        local_changes.map(|name| json!({"name": name, "min": -1.0, "max": 1.0, "default": 0.0}));
    let joints = body.humanoid_joints().map(|(name, parent)| json!({"name": name, "parent": parent}));
    Json(json!({
        "phenotypes": phenotypes.collect::<Vec<_>>(),
        "local_changes": local_changes.collect::<Vec<_>>(),
        "measurements": body.measurements(),
        "joints": joints.collect::<Vec<_>>(),
        "vertices": body.vertex_count(),
        "triangles": body.triangles().len(),
    }))
}

/// `GET /v1/body/reference.glb`
pub async fn reference(State(app): State<App>, headers: HeaderMap) -> Result<Response, ApiError> {
    let assets = Arc::clone(&app.service.assets);
    let etag = Etag::new(&assets.body_hash).ok_or_else(|| ApiError::internal("entity tag"))?;
    if etag.is_known(&headers) {
        return Ok(etag.not_modified(REVALIDATE));
    }
    let write = move |_: &mut dyn toile_drape::network::Networks| {
        write_body(&assets.reference.apose_vertices, assets.body().triangles())
    };
    let glb = app.service.workers.run(write).await?.map_err(ApiError::internal)?;
    Ok(etag.answer(GLB, REVALIDATE, glb.into()))
}

/// A request for a body.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolveRequest {
    /// By name, cm or kg.
    measurements: BTreeMap<String, f32>,
    /// Fixes this phenotype; solved for by default.
    gender: Option<f32>,
}

/// One measurement of a solved body, cm or kg.
#[derive(Debug, Serialize)]
struct SolvedMeasurement {
    requested: Option<f32>,
    achieved: f32,
    residual: Option<f32>,
}

/// A solved body.
#[derive(Debug, Serialize)]
pub struct SolvedBody {
    #[serde(flatten)]
    parameters: ParameterView,
    measurements: BTreeMap<&'static str, SolvedMeasurement>,
    shape: BodyRequest,
}

/// `POST /v1/bodies`
pub async fn solve(
    State(app): State<App>,
    JsonBody(request): JsonBody<SolveRequest>,
) -> Result<Json<SolvedBody>, ApiError> {
    let assets = Arc::clone(&app.service.assets);
    let work = move |_: &mut dyn toile_drape::network::Networks| {
        let fixed: BTreeMap<_, _> =
            request.gender.map(|gender| ("gender".to_owned(), gender)).into_iter().collect();
        let under = |error: ApiError| match error.pointer.as_deref() {
            Some("/gender") => error,
            _ => error.under("/measurements"),
        };
        let solution = solve_measurements(&assets, &request.measurements, &fixed).map_err(under)?;
        Ok::<_, ApiError>(solved_body(&assets, &solution))
    };
    Ok(Json(app.service.workers.run(work).await??))
}

fn solved_body(assets: &Assets, solution: &Solution) -> SolvedBody {
    let measurements = solution.achieved.iter().map(|(measurement, achieved)| {
        let residual = solution.residuals.get(&measurement).copied();
        let requested = residual.map(|residual| achieved - residual);
        (measurement.name(), SolvedMeasurement { requested, achieved, residual })
    });
    SolvedBody {
        parameters: ParameterView::new(assets, &solution.shape),
        measurements: measurements.collect(),
        shape: BodyRequest::of_shape(&solution.shape, assets),
    }
}
