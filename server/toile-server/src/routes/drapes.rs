//! Draping.

use std::sync::Arc;
use std::time::Instant;

use axum::Json;
use axum::extract::{FromRequest, Path, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use serde::Serialize;
use toile_drape::methods::ClothImages;
use toile_drape::network::Networks;
use toile_drape::pipeline::Quality;

use super::App;
use super::answer::{Etag, GLB, IMMUTABLE};
use crate::assets::Assets;
use crate::cloth_png;
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
        let extras = if wants_json { Some(Extras::of(&assets, &draped)?) } else { None };
        Ok::<_, ApiError>((draped, timing, extras))
    };
    let (draped, timing, extras) = app.service.workers.run(work).await??;
    match extras {
        Some(extras) => json_answer(&app, draped, timing, extras, method).await,
        None => binary_answer(draped, timing),
    }
}

fn binary_answer(draped: Draped, timing: ServerTiming) -> Result<Response, ApiError> {
    let quality = serde_json::to_string(&draped.quality).map_err(ApiError::internal)?;
    let quality = HeaderValue::from_str(&quality).map_err(ApiError::internal)?;
    let headers = [(header::CONTENT_TYPE, GLB), (QUALITY_HEADER, quality)];
    Ok((timing, headers, draped.glb).into_response())
}

/// What the JSON answer tells beside the drape.
struct Extras {
    body: BodyView,
    pictures: Vec<ClothPictures>,
}

/// A garment's cloth images as PNG.
struct ClothPictures {
    garment: String,
    exact: Bytes,
    preview: Bytes,
}

impl Extras {
    fn of(assets: &Assets, draped: &Draped) -> Result<Self, ApiError> {
        let picture = |cloth: &ClothImages| {
            let exact = cloth_png::exact(cloth).map_err(ApiError::internal)?.into();
            let preview = cloth_png::preview(cloth).map_err(ApiError::internal)?.into();
            Ok(ClothPictures { garment: cloth.garment.clone(), exact, preview })
        };
        let pictures = draped.images.iter().map(picture).collect::<Result<_, ApiError>>()?;
        Ok(Self { body: measurements::view(assets, &draped.motion.shape), pictures })
    }
}

/// Where the cloth images of a garment are.
#[derive(Serialize)]
struct ClothView {
    garment: String,
    url: String,
    preview: String,
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
    #[serde(skip_serializing_if = "Vec::is_empty")]
    cloth: Vec<ClothView>,
}

async fn json_answer(
    app: &App,
    draped: Draped,
    timing: ServerTiming,
    extras: Extras,
    method: String,
) -> Result<Response, ApiError> {
    let bytes = draped.glb.len();
    let id = app.service.answers.keep(draped.glb).await;
    let url = format!("/v1/drapes/{id}/drape.glb");
    let mut cloth = Vec::new();
    for ClothPictures { garment, exact, preview } in extras.pictures {
        let (exact, preview) =
            (app.service.answers.keep(exact).await, app.service.answers.keep(preview).await);
        let at = |id| format!("/v1/drapes/{id}/cloth.png");
        cloth.push(ClothView { garment, url: at(exact), preview: at(preview) });
    }
    let (body, quality) = (extras.body, draped.quality);
    let view = DrapeView { url, bytes, method, body, quality, timing: timing.clone(), cloth };
    Ok((timing, Json(view)).into_response())
}

/// `GET /v1/drapes/{id}/drape.glb`
pub async fn kept(app: State<App>, id: Path<String>, headers: HeaderMap) -> Result<Response, ApiError> {
    answer(app, id, &headers, GLB).await
}

/// `GET /v1/drapes/{id}/cloth.png`
pub async fn kept_picture(
    app: State<App>,
    id: Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    answer(app, id, &headers, HeaderValue::from_static("image/png")).await
}

async fn answer(
    State(app): State<App>,
    Path(id): Path<String>,
    headers: &HeaderMap,
    media_type: HeaderValue,
) -> Result<Response, ApiError> {
    let expired =
        || ApiError::new(Code::DrapeExpired, "The drape is no longer kept; post the request again.");
    let bytes = app.service.answers.get(&id).await.ok_or_else(expired)?;
    let etag = Etag::new(&id).ok_or_else(|| ApiError::internal("entity tag"))?;
    if etag.is_known(headers) {
        return Ok(etag.not_modified(IMMUTABLE));
    }
    Ok(etag.answer(media_type, IMMUTABLE, bytes))
}

/// Whichever of the two media types `Accept` names first; a GLB when it names neither.
fn wants_json(headers: &HeaderMap) -> bool {
    let lists = headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok());
    let mut types =
        lists.flat_map(|list| list.split(',')).map(|entry| entry.split(';').next().unwrap_or("").trim());
    types.find(|name| ["application/json", "model/gltf-binary"].contains(name)) == Some("application/json")
}
