//! Every request has an id: the client's `x-request-id` if it is harmless, otherwise a new one.
//! It is in the answer's header and in every log line of the request.

use std::hash::{BuildHasher, RandomState};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use axum::extract::Request;
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use axum::middleware::Next;
use axum::response::Response;
use tracing::Instrument;

const HEADER: HeaderName = HeaderName::from_static("x-request-id");
const MAX_LENGTH: usize = 64;

static COUNTER: AtomicU64 = AtomicU64::new(0);
static RANDOM: LazyLock<RandomState> = LazyLock::new(RandomState::new);

/// Middleware: gives the request its id, its tracing span and its one log line.
pub async fn with_request_id(request: Request, next: Next) -> Response {
    let id = harmless_id(request.headers()).unwrap_or_else(new_id);
    let span = tracing::info_span!("request", id, method = %request.method(), path = request.uri().path());
    let started = Instant::now();
    async move {
        let mut response = next.run(request).await;
        let milliseconds = started.elapsed().as_secs_f64() * 1e3;
        tracing::info!(status = response.status().as_u16(), milliseconds, "answered");
        if let Ok(value) = HeaderValue::from_str(&id) {
            response.headers_mut().insert(HEADER, value);
        }
        response
    }
    .instrument(span)
    .await
}

fn harmless_id(headers: &HeaderMap) -> Option<String> {
    let id = headers.get(HEADER)?.to_str().ok()?;
    let harmless = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    (!id.is_empty() && id.len() <= MAX_LENGTH && id.chars().all(harmless)).then(|| id.to_owned())
}

fn new_id() -> String {
    format!("{:016x}", RANDOM.hash_one(COUNTER.fetch_add(1, Ordering::Relaxed)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_short_plain_id_is_taken_over() {
        let id_of = |value: &'static str| {
            harmless_id(&HeaderMap::from_iter([(HEADER, HeaderValue::from_static(value))]))
        };
        assert_eq!(id_of("order-17.a_B"), Some("order-17.a_B".into()));
        assert_eq!(id_of("two words"), None);
        assert_eq!(id_of(""), None);
        assert_ne!(new_id(), new_id());
    }
}
