//! Outfits: upload, list, show, delete, rest pose, picture.

use axum::Json;
use axum::extract::{FromRequest, Path, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use toile_drape::methods::MethodKind;
use toile_drape::outfit::Report;

use super::App;
use super::answer::{Etag, GLB, REVALIDATE};
use super::multipart::UploadForm;
use crate::errors::{ApiError, Code};
use crate::hash::short_hash;
use crate::json::QueryParameters;
use crate::server_timing::ServerTiming;
use crate::simulations::Simulated;
use crate::store::{GarmentSummary, StoredOutfit};
use crate::upload::{Kinds, Upload};

const DEFAULT_LIMIT: i64 = 20;
const MAX_LIMIT: i64 = 100;

/// An outfit as the API shows it.
#[derive(Serialize)]
struct OutfitView {
    id: String,
    name: String,
    vertices: usize,
    triangles: usize,
    garments: Vec<GarmentSummary>,
    methods: Vec<String>,
    #[serde(skip_serializing_if = "Kinds::is_empty")]
    kinds: Kinds,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    simulated: Vec<Simulated>,
    created_at: String,
    links: Links,
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<Report>,
}

#[derive(Serialize)]
struct Links {
    #[serde(rename = "self")]
    own: String,
    r#static: String,
    thumbnail: Option<String>,
    bake: Option<String>,
    hero: Option<String>,
}

impl OutfitView {
    fn new(app: &App, stored: StoredOutfit) -> Self {
        let outfit = stored.outfit;
        let at = location(&outfit.id);
        let data = app.service.store.data();
        let has_thumbnail = data.thumbnail(&outfit.id).exists();
        let has_hero = data.hero(&outfit.id).exists();
        let mut garments = outfit.summary.garments;
        garments.iter_mut().for_each(|garment| garment.pixel_cloth |= has_hero);
        let has_bake = data.bake(&app.service.wardrobe.static_key(&outfit.id)).exists();
        let simulated =
            app.service.assets.simulations.of(&outfit.id).map_or_else(Vec::new, |kept| kept.on.clone());
        Self {
            links: Links {
                r#static: format!("{at}/static.glb"),
                thumbnail: has_thumbnail.then(|| format!("{at}/thumbnail.png")),
                bake: has_bake.then(|| format!("{at}/bake")),
                hero: has_hero.then(|| format!("{at}/hero")),
                own: at,
            },
            methods: methods(&garments, &outfit.upload.metadata.kinds, !simulated.is_empty()),
            id: outfit.id,
            name: outfit.name,
            vertices: outfit.summary.vertices,
            triangles: outfit.summary.triangles,
            garments,
            kinds: outfit.upload.metadata.kinds,
            simulated,
            created_at: stored.created_at,
            report: Some(outfit.report),
        }
    }

    fn without_report(self) -> Self {
        Self { report: None, ..self }
    }
}

/// The methods that drape an outfit as it is: `garnet` where the kind of every garment was stated, `pixel_cloth` where
/// every garment has a network, `simulation` where some were kept.
fn methods(garments: &[GarmentSummary], kinds: &Kinds, is_simulated: bool) -> Vec<String> {
    let is_known = garments.iter().all(|garment| kinds.contains_key(&garment.name));
    let has_networks = garments.iter().all(|garment| garment.pixel_cloth);
    let able = MethodKind::ALL.into_iter().filter(|method| match method {
        MethodKind::Garnet => is_known,
        MethodKind::PixelCloth => has_networks,
        MethodKind::Simulation => is_simulated,
        _ => true,
    });
    able.map(|method| method.to_string()).collect()
}

fn location(id: &str) -> String {
    format!("/v1/outfits/{id}")
}

/// `POST /v1/outfits`
pub async fn upload(State(app): State<App>, request: Request) -> Result<Response, ApiError> {
    let _turn = app.upload_turn()?;
    let mut timing = ServerTiming::default();
    let started = std::time::Instant::now();
    let UploadForm { file, file_name, metadata } = UploadForm::from_request(request, &app).await?;
    let upload = Upload { file_name, metadata };
    timing.add_since("receive", started, None);
    let (stored, is_new) = app.service.wardrobe.add(file, upload, &mut timing).await?;
    let status = if is_new { StatusCode::CREATED } else { StatusCode::OK };
    let at = HeaderValue::from_str(&location(&stored.outfit.id)).map_err(ApiError::internal)?;
    Ok((status, timing, [(header::LOCATION, at)], Json(OutfitView::new(&app, stored))).into_response())
}

/// Which page of the list.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ListParameters {
    limit: Option<i64>,
    cursor: Option<String>,
}

/// `GET /v1/outfits`
pub async fn list(
    State(app): State<App>,
    QueryParameters(parameters): QueryParameters<ListParameters>,
) -> Result<Json<Value>, ApiError> {
    let limit = parameters.limit.unwrap_or(DEFAULT_LIMIT);
    if !(1..=MAX_LIMIT).contains(&limit) {
        let detail = format!("`limit` must be between 1 and {MAX_LIMIT}.");
        return Err(ApiError::new(Code::InvalidField, detail));
    }
    let after = parameters.cursor.as_deref().map_or(Ok(0), |cursor| {
        let invalid = |_| ApiError::new(Code::InvalidField, "`cursor` must be a `next_cursor` of this list.");
        cursor.parse::<i64>().map_err(invalid)
    })?;
    // One more than asked for tells whether there is another page.
    let mut rows = app.service.store.list(after, limit + 1).await?;
    let has_more = rows.len() as i64 > limit;
    rows.truncate(limit as usize);
    let next_cursor = rows.last().filter(|_| has_more).map(|row| row.sequence.to_string());
    let data: Vec<_> = rows.into_iter().map(|row| OutfitView::new(&app, row).without_report()).collect();
    Ok(Json(json!({"data": data, "next_cursor": next_cursor})))
}

/// `GET /v1/outfits/{id}`
pub async fn show(State(app): State<App>, Path(id): Path<String>) -> Result<Response, ApiError> {
    let stored = app.service.wardrobe.stored(&id).await?;
    Ok(Json(OutfitView::new(&app, stored)).into_response())
}

/// `DELETE /v1/outfits/{id}`
pub async fn remove(State(app): State<App>, Path(id): Path<String>) -> Result<StatusCode, ApiError> {
    if app.service.wardrobe.remove(&id).await? {
        return Ok(StatusCode::NO_CONTENT);
    }
    Err(ApiError::new(Code::UnknownOutfit, format!("There is no outfit \"{id}\".")))
}

/// `GET /v1/outfits/{id}/static.glb`
pub async fn rest_pose(
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
    let (prepared, _) = wardrobe.get(&id).await?;
    let glb = app.service.workers.run(move |_| prepared.rest_glb()).await?.map_err(ApiError::internal)?;
    Ok(etag.answer(GLB, REVALIDATE, glb.into()))
}

/// `GET /v1/outfits/{id}/thumbnail.png`
pub async fn thumbnail(
    State(app): State<App>,
    Path(id): Path<String>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    app.service.wardrobe.stored(&id).await?;
    let none = |_| ApiError::new(Code::NoThumbnail, format!("The outfit \"{id}\" has no thumbnail."));
    let png = tokio::fs::read(app.service.store.data().thumbnail(&id)).await.map_err(none)?;
    let etag = Etag::new(&short_hash([png.as_slice()])).ok_or_else(|| ApiError::internal("entity tag"))?;
    if etag.is_known(&headers) {
        return Ok(etag.not_modified(REVALIDATE));
    }
    Ok(etag.answer(HeaderValue::from_static("image/png"), REVALIDATE, png.into()))
}
