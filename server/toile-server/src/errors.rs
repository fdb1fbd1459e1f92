//! The one error of the HTTP surface: a stable code, a sentence and a JSON pointer, sent as RFC 9457.

use std::fmt;

use axum::Json;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

/// Seconds after which an overloaded server is worth another try.
const RETRY_AFTER_SECONDS: u16 = 1;

/// What went wrong, as a client may match on it. The names are part of the API.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    InvalidJson,
    UnknownField,
    InvalidField,
    MissingField,
    InvalidMultipart,
    UnknownJoint,
    NonUnitQuaternion,
    UnknownPose,
    UnknownMotion,
    EmptySequence,
    TooManyFrames,
    UnknownPhenotype,
    PhenotypeOutOfRange,
    UnknownMeasurement,
    UnknownOutfit,
    DrapeExpired,
    NoThumbnail,
    NoBake,
    NoHero,
    OutdatedBake,
    NotFound,
    MethodNotAllowed,
    RequestTimeout,
    TooLarge,
    UnsupportedMediaType,
    NotAMesh,
    Truncated,
    ExternalUri,
    UnsupportedExtension,
    InvalidAccessor,
    NonFinitePosition,
    IndexOutOfRange,
    NoTriangles,
    WrongUnits,
    OffBody,
    InvalidBake,
    InvalidHero,
    UnknownKind,
    /// `pixel_cloth` for a garment without a network.
    NoPixelCloth,
    /// `simulation` for a body or a pose that there is none of.
    NotSimulated,
    /// A normal map of a garment whose UVs do not do for it.
    NoUvs,
    /// A normal map of a sequence.
    SinglePoseOnly,
    UnknownScan,
    NotABody,
    MeasurementOutOfRange,
    MeasurementUnits,
    UnreachableMeasurements,
    Internal,
    Overloaded,
    Stopping,
}

impl Code {
    /// Status, stable name and title of the problem type.
    fn entry(self) -> (StatusCode, &'static str, &'static str) {
        use StatusCode as S;
        match self {
            Self::InvalidJson => (S::BAD_REQUEST, "invalid-json", "The request is not valid JSON"),
            Self::UnknownField => {
                (S::BAD_REQUEST, "unknown-field", "The request has a field that is not known")
            }
            Self::InvalidField => {
                (S::BAD_REQUEST, "invalid-field", "A field has a value that cannot be used")
            }
            Self::MissingField => (S::BAD_REQUEST, "missing-field", "A required field is missing"),
            Self::InvalidMultipart => {
                (S::BAD_REQUEST, "invalid-multipart", "The multipart form cannot be read")
            }
            Self::UnknownJoint => (S::BAD_REQUEST, "unknown-joint", "There is no such joint"),
            Self::NonUnitQuaternion => {
                (S::BAD_REQUEST, "non-unit-quaternion", "A rotation is not a unit quaternion")
            }
            Self::UnknownPose => (S::BAD_REQUEST, "unknown-pose", "There is no such pose"),
            Self::UnknownMotion => (S::BAD_REQUEST, "unknown-motion", "There is no such motion"),
            Self::EmptySequence => (S::BAD_REQUEST, "empty-sequence", "A sequence needs at least one pose"),
            Self::TooManyFrames => (S::BAD_REQUEST, "too-many-frames", "The sequence is too long"),
            Self::UnknownPhenotype => {
                (S::BAD_REQUEST, "unknown-phenotype", "There is no such body parameter")
            }
            Self::PhenotypeOutOfRange => {
                (S::BAD_REQUEST, "phenotype-out-of-range", "A body parameter is out of range")
            }
            Self::UnknownMeasurement => {
                (S::BAD_REQUEST, "unknown-measurement", "There is no such measurement")
            }
            Self::UnknownOutfit => (S::NOT_FOUND, "unknown-outfit", "There is no such outfit"),
            Self::DrapeExpired => (S::NOT_FOUND, "drape-expired", "The drape is no longer kept"),
            Self::NoBake => (S::NOT_FOUND, "no-bake", "The outfit has no bake"),
            Self::OutdatedBake => {
                (S::CONFLICT, "outdated-bake", "The bake is of another outfit or other networks")
            }
            Self::NoHero => (S::NOT_FOUND, "no-hero", "The outfit has no pixel-cloth network of its own"),
            Self::NoThumbnail => (S::NOT_FOUND, "no-thumbnail", "The outfit has no thumbnail"),
            Self::NotFound => (S::NOT_FOUND, "not-found", "There is nothing at this address"),
            Self::MethodNotAllowed => {
                (S::METHOD_NOT_ALLOWED, "method-not-allowed", "The address does not take this method")
            }
            Self::RequestTimeout => {
                (S::REQUEST_TIMEOUT, "request-timeout", "The request body came too slowly")
            }
            Self::TooLarge => (S::PAYLOAD_TOO_LARGE, "too-large", "The request is too large"),
            Self::UnsupportedMediaType => {
                (S::UNSUPPORTED_MEDIA_TYPE, "unsupported-media-type", "The format is not supported")
            }
            Self::NotAMesh => (S::UNPROCESSABLE_ENTITY, "not-a-mesh", "The file holds no mesh"),
            Self::Truncated => (S::UNPROCESSABLE_ENTITY, "truncated", "The file ends too early"),
            Self::ExternalUri => {
                (S::UNPROCESSABLE_ENTITY, "external-uri", "The file refers to something outside itself")
            }
            Self::UnsupportedExtension => (
                S::UNPROCESSABLE_ENTITY,
                "unsupported-extension",
                "The file requires an extension that is not supported",
            ),
            Self::InvalidAccessor => {
                (S::UNPROCESSABLE_ENTITY, "invalid-accessor", "The file's data does not fit its description")
            }
            Self::NonFinitePosition => {
                (S::UNPROCESSABLE_ENTITY, "non-finite-position", "A position is not a finite number")
            }
            Self::IndexOutOfRange => (
                S::UNPROCESSABLE_ENTITY,
                "index-out-of-range",
                "A triangle refers to a vertex that does not exist",
            ),
            Self::NoTriangles => (S::UNPROCESSABLE_ENTITY, "no-triangles", "The mesh has no triangles"),
            Self::WrongUnits => {
                (S::UNPROCESSABLE_ENTITY, "wrong-units", "The outfit has the wrong size for its units")
            }
            Self::OffBody => (S::UNPROCESSABLE_ENTITY, "off-body", "The outfit is not on the body"),
            Self::InvalidBake => (S::UNPROCESSABLE_ENTITY, "invalid-bake", "The bake cannot be used"),
            Self::InvalidHero => {
                (S::UNPROCESSABLE_ENTITY, "invalid-hero", "The pixel-cloth network cannot be used")
            }
            Self::UnknownScan => (S::NOT_FOUND, "unknown-scan", "There is no body of this scan"),
            Self::NotABody => (S::UNPROCESSABLE_ENTITY, "not-a-body", "The mesh is no scan of a body"),
            Self::UnknownKind => {
                (S::UNPROCESSABLE_ENTITY, "unknown-kind", "The method does not know this kind of garment")
            }
            Self::NoPixelCloth => {
                (S::UNPROCESSABLE_ENTITY, "no-pixel-cloth", "There is no pixel-cloth network of this garment")
            }
            Self::NotSimulated => {
                (S::UNPROCESSABLE_ENTITY, "not-simulated", "There is no simulation of this drape")
            }
            Self::NoUvs => {
                (S::UNPROCESSABLE_ENTITY, "no-uvs", "A garment has no UVs that a normal map could use")
            }
            Self::SinglePoseOnly => {
                (S::UNPROCESSABLE_ENTITY, "single-pose-only", "Normal maps are made of single poses")
            }
            Self::MeasurementOutOfRange => {
                (S::UNPROCESSABLE_ENTITY, "measurement-out-of-range", "A measurement is out of range")
            }
            Self::MeasurementUnits => {
                (S::UNPROCESSABLE_ENTITY, "measurement-units", "A measurement looks to be in the wrong unit")
            }
            Self::UnreachableMeasurements => {
                (S::UNPROCESSABLE_ENTITY, "unreachable-measurements", "No body has these measurements")
            }
            Self::Internal => (S::INTERNAL_SERVER_ERROR, "internal", "The server failed"),
            Self::Overloaded => (S::SERVICE_UNAVAILABLE, "overloaded", "The server is busy"),
            Self::Stopping => (S::SERVICE_UNAVAILABLE, "stopping", "The server is stopping"),
        }
    }

    /// The stable name.
    pub fn name(self) -> &'static str {
        self.entry().1
    }
}

/// A failure that a client is told about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ApiError {
    /// What went wrong, for programs.
    pub code: Code,
    /// What went wrong, for a person.
    pub detail: String,
    /// JSON pointer into the request, where one applies.
    pub pointer: Option<String>,
}

impl ApiError {
    /// An error without a pointer.
    pub fn new(code: Code, detail: impl Into<String>) -> Self {
        Self { code, detail: detail.into(), pointer: None }
    }

    /// The same error, pointing at a part of the request.
    #[must_use]
    pub fn at(mut self, pointer: impl Into<String>) -> Self {
        self.pointer = Some(pointer.into());
        self
    }

    /// The same error, its pointer (if any) seen from further out.
    #[must_use]
    pub fn under(mut self, prefix: &str) -> Self {
        self.pointer = Some(format!("{prefix}{}", self.pointer.unwrap_or_default()));
        self
    }

    /// A failure of ours: the cause goes to the log, not to the client.
    pub fn internal(cause: impl fmt::Display) -> Self {
        tracing::error!(%cause, "internal error");
        Self::new(
            Code::Internal,
            "The request could not be served; the log has the cause under the request id.",
        )
    }
}

impl fmt::Display for ApiError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.pointer {
            Some(pointer) => write!(f, "{} ({} at {pointer})", self.detail, self.code.name()),
            None => write!(f, "{} ({})", self.detail, self.code.name()),
        }
    }
}

impl std::error::Error for ApiError {}

/// The body of an error answer.
#[derive(Serialize)]
struct Problem<'a> {
    r#type: String,
    title: &'a str,
    status: u16,
    detail: &'a str,
    code: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pointer: Option<&'a str>,
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let (status, code, title) = self.code.entry();
        let problem = Problem {
            r#type: format!("urn:toile:problem:{code}"),
            title,
            status: status.as_u16(),
            detail: &self.detail,
            code,
            pointer: self.pointer.as_deref(),
        };
        let mut response = (status, Json(problem)).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        if status == StatusCode::SERVICE_UNAVAILABLE {
            headers.insert(header::RETRY_AFTER, HeaderValue::from(RETRY_AFTER_SECONDS));
        }
        response
    }
}
