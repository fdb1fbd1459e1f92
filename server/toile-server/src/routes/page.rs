//! The try-on page: the built files as they are, and `index.html` for every other page address.

use std::path::Path;

use axum::Router;
use axum::extract::Request;
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn};
use axum::response::{IntoResponse, Response};
use tower_http::services::{ServeDir, ServeFile};

use super::answer::{IMMUTABLE, REVALIDATE};
use crate::errors::{ApiError, Code};

/// Vite puts a hash of the content into the name of every file below this folder.
const HASHED: &str = "/assets/";

/// Serves the page in `web`; without one, says how to build it.
pub fn service(web: Option<&Path>) -> Router {
    let Some(web) = web else { return Router::new().fallback(not_built) };
    let index =
        Router::new().fallback_service(ServeFile::new(web.join("index.html"))).layer(from_fn(only_pages));
    Router::new().fallback_service(ServeDir::new(web).fallback(index)).layer(from_fn(with_caching))
}

/// A missing script must not be answered with the page: the browser would try to run it.
async fn only_pages(request: Request, next: Next) -> Response {
    let name = request.uri().path().rsplit('/').next().unwrap_or("");
    if name.contains('.') {
        return ApiError::new(Code::NotFound, "There is no such file.").into_response();
    }
    next.run(request).await
}

async fn with_caching(request: Request, next: Next) -> Response {
    let caching = if request.uri().path().starts_with(HASHED) { IMMUTABLE } else { REVALIDATE };
    let mut response = next.run(request).await;
    if response.status() == StatusCode::METHOD_NOT_ALLOWED {
        let allow = [(header::ALLOW, HeaderValue::from_static("GET,HEAD"))];
        let problem = ApiError::new(Code::MethodNotAllowed, "The page is only to be read: use GET.");
        return (allow, problem).into_response();
    }
    if response.status().is_success() || response.status() == StatusCode::NOT_MODIFIED {
        response.headers_mut().insert(header::CACHE_CONTROL, caching);
    }
    response
}

async fn not_built() -> ApiError {
    ApiError::new(
        Code::NotFound,
        "The try-on page is not built; run `make build`, or say where it is with --web DIR.",
    )
}
