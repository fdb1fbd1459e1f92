//! From the bytes of an upload to an outfit, the same way when it arrives and whenever it is read again.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use toile_drape::methods::GarmentKind;
use toile_drape::outfit::{Outfit, Report};
use toile_drape::outfit_build;
use toile_gltf::{Format, Hints, preflight, read};

use crate::assets::Assets;
use crate::errors::{ApiError, Code};
use crate::hash::short_hash;
use crate::requests::{BodyRequest, member};

/// Version of the way from bytes to id; part of every id.
const ID_VERSION: &[u8] = b"toile outfit 1";

/// Kinds of garments by the garments' names.
pub type Kinds = BTreeMap<String, GarmentKind>;

/// What the uploader states about the file.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Metadata {
    /// For people; the file's own name by default.
    pub name: Option<String>,
    /// Garment names, innermost first.
    pub layers: Vec<String>,
    /// Kinds of garments by their names, for the method that needs them.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub kinds: Kinds,
    /// The body in whose A-pose the outfit stands; the reference body by default.
    pub fitted_on: Option<BodyRequest>,
    /// `m`, `cm`, `mm` or `in`; detected by default.
    pub units: Option<String>,
    /// `y` or `z`; detected by default.
    pub up: Option<String>,
    /// What it is made of.
    pub material: Option<String>,
}

/// All that is needed, beside the bytes, to read an upload again.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Upload {
    /// Name of the file, if it had one.
    pub file_name: Option<String>,
    /// What was stated.
    pub metadata: Metadata,
}

impl Upload {
    /// The content address of this upload: the same bytes and metadata give the same id.
    pub fn id(&self, file: &[u8]) -> Result<String, serde_json::Error> {
        Ok(short_hash([ID_VERSION, file, &serde_json::to_vec(&self.metadata)?]))
    }

    /// Preflight, read, build.
    ///
    /// # Errors
    /// Why the upload is refused.
    pub fn read(&self, file: &[u8], assets: &Assets) -> Result<(Outfit, Report), ApiError> {
        let hints = self.metadata.hints()?;
        let format = Format::sniff(file, self.file_name.as_deref())?;
        preflight(file, format)?;
        let mut source = read(file, format, &hints, self.metadata.name.as_deref())?;
        source.name = source.name.filter(|name| !name.trim().is_empty()).or_else(|| self.stem());
        source.layers.clone_from(&self.metadata.layers);
        let fitted_on = assets.shaped(&self.fitted_on(assets)?);
        let (outfit, report) =
            outfit_build::build(source, &fitted_on.apose_vertices, assets.body().triangles())?;
        check_names(&self.metadata.kinds, &outfit).map_err(|error| error.under("/metadata/kinds"))?;
        Ok((outfit, report))
    }

    /// The body shape that the outfit is fitted on.
    ///
    /// # Errors
    /// When it is no body.
    pub fn fitted_on(&self, assets: &Assets) -> Result<toile_geometry::body::BodyShape, ApiError> {
        let stated = self.metadata.fitted_on.as_ref();
        if stated.is_some_and(BodyRequest::is_scan) {
            let detail = "An outfit outlives a scan; state the phenotypes that POST /v1/bodies found for it.";
            return Err(ApiError::new(Code::InvalidField, detail).at("/metadata/fitted_on/kind"));
        }
        stated
            .map_or_else(|| Ok(Default::default()), |body| body.shape(assets))
            .map_err(|e| e.under("/metadata/fitted_on"))
    }

    fn stem(&self) -> Option<String> {
        let stem = std::path::Path::new(self.file_name.as_deref()?).file_stem()?.to_string_lossy();
        (!stem.trim().is_empty()).then(|| stem.into_owned())
    }
}

/// Refuses kinds of garments that the outfit does not have.
///
/// # Errors
/// `invalid-field`, with a pointer to the first one.
pub fn check_names(kinds: &Kinds, outfit: &Outfit) -> Result<(), ApiError> {
    let names: Vec<&str> = outfit.garments.iter().map(|garment| garment.name.as_str()).collect();
    match kinds.keys().find(|name| !names.contains(&name.as_str())) {
        Some(name) => {
            let detail = format!("The outfit has no garment \"{name}\"; it has {}.", names.join(", "));
            Err(ApiError::new(Code::InvalidField, detail).at(member(name)))
        }
        None => Ok(()),
    }
}

/// What a file's metadata state about its units and its up-axis.
///
/// # Errors
/// `invalid-field` for units and axes that there are not.
pub fn hints(units: Option<&str>, up: Option<&str>) -> Result<Hints, ApiError> {
    let invalid = |field: &str| {
        let pointer = format!("/metadata/{field}");
        move |detail: String| ApiError::new(Code::InvalidField, detail).at(pointer)
    };
    Ok(Hints {
        units: units.map(str::parse).transpose().map_err(invalid("units"))?,
        up: up.map(str::parse).transpose().map_err(invalid("up"))?,
    })
}

impl Metadata {
    fn hints(&self) -> Result<Hints, ApiError> {
        hints(self.units.as_deref(), self.up.as_deref())
    }
}
