//! The form of an upload.

use axum::extract::multipart::{Field, MultipartError, MultipartRejection};
use axum::extract::{FromRequest, Multipart, Request};
use bytes::{Bytes, BytesMut};
use serde::de::DeserializeOwned;

use crate::errors::{ApiError, Code};
use crate::json::{body_error, parse};

/// A file and what is stated about it.
pub struct UploadForm<M> {
    /// The bytes of the file.
    pub file: Bytes,
    /// Its name, if it has one.
    pub file_name: Option<String>,
    /// What is stated.
    pub metadata: M,
}

impl<S: Send + Sync, M: DeserializeOwned + Default + Send> FromRequest<S> for UploadForm<M> {
    type Rejection = ApiError;

    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        let mut form = Multipart::from_request(request, state).await.map_err(not_multipart)?;
        let (mut file, mut metadata) = (None, None);
        while let Some(field) = form.next_field().await.map_err(broken)? {
            match field.name() {
                Some("file") if file.is_none() => {
                    let name = field.file_name().map(str::to_owned);
                    file = Some((name, read(field, toile_gltf::MAX_BYTES).await?));
                }
                Some("metadata") if metadata.is_none() => {
                    let bytes = read(field, super::MAX_JSON_BYTES).await?;
                    metadata = Some(parse::<M>(&bytes).map_err(|error| error.under("/metadata"))?);
                }
                name => return Err(unexpected(name.unwrap_or(""))),
            }
        }
        let missing = || ApiError::new(Code::MissingField, "The form needs a part `file`.").at("/file");
        let (file_name, file) = file.ok_or_else(missing)?;
        Ok(Self { file, file_name, metadata: metadata.unwrap_or_default() })
    }
}

async fn read(mut field: Field<'_>, limit: usize) -> Result<Bytes, ApiError> {
    let mut bytes = BytesMut::new();
    while let Some(chunk) = field.chunk().await.map_err(broken)? {
        if bytes.len() + chunk.len() > limit {
            let name = field.name().unwrap_or("").to_owned();
            let detail = format!("The part `{name}` is larger than {limit} bytes.");
            return Err(ApiError::new(Code::TooLarge, detail).at(format!("/{name}")));
        }
        bytes.extend_from_slice(&chunk);
    }
    Ok(bytes.freeze())
}

fn unexpected(name: &str) -> ApiError {
    let detail =
        format!("The form takes one part `file` and at most one `metadata`; \"{name}\" is one too many.");
    ApiError::new(Code::UnknownField, detail).at(crate::requests::member(name))
}

fn not_multipart(rejection: MultipartRejection) -> ApiError {
    match rejection {
        MultipartRejection::InvalidBoundary(_) => {
            let detail = "Send the upload as multipart/form-data with a boundary.";
            ApiError::new(Code::UnsupportedMediaType, detail)
        }
        other => ApiError::new(Code::InvalidMultipart, other.body_text()),
    }
}

fn broken(error: MultipartError) -> ApiError {
    let detail = format!("The form breaks off or is malformed: {error}.");
    body_error(&error, error.status(), ApiError::new(Code::InvalidMultipart, detail))
}
