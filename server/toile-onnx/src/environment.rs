//! ONNX Runtime's shared library and the one environment a process may have.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use ort::environment::Environment;
use thiserror::Error;

/// The shared library could not be used.
#[derive(Debug, Error)]
pub enum LibraryError {
    /// No such file.
    #[error("ONNX Runtime's shared library is not at {0}")]
    Missing(PathBuf),
    /// It does not load, or is too old.
    #[error("ONNX Runtime at {path} cannot be used: {reason}")]
    Unusable {
        /// Where it was looked for.
        path: PathBuf,
        /// What the loader said.
        reason: String,
    },
}

static ENVIRONMENT: Mutex<Option<Environment>> = Mutex::new(None);

/// Loads ONNX Runtime from `library`, once in a process; later calls get the same environment.
///
/// # Errors
/// When the library is missing (checked here, because the runtime would panic) or cannot be loaded.
pub fn start(library: &Path) -> Result<Environment, LibraryError> {
    let mut kept = ENVIRONMENT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(environment) = kept.as_ref() {
        return Ok(environment.clone());
    }
    if !library.is_file() {
        return Err(LibraryError::Missing(library.to_owned()));
    }
    let unusable = |reason: String| LibraryError::Unusable { path: library.to_owned(), reason };
    let builder = ort::init_from(library).map_err(|e| unusable(e.to_string()))?;
    let environment = builder.build().map_err(|e| unusable(e.to_string()))?;
    *kept = Some(environment.clone());
    Ok(environment)
}
