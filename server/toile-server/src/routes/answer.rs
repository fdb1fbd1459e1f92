//! Answers with bytes that a client may keep.

use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;

/// Media type of a GLB.
pub const GLB: HeaderValue = HeaderValue::from_static("model/gltf-binary");
/// Kept, but asked after each time: the bytes change when networks do.
pub const REVALIDATE: HeaderValue = HeaderValue::from_static("public, no-cache");
/// Kept for good: the address is the content's.
pub const IMMUTABLE: HeaderValue = HeaderValue::from_static("public, max-age=31536000, immutable");

/// A strong validator. `tag` is lowercase hex.
pub struct Etag(HeaderValue);

impl Etag {
    /// From the address of the content.
    pub fn new(tag: &str) -> Option<Self> {
        HeaderValue::from_str(&format!("\"{tag}\"")).ok().map(Self)
    }

    /// Whether the client has this content already (`If-None-Match`, weak comparison).
    pub fn is_known(&self, headers: &HeaderMap) -> bool {
        let lists = headers.get_all(header::IF_NONE_MATCH).iter().filter_map(|value| value.to_str().ok());
        let mut tags = lists.flat_map(|list| list.split(',')).map(str::trim);
        tags.any(|tag| tag == "*" || tag.strip_prefix("W/").unwrap_or(tag).as_bytes() == self.0.as_bytes())
    }

    /// 304.
    pub fn not_modified(self, cache_control: HeaderValue) -> Response {
        let headers = [(header::ETAG, self.0), (header::CACHE_CONTROL, cache_control)];
        (StatusCode::NOT_MODIFIED, headers).into_response()
    }

    /// 200 with the content.
    pub fn answer(self, media_type: HeaderValue, cache_control: HeaderValue, bytes: Bytes) -> Response {
        let headers = [
            (header::CONTENT_TYPE, media_type),
            (header::ETAG, self.0),
            (header::CACHE_CONTROL, cache_control),
        ];
        (headers, bytes).into_response()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_tag_is_found_in_a_list_and_when_weak() {
        let known = |value: &'static str| {
            let headers = HeaderMap::from_iter([(header::IF_NONE_MATCH, HeaderValue::from_static(value))]);
            Etag::new("abc").unwrap().is_known(&headers)
        };
        assert!(known("\"abc\""));
        assert!(known("\"x\", W/\"abc\""));
        assert!(known("*"));
        assert!(!known("\"abcd\""));
    }
}
