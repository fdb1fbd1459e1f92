//! A pixel-cloth network of an outfit's own, as `model/hero.py` makes it.

use axum::Json;
use axum::extract::{Path, Request, State};
use axum::http::StatusCode;

use super::App;
use super::bakes::received;
use crate::errors::{ApiError, Code};
use crate::heroes::HeroReport;

/// `GET /v1/outfits/{id}/hero`
pub async fn show(State(app): State<App>, Path(id): Path<String>) -> Result<Json<HeroReport>, ApiError> {
    let (prepared, _) = app.service.wardrobe.get(&id).await?;
    prepared.hero.as_ref().map(|(_, report)| Json(report.clone())).ok_or_else(|| none(&id))
}

/// `PUT /v1/outfits/{id}/hero`
pub async fn put(
    State(app): State<App>,
    Path(id): Path<String>,
    request: Request,
) -> Result<Json<HeroReport>, ApiError> {
    let _turn = app.upload_turn()?;
    let file = received(&app, request, Code::InvalidHero).await?;
    Ok(Json(app.service.wardrobe.add_hero(&id, file).await?))
}

/// `DELETE /v1/outfits/{id}/hero`
pub async fn remove(State(app): State<App>, Path(id): Path<String>) -> Result<StatusCode, ApiError> {
    app.service.wardrobe.stored(&id).await?;
    if app.service.wardrobe.drop_hero(&id).await? { Ok(StatusCode::NO_CONTENT) } else { Err(none(&id)) }
}

fn none(id: &str) -> ApiError {
    let detail = format!("The outfit \"{id}\" has no pixel-cloth network of its own; `make hero` makes one.");
    ApiError::new(Code::NoHero, detail)
}
