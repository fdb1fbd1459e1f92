//! What `model/bake.py` reads of an outfit, and what it brings back.

use axum::Json;
use axum::body::Bytes;
use axum::extract::{FromRequest, Path, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::Response;

use super::App;
use super::answer::{Etag, REVALIDATE};
use crate::bakes::BakeReport;
use crate::errors::{ApiError, Code};
use crate::json::body_error;

/// `GET /v1/outfits/{id}/static.safetensors`
pub async fn tensors(
    State(app): State<App>,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let wardrobe = &app.service.wardrobe;
    wardrobe.stored(&id).await?;
    let etag = Etag::new(&wardrobe.static_key(&id)).ok_or_else(|| ApiError::internal("entity tag"))?;
    if etag.is_known(&headers) {
        return Ok(etag.not_modified(REVALIDATE));
    }
    let file = wardrobe.tensors(&id).await?;
    Ok(etag.answer(HeaderValue::from_static("application/octet-stream"), REVALIDATE, file.into()))
}

/// `GET /v1/outfits/{id}/bake`
pub async fn show(State(app): State<App>, Path(id): Path<String>) -> Result<Json<BakeReport>, ApiError> {
    let (prepared, _) = app.service.wardrobe.get(&id).await?;
    prepared.bake.clone().map(Json).ok_or_else(|| none(&id))
}

/// `PUT /v1/outfits/{id}/bake`
pub async fn put(
    State(app): State<App>,
    Path(id): Path<String>,
    request: Request,
) -> Result<Json<BakeReport>, ApiError> {
    let _turn = app.upload_turn()?;
    let file = received(&app, request, Code::InvalidBake).await?;
    Ok(Json(app.service.wardrobe.bake(&id, file).await?))
}

/// `DELETE /v1/outfits/{id}/bake`
pub async fn remove(State(app): State<App>, Path(id): Path<String>) -> Result<StatusCode, ApiError> {
    app.service.wardrobe.stored(&id).await?;
    if app.service.wardrobe.unbake(&id).await? { Ok(StatusCode::NO_CONTENT) } else { Err(none(&id)) }
}

/// The bytes of a request; `code` where they break off.
///
/// # Errors
/// `too-large`, `request-timeout` or `code`.
pub async fn received(app: &App, request: Request, code: Code) -> Result<Bytes, ApiError> {
    Bytes::from_request(request, app).await.map_err(|rejection| {
        let otherwise = ApiError::new(code, "The request body breaks off.");
        body_error(&rejection, rejection.status(), otherwise)
    })
}

fn none(id: &str) -> ApiError {
    ApiError::new(Code::NoBake, format!("The outfit \"{id}\" has no bake; `make bake` makes one."))
}
