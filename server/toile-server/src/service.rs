//! Everything that the routes and the command line work with, put together once.

use std::path::PathBuf;
use std::sync::Arc;

use thiserror::Error;
use toile_drape::network::Networks;
use toile_onnx::{LoadError, OnnxNetworks};

use crate::answers::Answers;
use crate::assets::{AssetError, Assets};
use crate::files::DataDir;
use crate::store::{Store, StoreError};
use crate::wardrobe::Wardrobe;
use crate::workers::Workers;

/// Where everything is and how much of it may be used.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Body, poses, networks, gallery.
    pub artifacts: PathBuf,
    /// ONNX Runtime.
    pub onnxruntime: PathBuf,
    /// Database and files.
    pub data: PathBuf,
    /// Threads that compute.
    pub workers: usize,
    /// Jobs that may wait.
    pub queue: usize,
    /// Bound on prepared outfits in memory, bytes.
    pub cache_bytes: u64,
    /// Bound on answers kept for a URL, bytes.
    pub answer_bytes: u64,
}

/// Why the service cannot start.
#[derive(Debug, Error)]
pub enum ServiceError {
    /// Body or poses.
    #[error("artifacts: {0}")]
    Assets(#[from] AssetError),
    /// Networks or their runtime.
    #[error("networks: {0}")]
    Networks(#[from] LoadError),
    /// The data directory.
    #[error("data directory {path}: {cause}")]
    Data {
        /// Where it is.
        path: PathBuf,
        /// What is wrong.
        cause: StoreError,
    },
    /// Threads.
    #[error("worker threads: {0}")]
    Threads(std::io::Error),
}

/// The service without HTTP.
pub struct Service {
    /// Body and poses.
    pub assets: Arc<Assets>,
    /// Rows and files.
    pub store: Store,
    /// Outfits ready to be draped.
    pub wardrobe: Wardrobe,
    /// Threads that compute.
    pub workers: Arc<Workers>,
    /// GLBs that a URL was given for.
    pub answers: Answers,
}

impl Service {
    /// Reads the artifacts, starts the workers and opens the data directory.
    ///
    /// # Errors
    /// When something is missing or not as it should be; the message says what.
    pub async fn open(settings: &Settings) -> Result<Self, ServiceError> {
        let assets = Arc::new(Assets::load(&settings.artifacts)?);
        let networks = load_networks(settings)?;
        let fingerprint = networks.first().map_or("", |networks| networks.fingerprint()).to_owned();
        let workers = Arc::new(Workers::start(networks, settings.queue).map_err(ServiceError::Threads)?);
        let failed = |cause| ServiceError::Data { path: settings.data.clone(), cause };
        let data = DataDir::open(&settings.data).map_err(|cause| failed(cause.into()))?;
        let store = Store::open(data).await.map_err(failed)?;
        let wardrobe = Wardrobe::new(
            Arc::clone(&assets),
            store.clone(),
            Arc::clone(&workers),
            fingerprint,
            settings.cache_bytes,
        );
        let swept = store.sweep(|id| wardrobe.static_key(id)).await.map_err(failed)?;
        tracing::debug!(swept, "removed files that no outfit refers to");
        Ok(Self { assets, store, wardrobe, workers, answers: Answers::new(settings.answer_bytes) })
    }

    /// Finishes what is queued and closes the database.
    pub async fn close(&self) {
        self.workers.stop();
        self.store.close().await;
    }
}

/// One set of sessions for each worker; the files are read and checked once.
fn load_networks(settings: &Settings) -> Result<Vec<OnnxNetworks>, LoadError> {
    let first = OnnxNetworks::load(&settings.artifacts, &settings.onnxruntime)?;
    let others = (1..settings.workers).map(|_| first.clone_sessions()).collect::<Result<Vec<_>, _>>()?;
    Ok(std::iter::once(first).chain(others).collect())
}
