//! The demo outfits that come with the service, loaded into a data directory once.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;

use crate::errors::ApiError;
use crate::files::write_atomically;
use crate::server_timing::ServerTiming;
use crate::store::{Store, StoreError};
use crate::upload::{Kinds, Metadata, Upload};
use crate::wardrobe::Wardrobe;

/// Why a demo outfit could not be loaded.
#[derive(Debug, Error)]
pub enum GalleryError {
    /// The gallery cannot be read.
    #[error("{path}: {cause}")]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: std::io::Error,
    },
    /// `gallery.json` is not what it should be.
    #[error("gallery.json: {0}")]
    Json(#[from] serde_json::Error),
    /// An outfit of the gallery is refused.
    #[error("{file}: {cause}")]
    Outfit {
        /// The file.
        file: String,
        /// Why.
        cause: ApiError,
    },
    /// The data directory.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// One line of `gallery.json`; what it says beyond this is for people.
#[derive(Clone, Debug, Deserialize)]
pub struct Exhibit {
    /// File name within the gallery.
    pub file: String,
    /// For people.
    pub name: String,
    /// Garment names, innermost first.
    #[serde(default)]
    pub layers: Vec<String>,
    /// Kinds of garments by their names.
    #[serde(default)]
    pub kinds: Kinds,
    /// Whether this is the outfit that `toile bench` measures.
    #[serde(default)]
    pub benchmark: bool,
}

/// What the gallery holds; nothing where there is none.
///
/// # Errors
/// When `gallery.json` cannot be read.
pub fn exhibits(gallery: &Path) -> Result<Vec<Exhibit>, GalleryError> {
    let path = gallery.join("gallery.json");
    if !path.exists() {
        return Ok(Vec::new());
    }
    Ok(serde_json::from_slice(&read(&path)?)?)
}

/// What the gallery around a file says of it; nothing where it is in none.
///
/// # Errors
/// When `gallery.json` cannot be read.
pub fn exhibit_at(file: &Path) -> Result<Option<Exhibit>, GalleryError> {
    let Some(folder) = file.parent() else { return Ok(None) };
    let is_it = |exhibit: &Exhibit| file.file_name().is_some_and(|name| *name == *exhibit.file);
    Ok(exhibits(folder)?.into_iter().find(is_it))
}

/// Loads every demo outfit that this data directory has not had yet. One that was deleted stays deleted;
/// one whose file has changed replaces what it was.
///
/// # Errors
/// At the first outfit that cannot be loaded.
pub async fn load(gallery: &Path, wardrobe: &Wardrobe, store: &Store) -> Result<(), GalleryError> {
    for exhibit in exhibits(gallery)? {
        let refused = |cause| GalleryError::Outfit { file: exhibit.file.clone(), cause };
        let file = read(&gallery.join(&exhibit.file))?;
        let upload = exhibit.upload();
        let id = upload.id(&file)?;
        let known = store.gallery_outfit(&exhibit.file).await?;
        if known.as_ref() == Some(&id) {
            continue;
        }
        wardrobe.add(file.into(), upload, &mut ServerTiming::default()).await.map_err(refused)?;
        // Nobody has asked for it yet.
        wardrobe.set_aside(&id).await;
        copy_picture(gallery, &exhibit, &id, store)?;
        if let Some(previous) = known {
            wardrobe.remove(&previous).await.map_err(refused)?;
        }
        store.remember_gallery_outfit(&exhibit.file, &id).await?;
    }
    Ok(())
}

impl Exhibit {
    /// How the exhibit would be uploaded.
    pub fn upload(&self) -> Upload {
        let metadata = Metadata {
            name: Some(self.name.clone()),
            layers: self.layers.clone(),
            kinds: self.kinds.clone(),
            ..Default::default()
        };
        Upload { file_name: Some(self.file.clone()), metadata }
    }
}

fn copy_picture(gallery: &Path, exhibit: &Exhibit, id: &str, store: &Store) -> Result<(), GalleryError> {
    let picture = gallery.join(&exhibit.file).with_extension("png");
    if !picture.exists() {
        return Ok(());
    }
    write_atomically(&store.data().thumbnail(id), &read(&picture)?).map_err(StoreError::from)?;
    Ok(())
}

fn read(path: &Path) -> Result<Vec<u8>, GalleryError> {
    std::fs::read(path).map_err(|cause| GalleryError::File { path: path.to_owned(), cause })
}
