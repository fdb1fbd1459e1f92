//! The body: its parameters, the reference body, solving for measurements.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::Json;
use axum::extract::{DefaultBodyLimit, FromRequest, Request, State};
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use toile_geometry::body::BodyShape;
use toile_geometry::measurements::{MeasurementInfo, Solution, measure};
use toile_gltf::write_body;

use super::App;
use super::answer::{Etag, GLB, REVALIDATE};
use super::multipart::UploadForm;
use crate::assets::Assets;
use crate::errors::ApiError;
use crate::json::JsonBody;
use crate::measurements::{ParameterView, solve as solve_measurements};
use crate::requests::BodyRequest;
use crate::scan::{self, ScanMetadata, ScanView};

/// Name, label, what 0 is and what 1 is.
const PHENOTYPES: [(&str, &str, &str, &str); 6] = [
    ("gender", "Gender", "male", "female"),
    ("age", "Age", "baby", "old"),
    ("muscle", "Muscle", "slack", "muscular"),
    ("weight", "Weight", "slim", "heavy"),
    ("height", "Height", "short", "tall"),
    ("proportions", "Proportions", "ideal", "uncommon"),
];

/// A parameter of the body and its range.
#[derive(Serialize)]
struct Parameter<'a> {
    name: &'a str,
    min: f32,
    max: f32,
    default: f32,
    #[serde(flatten)]
    words: Option<Words<'a>>,
}

/// A parameter for people.
#[derive(Serialize)]
struct Words<'a> {
    label: &'a str,
    low: &'a str,
    high: &'a str,
}

#[derive(Serialize)]
struct Joint<'a> {
    name: &'a str,
    parent: Option<&'a str>,
}

#[derive(Serialize)]
struct ParameterList<'a> {
    phenotypes: Vec<Parameter<'a>>,
    local_changes: Vec<Parameter<'a>>,
    measurements: &'a [MeasurementInfo],
    joints: Vec<Joint<'a>>,
    vertices: usize,
    triangles: usize,
}

/// `GET /v1/body`
pub async fn parameters(State(app): State<App>) -> Response {
    let (body, reference) = (app.service.assets.body(), BodyShape::default());
    let phenotypes = body.phenotype_names().iter().zip(reference.phenotypes).map(|(name, default)| {
        let known = PHENOTYPES.iter().find(|known| known.0 == name);
        let words = known.map(|&(_, label, low, high)| Words { label, low, high });
        Parameter { name, min: 0.0, max: 1.0, default, words }
    });
    let local_changes = body.local_change_names().iter();
    let local_changes =
        local_changes.map(|name| Parameter { name, min: -1.0, max: 1.0, default: 0.0, words: None });
    Json(ParameterList {
        phenotypes: phenotypes.collect(),
        local_changes: local_changes.collect(),
        measurements: body.measurements(),
        joints: body.humanoid_joints().map(|(name, parent)| Joint { name, parent }).collect(),
        vertices: body.vertex_count(),
        triangles: body.triangles().len(),
    })
    .into_response()
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
    #[serde(skip_serializing_if = "Option::is_none")]
    scan: Option<ScanView>,
}

/// `POST /v1/bodies`: measurements as JSON, or a scan as a form.
pub async fn solve(State(app): State<App>, mut request: Request) -> Result<Json<SolvedBody>, ApiError> {
    let kind = request.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
    if kind.is_some_and(|kind| kind.starts_with("multipart/form-data")) {
        return of_scan(app, request).await;
    }
    DefaultBodyLimit::max(super::MAX_JSON_BYTES).apply(&mut request);
    let JsonBody(request) = JsonBody::<SolveRequest>::from_request(request, &app).await?;
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

async fn of_scan(app: App, request: Request) -> Result<Json<SolvedBody>, ApiError> {
    let _turn = app.upload_turn()?;
    let UploadForm { file, file_name, metadata } =
        UploadForm::<ScanMetadata>::from_request(request, &app).await?;
    let assets = Arc::clone(&app.service.assets);
    let work = move |_: &mut dyn toile_drape::network::Networks| {
        let (shape, view) = scan::body(&assets, &file, file_name.as_deref(), &metadata)?;
        let achieved = measure(assets.body(), &assets.body().shape(&shape));
        let solution = Solution { shape, achieved, residuals: BTreeMap::new(), iterations: 0 };
        Ok::<_, ApiError>(SolvedBody { scan: Some(view), ..solved_body(&assets, &solution) })
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
        scan: None,
    }
}
