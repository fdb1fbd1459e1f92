//! Preset poses and motions.

use axum::Json;
use axum::extract::{Path, State};
use serde_json::{Value, json};
use toile_geometry::poses::Preset;

use super::App;
use crate::errors::{ApiError, Code};

/// `GET /v1/poses`
pub async fn list(State(app): State<App>) -> Json<Value> {
    let presets = app.service.assets.poses.presets().iter();
    let data = presets.map(|pose| json!({"id": pose.id, "label": pose.label, "group": pose.group}));
    Json(json!({"data": data.collect::<Vec<_>>()}))
}

/// `GET /v1/poses/{id}`
pub async fn show(State(app): State<App>, Path(id): Path<String>) -> Result<Json<Preset>, ApiError> {
    let pose = app.service.assets.poses.preset(&id).cloned();
    pose.map(Json).ok_or_else(|| ApiError::new(Code::NotFound, format!("There is no pose \"{id}\".")))
}

/// `GET /v1/motions`
pub async fn motions(State(app): State<App>) -> Json<Value> {
    let motions = app.service.assets.poses.motions().iter();
    let data = motions.map(|motion| {
        json!({"id": motion.id, "label": motion.label, "frames": motion.frames.len(), "frame_rate": motion.frame_rate})
    });
    Json(json!({"data": data.collect::<Vec<_>>()}))
}
