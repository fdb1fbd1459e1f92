//! Errors of the crates below, in the words of the API. Each is translated here and nowhere else.

use toile_drape::error::DrapeError;
use toile_drape::normal_map::NormalMapError;
use toile_drape::outfit_build::OutfitError;
use toile_geometry::body::BodyError;
use toile_geometry::measurements::MeasurementError;
use toile_geometry::pose::PoseError;
use toile_geometry::scan::ScanError;
use toile_gltf::ReadError;

use crate::errors::{ApiError, Code};
use crate::requests::member;
use crate::store::StoreError;
use crate::workers::WorkError;

impl From<ReadError> for ApiError {
    fn from(error: ReadError) -> Self {
        let code = match &error {
            ReadError::UnsupportedMediaType => Code::UnsupportedMediaType,
            ReadError::NotAMesh(_) => Code::NotAMesh,
            ReadError::Truncated(_) => Code::Truncated,
            ReadError::ExternalUri { .. } => Code::ExternalUri,
            ReadError::UnsupportedExtension(_) => Code::UnsupportedExtension,
            ReadError::InvalidAccessor(_) => Code::InvalidAccessor,
            ReadError::NonFinitePosition(_) => Code::NonFinitePosition,
            ReadError::IndexOutOfRange { .. } => Code::IndexOutOfRange,
            ReadError::NoTriangles => Code::NoTriangles,
            ReadError::TooLarge { .. } => Code::TooLarge,
            ReadError::WrongUnits(_) => Code::WrongUnits,
        };
        Self::new(code, sentence(&error)).at("/file")
    }
}

impl From<OutfitError> for ApiError {
    fn from(error: OutfitError) -> Self {
        let code = match &error {
            OutfitError::NonFinitePosition { .. } => Code::NonFinitePosition,
            OutfitError::IndexOutOfRange { .. } => Code::IndexOutOfRange,
            OutfitError::NoTriangles => Code::NoTriangles,
            OutfitError::TooLarge { .. } => Code::TooLarge,
            OutfitError::WrongUnits { .. } => Code::WrongUnits,
            OutfitError::OffBody { .. } => Code::OffBody,
            OutfitError::InvalidLayers { .. } => Code::InvalidField,
        };
        let pointer = error.pointer().map_or_else(|| "/file".to_owned(), |inner| format!("/metadata{inner}"));
        Self::new(code, sentence(&error)).at(pointer)
    }
}

impl From<BodyError> for ApiError {
    fn from(error: BodyError) -> Self {
        let (code, name) = match &error {
            BodyError::UnknownPhenotype { name } => (Code::UnknownPhenotype, name),
            BodyError::PhenotypeOutOfRange { name, .. } => (Code::PhenotypeOutOfRange, name),
            BodyError::File(_) => return Self::internal(error),
        };
        Self::new(code, sentence(&error)).at(member(name))
    }
}

impl From<ScanError> for ApiError {
    fn from(error: ScanError) -> Self {
        let code = match &error {
            ScanError::NoTriangles => Code::NoTriangles,
            ScanError::Height { .. } => Code::WrongUnits,
            ScanError::TooCoarse { .. } | ScanError::NotABody { .. } => Code::NotABody,
        };
        Self::new(code, sentence(&error)).at("/file")
    }
}

impl From<PoseError> for ApiError {
    fn from(error: PoseError) -> Self {
        let (code, name) = match &error {
            PoseError::UnknownJoint { name } => (Code::UnknownJoint, name),
            PoseError::NonUnit { name, .. } => (Code::NonUnitQuaternion, name),
        };
        Self::new(code, sentence(&error)).at(member(name))
    }
}

impl From<MeasurementError> for ApiError {
    fn from(error: MeasurementError) -> Self {
        let (code, name) = match &error {
            MeasurementError::Unknown { name } => (Code::UnknownMeasurement, Some(name.clone())),
            MeasurementError::Twice { name } => (Code::InvalidField, Some(name.to_string())),
            MeasurementError::Units { name, .. } => (Code::MeasurementUnits, Some(name.to_string())),
            MeasurementError::OutOfRange { name, .. } => {
                (Code::MeasurementOutOfRange, Some(name.to_string()))
            }
            MeasurementError::Unreachable { misses } => {
                (Code::UnreachableMeasurements, misses.first().map(|miss| miss.name.to_string()))
            }
            MeasurementError::Phenotype(_) => (Code::Internal, None),
        };
        if let MeasurementError::Phenotype(error) = error {
            return error.into();
        }
        let described = Self::new(code, sentence(&error));
        match name {
            Some(name) => described.at(member(&name)),
            None => described,
        }
    }
}

impl From<DrapeError> for ApiError {
    fn from(error: DrapeError) -> Self {
        if let DrapeError::NoHero { .. } = error {
            let detail = format!("{} The method \"deepsd\" drapes any garment.", sentence(&error));
            return Self::new(Code::NoPixelCloth, detail).at("/output/method");
        }
        if let DrapeError::NotSimulated = error {
            let advice =
                "GET /v1/outfits/{id} lists in `simulated` what was; \"deepsd\" drapes any body in any pose.";
            return Self::new(Code::NotSimulated, format!("{} {advice}", sentence(&error)))
                .at("/output/method");
        }
        Self::internal(error)
    }
}

impl From<NormalMapError> for ApiError {
    fn from(error: NormalMapError) -> Self {
        let advice = "Upload the outfit with UVs that tell its places apart, or ask for the detail \"mesh\".";
        Self::new(Code::NoUvs, format!("{} {advice}", sentence(&error))).at("/output/detail")
    }
}

impl From<StoreError> for ApiError {
    fn from(error: StoreError) -> Self {
        Self::internal(error)
    }
}

impl From<WorkError> for ApiError {
    fn from(error: WorkError) -> Self {
        match error {
            WorkError::Full => {
                Self::new(Code::Overloaded, "Too many requests are waiting; try again shortly.")
            }
            WorkError::Stopping => Self::new(Code::Stopping, "The server is stopping; try another one."),
            WorkError::Panicked => Self::internal(error),
        }
    }
}

/// An error message as a sentence.
fn sentence(error: &impl std::fmt::Display) -> String {
    let message = error.to_string();
    let mut letters = message.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string()).unwrap_or_default();
    let end = if message.ends_with(['.', '?', '!']) { "" } else { "." };
    format!("{first}{}{end}", letters.as_str())
}
