//! What the binary needs beside itself, read once: the body, the poses and where the networks lie.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use thiserror::Error;
use toile_drape::error::DrapeError;
use toile_drape::hero::Hero;
use toile_drape::recent::Recent;
use toile_drape::studio::Studio;
use toile_geometry::body::{Body, BodyError, BodyShape, ShapedBody};
use toile_geometry::poses::{PoseLibrary, PoseLibraryError};
use toile_gltf::BodyTemplate;

use crate::hash::short_hash;
use crate::simulations::{SimulationError, Simulations};

/// Scans whose bodies are kept, a sixth of a megabyte each.
const SCANS: usize = 256;

/// Why the artifacts cannot be used.
#[derive(Debug, Error)]
pub enum AssetError {
    /// A file cannot be read.
    #[error("{path}: {cause}")]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: std::io::Error,
    },
    /// The body.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// The body again.
    #[error(transparent)]
    Studio(#[from] DrapeError),
    /// The poses.
    #[error(transparent)]
    Poses(#[from] PoseLibraryError),
    /// Simulated drapes.
    #[error(transparent)]
    Simulations(#[from] SimulationError),
}

/// Immutable, shared by everything.
pub struct Assets {
    /// The body and what is derived from it.
    pub studio: Arc<Studio>,
    /// The body that outfits are fitted on unless they say otherwise.
    pub reference: Arc<ShapedBody>,
    /// Preset poses and motions.
    pub poses: PoseLibrary,
    /// Bodies of recent scans by their ids: in memory alone, because they are of people.
    pub scans: Recent<String, BodyShape>,
    /// Simulated drapes of demo outfits.
    pub simulations: Simulations,
    /// What all GLBs with a body have in common.
    pub body_template: BodyTemplate,
    /// Content hash of the body, part of the address of every static pass.
    pub body_hash: String,
}

impl Assets {
    /// Reads the artifacts in `folder`.
    ///
    /// # Errors
    /// When something is missing or not as it should be.
    pub fn load(folder: &Path) -> Result<Self, AssetError> {
        let bytes = read(&folder.join("body.safetensors"))?;
        let body = Body::from_safetensors(&bytes)?;
        let poses = PoseLibrary::from_json(&read(&folder.join("poses.json"))?, &body)?;
        let heroes = heroes(&folder.join("pixel_cloth"), body.vertex_count())?;
        let body_hash = short_hash([bytes.as_slice()]);
        let body_template = BodyTemplate::new(body.vertex_count(), body.triangles());
        let reference = Arc::new(body.shape(&BodyShape::default()));
        let mut assets = Self {
            studio: Studio::new(body, heroes)?,
            reference,
            poses,
            simulations: Simulations::default(),
            body_template,
            body_hash,
            scans: Recent::new(SCANS),
        };
        assets.simulations = Simulations::load(folder, &assets)?;
        Ok(assets)
    }

    /// The body.
    pub fn body(&self) -> &Body {
        &self.studio.body
    }

    /// The body of a shape.
    pub fn shaped(&self, shape: &BodyShape) -> Arc<ShapedBody> {
        if *shape == self.reference.shape {
            Arc::clone(&self.reference)
        } else {
            self.studio.shapes.get(shape.clone(), |s| self.body().shape(s))
        }
    }
}

/// The garments with a pixel-cloth network: the files in `folder`.
fn heroes(folder: &Path, body_vertices: usize) -> Result<Vec<Hero>, AssetError> {
    let failed = |cause| AssetError::File { path: folder.to_owned(), cause };
    let entries =
        std::fs::read_dir(folder).map_err(failed)?.collect::<Result<Vec<_>, _>>().map_err(failed)?;
    let mut paths: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "safetensors"));
    paths.sort();
    let hero = |path: &PathBuf| Ok(Hero::from_safetensors(&read(path)?, body_vertices)?);
    paths.iter().map(hero).collect()
}

fn read(path: &Path) -> Result<Vec<u8>, AssetError> {
    std::fs::read(path).map_err(|cause| AssetError::File { path: path.to_owned(), cause })
}
