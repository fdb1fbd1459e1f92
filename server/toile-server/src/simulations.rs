//! Simulated drapes of demo outfits, to hold the methods against: a file of `artifacts/simulated` an outfit.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::Vec3;
use safetensors::tensor::{Dtype, SafeTensors};
use serde::{Deserialize, Serialize};
use thiserror::Error;
use toile_drape::methods::SimulatedDrape;

use crate::assets::Assets;
use crate::errors::ApiError;
use crate::gallery::{GalleryError, exhibits};
use crate::requests::{BodyRequest, DrapeBody, PoseRequest};

/// Why kept simulations cannot be used.
#[derive(Debug, Error)]
pub enum SimulationError {
    /// The demo outfits that they are of.
    #[error(transparent)]
    Gallery(Box<GalleryError>),
    /// A file cannot be read.
    #[error("{path}: {cause}")]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: std::io::Error,
    },
    /// A file is not what it should be.
    #[error("{path}: {cause}")]
    Content {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: String,
    },
}

/// What an outfit was simulated on.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Simulated {
    body: BodyRequest,
    pose: PoseRequest,
}

/// Of one outfit.
#[derive(Debug, Default)]
pub struct Kept {
    /// What it was simulated on.
    pub on: Vec<Simulated>,
    /// How it came to rest there, in the same order.
    pub drapes: Vec<SimulatedDrape>,
}

/// By the ids of the outfits.
#[derive(Debug, Default)]
pub struct Simulations(HashMap<String, Kept>);

impl Simulations {
    /// Reads the simulations beside the gallery in `artifacts`; none where there are none.
    ///
    /// # Errors
    /// When one cannot be read.
    pub fn load(artifacts: &Path, assets: &Assets) -> Result<Self, SimulationError> {
        let gallery = artifacts.join("gallery");
        let shown = exhibits(&gallery).map_err(|cause| SimulationError::Gallery(Box::new(cause)))?;
        let mut found = HashMap::new();
        for exhibit in shown {
            let path = artifacts.join("simulated").join(&exhibit.file).with_extension("safetensors");
            if !path.exists() {
                continue;
            }
            let content = |cause: String| SimulationError::Content { path: path.clone(), cause };
            let outfit = read(&gallery.join(&exhibit.file))?;
            let id = exhibit.upload().id(&outfit).map_err(|error| content(error.to_string()))?;
            found.insert(id, Kept::read(&read(&path)?, assets).map_err(content)?);
        }
        Ok(Self(found))
    }

    /// Of the outfit of an id.
    pub fn of(&self, id: &str) -> Option<&Kept> {
        self.0.get(id)
    }
}

impl Kept {
    /// `cloth`, float32 (D, N, 3), and in the metadata what each was simulated on, as `drapes`.
    fn read(bytes: &[u8], assets: &Assets) -> Result<Self, String> {
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(|error| error.to_string())?;
        let about = header.metadata().as_ref().and_then(|about| about.get("drapes"));
        let on: Vec<Simulated> =
            serde_json::from_str(about.ok_or("no metadata `drapes`")?).map_err(|error| error.to_string())?;
        let file = SafeTensors::deserialize(bytes).map_err(|error| error.to_string())?;
        let cloth = file.tensor("cloth").map_err(|error| error.to_string())?;
        let &[count, vertices, 3] = cloth.shape() else { return Err("`cloth` is not (D, N, 3)".to_owned()) };
        if count != on.len() || vertices == 0 || cloth.dtype() != Dtype::F32 {
            return Err(format!("`cloth` is not {} drapes in float32", on.len()));
        }
        let numbers: Vec<f32> =
            cloth.data().as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let points: Vec<Vec3> = numbers.as_chunks::<3>().0.iter().map(|p| Vec3::from_array(*p)).collect();
        let drapes = on.iter().zip(points.chunks_exact(vertices));
        let drapes = drapes.map(|(on, cloth)| on.drape(cloth, assets)).collect::<Result<_, _>>();
        Ok(Self { drapes: drapes.map_err(|error| error.to_string())?, on })
    }
}

impl Simulated {
    fn drape(&self, cloth: &[Vec3], assets: &Assets) -> Result<SimulatedDrape, ApiError> {
        let request = DrapeBody::single("", Some(self.body.clone()), Some(self.pose.clone()));
        let motion = request.motion(assets)?;
        let pose = motion.poses.into_iter().next();
        let pose = pose.ok_or_else(|| ApiError::internal("a single pose"))?;
        Ok(SimulatedDrape { shape: motion.shape, pose, cloth: cloth.to_vec() })
    }
}

fn read(path: &Path) -> Result<Vec<u8>, SimulationError> {
    std::fs::read(path).map_err(|cause| SimulationError::File { path: path.to_owned(), cause })
}
