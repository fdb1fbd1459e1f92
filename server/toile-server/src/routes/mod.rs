//! HTTP: one file for each resource, thin. What is done here is said in `docs/api.md`.

mod answer;
mod bakes;
mod bodies;
mod drapes;
mod health;
mod heroes;
mod multipart;
mod outfits;
mod page;
mod poses;

use std::any::Any;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::{HeaderName, Method, header};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use tokio::sync::{Semaphore, SemaphorePermit};
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::cors::{Any as AnyOrigin, CorsLayer};
use tower_http::timeout::RequestBodyTimeoutLayer;

use crate::bakes::MAX_BAKE_BYTES;
use crate::errors::{ApiError, Code};
use crate::heroes::MAX_HERO_BYTES;
use crate::lifecycle::{Lifecycle, Phase};
use crate::request_id::with_request_id;
use crate::server_timing;
use crate::service::Service;
use crate::workers::panic_message;

/// Largest JSON body; a sequence of 256 poses of all joints is below 2 MB.
const MAX_JSON_BYTES: usize = 4 * 1024 * 1024;
/// Largest upload: the file and a little for the form around it.
const MAX_UPLOAD_BYTES: usize = toile_gltf::MAX_BYTES + 64 * 1024;
/// Uploads that are held in memory at once.
const MAX_UPLOADS: usize = 4;

/// What handlers work with.
#[derive(Clone)]
pub struct App {
    /// The service.
    pub service: Arc<Service>,
    /// Starting, ready, stopping.
    pub lifecycle: Lifecycle,
    /// Turns for uploads.
    pub uploads: Arc<Semaphore>,
}

impl App {
    /// The state of a server.
    pub fn new(service: Arc<Service>, lifecycle: Lifecycle) -> Self {
        Self { service, lifecycle, uploads: Arc::new(Semaphore::new(MAX_UPLOADS)) }
    }

    /// A turn to hold an upload in memory.
    ///
    /// # Errors
    /// `overloaded` while there are as many as there may be.
    fn upload_turn(&self) -> Result<SemaphorePermit<'_>, ApiError> {
        let busy = |_| ApiError::new(Code::Overloaded, "Too many uploads at once; try again shortly.");
        self.uploads.try_acquire().map_err(busy)
    }
}

/// All routes. `body_read` bounds the time between two pieces of a request body.
pub fn router(app: App, web: Option<&Path>, body_read: Duration) -> Router {
    let api = Router::new()
        .route(
            "/v1/outfits",
            get(outfits::list).post(outfits::upload).layer(DefaultBodyLimit::max(MAX_UPLOAD_BYTES)),
        )
        .route("/v1/outfits/{id}", get(outfits::show).delete(outfits::remove))
        .route("/v1/outfits/{id}/static.glb", get(outfits::rest_pose))
        .route("/v1/outfits/{id}/static.safetensors", get(bakes::tensors))
        .route(
            "/v1/outfits/{id}/bake",
            get(bakes::show)
                .put(bakes::put)
                .delete(bakes::remove)
                .layer(DefaultBodyLimit::max(MAX_BAKE_BYTES)),
        )
        .route(
            "/v1/outfits/{id}/hero",
            get(heroes::show)
                .put(heroes::put)
                .delete(heroes::remove)
                .layer(DefaultBodyLimit::max(MAX_HERO_BYTES)),
        )
        .route("/v1/outfits/{id}/thumbnail.png", get(outfits::thumbnail))
        .route("/v1/body", get(bodies::parameters))
        .route("/v1/body/reference.glb", get(bodies::reference))
        .route("/v1/bodies", post(bodies::solve).layer(DefaultBodyLimit::max(MAX_UPLOAD_BYTES)))
        .route("/v1/poses", get(poses::list))
        .route("/v1/poses/{id}", get(poses::show))
        .route("/v1/motions", get(poses::motions))
        .route("/v1/drapes", post(drapes::drape))
        .route("/v1/drapes/{id}/drape.glb", get(drapes::kept))
        .route("/v1/drapes/{id}/cloth.png", get(drapes::kept_picture))
        .route("/v1", axum::routing::any(nothing_here))
        .route("/v1/", axum::routing::any(nothing_here))
        .route("/v1/{*rest}", axum::routing::any(nothing_here))
        .layer(DefaultBodyLimit::max(MAX_JSON_BYTES))
        .layer(from_fn_with_state(app.lifecycle.clone(), refuse_when_stopping));
    api.route("/healthz", get(health::alive))
        .route("/readyz", get(health::ready))
        .fallback_service(page::service(web))
        .method_not_allowed_fallback(wrong_method)
        .layer(CatchPanicLayer::custom(on_panic))
        .layer(RequestBodyTimeoutLayer::new(body_read))
        .layer(cross_origin())
        .layer(from_fn(with_request_id))
        .with_state(app)
}

/// A shop's page may embed the viewer, whatever its origin: there are no cookies to protect.
fn cross_origin() -> CorsLayer {
    let exposed = [
        header::LOCATION,
        header::ETAG,
        header::RETRY_AFTER,
        server_timing::HEADER,
        drapes::QUALITY_HEADER,
        HeaderName::from_static("x-request-id"),
    ];
    CorsLayer::new()
        .allow_origin(AnyOrigin)
        .allow_methods([Method::GET, Method::POST])
        .allow_headers(AnyOrigin)
        .expose_headers(exposed)
}

/// Connections that are open already may still send requests while the server stops.
async fn refuse_when_stopping(State(lifecycle): State<Lifecycle>, request: Request, next: Next) -> Response {
    if lifecycle.phase() == Phase::Stopping {
        return ApiError::new(Code::Stopping, "The server is stopping; try another one.").into_response();
    }
    next.run(request).await
}

async fn nothing_here() -> ApiError {
    ApiError::new(Code::NotFound, "There is nothing at this address.")
}

async fn wrong_method() -> ApiError {
    ApiError::new(Code::MethodNotAllowed, "The header `Allow` lists the methods of this address.")
}

fn on_panic(panic: Box<dyn Any + Send>) -> Response {
    ApiError::internal(format!("panic: {}", panic_message(&*panic))).into_response()
}
