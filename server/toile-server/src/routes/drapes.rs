//! Draping.

use std::sync::Arc;
use std::time::Instant;

use axum::Json;
use axum::extract::{FromRequest, Path, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use toile_drape::network::Networks;
use toile_drape::pipeline::Quality;

use super::App;
use super::answer::{Etag, GLB, IMMUTABLE};
use crate::draping::{self, Draped};
use crate::errors::{ApiError, Code};
use crate::json::JsonBody;
use crate::measurements::{self, BodyView};
use crate::requests::DrapeBody;
use crate::server_timing::ServerTiming;

/// Carries the quality figures beside a binary answer.
pub const QUALITY_HEADER: HeaderName = HeaderName::from_static("x-toile-quality");

/// `POST /v1/drapes`
pub async fn drape(State(app): State<App>, request: Request) -> Result<Response, ApiError> {
    let started = Instant::now();
    let mut timing = ServerTiming::default();
    let wants_json = wants_json(request.headers());
    let JsonBody(request) = JsonBody::<DrapeBody>::from_request(request, &app).await?;
    request.check()?;
    timing.add_since("parse", started, None);

    let started = Instant::now();
    let (prepared, source) =
        app.service.wardrobe.get(&request.outfit).await.map_err(|error| match error.code {
            Code::UnknownOutfit => error.at("/outfit"),
            _ => error,
        })?;
    timing.add_since("static", started, Some(source.name()));

    let queued = Instant::now();
    let (assets, method) = (Arc::clone(&app.service.assets), request.method()?.to_string());
    let work = move |networks: &mut dyn Networks| {
        timing.add_since("queue", queued, None);
        let draped = draping::drape(&assets, &prepared, &request, networks)?;
        draped.timing.stages().for_each(|(stage, milliseconds)| timing.add(stage, milliseconds));
        let body = wants_json.then(|| measurements::view(&assets, &draped.motion.shape));
        Ok::<_, ApiError>((draped, timing, body))
    };
    let (draped, timing, body) = app.service.workers.run(work).await??;
    match body {
        Some(body) => json_answer(&app, draped, timing, body, method).await,
        None => binary_answer(draped, timing),
    }
}

fn binary_answer(draped: Draped, timing: ServerTiming) -> Result<Response, ApiError> {
    let quality = serde_json::to_string(&draped.quality).map_err(ApiError::internal)?;
    let quality = HeaderValue::from_str(&quality).map_err(ApiError::internal)?;
    let headers = [(header::CONTENT_TYPE, GLB), (QUALITY_HEADER, quality)];
    Ok((timing, headers, draped.glb).into_response())
}

/// The answer for those who want JSON.
#[derive(Serialize)]
struct DrapeView {
    url: String,
    bytes: usize,
    method: String,
    body: BodyView,
    quality: Quality,
    timing: ServerTiming,
}

async fn json_answer(
    app: &App,
    draped: Draped,
    timing: ServerTiming,
    body: BodyView,
    method: String,
) -> Result<Response, ApiError> {
    let bytes = draped.glb.len();
    let id = app.service.answers.keep(draped.glb).await;
    let url = format!("/v1/drapes/{id}/drape.glb");
    let view = DrapeView { url, bytes, method, body, quality: draped.quality, timing: timing.clone() };
    Ok((timing, Json(view)).into_response())
}

/// `GET /v1/drapes/{id}/drape.glb`
pub async fn kept(
    State(app): State<App>,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let expired =
        || ApiError::new(Code::DrapeExpired, "The drape is no longer kept; post the request again.");
    let glb = app.service.answers.get(&id).await.ok_or_else(expired)?;
    let etag = Etag::new(&id).ok_or_else(|| ApiError::internal("entity tag"))?;
    if etag.is_known(&headers) {
        return Ok(etag.not_modified(IMMUTABLE));
    }
    Ok(etag.answer(GLB, IMMUTABLE, glb))
}

/// Whichever of the two media types `Accept` names first; a GLB when it names neither.
fn wants_json(headers: &HeaderMap) -> bool {
    let lists = headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok());
    let mut types =
        lists.flat_map(|list| list.split(',')).map(|entry| entry.split(';').next().unwrap_or("").trim());
    types.find(|name| ["application/json", "model/gltf-binary"].contains(name)) == Some("application/json")
}
