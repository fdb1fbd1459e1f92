//! JSON in: strict, bounded, and precise about what is wrong where.

use std::error::Error;

use axum::body::Bytes;
use axum::extract::{FromRequest, FromRequestParts, Query, Request};
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode, header};
use serde::de::DeserializeOwned;
use serde_json::error::Category;
use serde_path_to_error::{Path, Segment};
use tower_http::timeout::TimeoutError;

use crate::errors::{ApiError, Code};

/// A JSON request body.
pub struct JsonBody<T>(pub T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for JsonBody<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        if !is_json(request.headers()) {
            return Err(ApiError::new(Code::UnsupportedMediaType, "Send the body as application/json."));
        }
        let bytes = Bytes::from_request(request, state).await.map_err(|rejection| {
            let otherwise = ApiError::new(Code::InvalidJson, "The request body breaks off.");
            body_error(&rejection, rejection.status(), otherwise)
        })?;
        parse(&bytes).map(Self)
    }
}

/// Query parameters of which none may be unknown.
pub struct QueryParameters<T>(pub T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequestParts<S> for QueryParameters<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        let Query(parameters) = Query::<T>::from_request_parts(parts, state).await.map_err(|rejection| {
            let message = rejection.body_text();
            let message = message.rsplit_once("query string: ").map_or(message.as_str(), |(_, cause)| cause);
            ApiError::new(field_code(message), sentence(message))
        })?;
        Ok(Self(parameters))
    }
}

/// Reads JSON strictly.
///
/// # Errors
/// `invalid-json` where the text is no JSON, otherwise the code and pointer of the field at fault.
pub fn parse<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, ApiError> {
    let mut text = serde_json::Deserializer::from_slice(bytes);
    let value = serde_path_to_error::deserialize(&mut text).map_err(|error| {
        let pointer = pointer(error.path());
        let cause = error.into_inner();
        match cause.classify() {
            Category::Data => {
                ApiError::new(field_code(&cause.to_string()), sentence(&cause.to_string())).at(pointer)
            }
            _ => ApiError::new(Code::InvalidJson, sentence(&cause.to_string())),
        }
    })?;
    text.end().map_err(|cause| ApiError::new(Code::InvalidJson, sentence(&cause.to_string())))?;
    Ok(value)
}

/// What to answer when a request body cannot be read to its end.
pub fn body_error(error: &(dyn Error + 'static), status: StatusCode, otherwise: ApiError) -> ApiError {
    let mut cause = Some(error);
    while let Some(found) = cause {
        if found.is::<TimeoutError>() {
            return ApiError::new(Code::RequestTimeout, "The request body came too slowly.");
        }
        cause = found.source();
    }
    match status {
        StatusCode::PAYLOAD_TOO_LARGE => ApiError::new(Code::TooLarge, "The request body is too large."),
        _ => otherwise,
    }
}

fn is_json(headers: &HeaderMap) -> bool {
    let value = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok()).unwrap_or("");
    let essence = value.split(';').next().unwrap_or("").trim();
    essence.eq_ignore_ascii_case("application/json")
}

fn field_code(message: &str) -> Code {
    if message.contains("unknown field") {
        Code::UnknownField
    } else if message.contains("missing field") {
        Code::MissingField
    } else {
        Code::InvalidField
    }
}

fn sentence(message: &str) -> String {
    let mut letters = message.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).chain(['.']).collect()).unwrap_or_default()
}

fn pointer(path: &Path) -> String {
    path.iter().fold(String::new(), |mut pointer, segment| {
        pointer.push('/');
        match segment {
            Segment::Seq { index } => pointer.push_str(&index.to_string()),
            Segment::Map { key } => pointer.push_str(&escape(key)),
            Segment::Enum { variant } => pointer.push_str(&escape(variant)),
            Segment::Unknown => pointer.push('?'),
        }
        pointer
    })
}

/// A name as one step of a JSON pointer (RFC 6901).
pub fn escape(name: &str) -> String {
    name.replace('~', "~0").replace('/', "~1")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Outer {
        inner: Vec<Inner>,
    }

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)]
    struct Inner {
        size: f32,
    }

    fn refused(text: &str) -> (Code, Option<String>) {
        let error = parse::<Outer>(text.as_bytes()).unwrap_err();
        (error.code, error.pointer)
    }

    #[test]
    fn every_mistake_has_its_code_and_pointer() {
        assert_eq!(refused("{"), (Code::InvalidJson, None));
        assert_eq!(refused(r#"{"inner": []} x"#), (Code::InvalidJson, None));
        assert_eq!(
            refused(r#"{"inner": [{"size": 1, "a/b": 2}]}"#),
            (Code::UnknownField, Some("/inner/0/a~1b".into()))
        );
        assert_eq!(refused(r#"{"inner": [{"size": 1}, {}]}"#), (Code::MissingField, Some("/inner/1".into())));
        assert_eq!(
            refused(r#"{"inner": [{"size": "large"}]}"#),
            (Code::InvalidField, Some("/inner/0/size".into()))
        );
    }
}
