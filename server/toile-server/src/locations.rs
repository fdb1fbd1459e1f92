//! Where things are found when nobody says: next to the binary, or in the repository that it was built in.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// What could not be found, and how to get it.
#[derive(Debug, Error)]
pub enum LocationError {
    /// No folder of networks and body.
    #[error("no artifacts found (looked for {looked_for}); say where they are with --artifacts DIR")]
    Artifacts {
        /// Paths that were tried.
        looked_for: String,
    },
    /// No ONNX Runtime library.
    #[error(
        "no ONNX Runtime library found; run `make build`, or `pip install onnxruntime==1.31.1` and say where \
         libonnxruntime.so is with --onnxruntime PATH or ORT_DYLIB_PATH"
    )]
    OnnxRuntime,
    /// The library that was named is not there.
    #[error("there is no ONNX Runtime library at {0}")]
    NamedOnnxRuntime(PathBuf),
}

/// The folder of networks, body and poses.
///
/// # Errors
/// When there is none.
pub fn artifacts(stated: Option<PathBuf>) -> Result<PathBuf, LocationError> {
    let looked =
        |paths: &[PathBuf]| paths.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ");
    let candidates = stated.map_or_else(|| beside("model/artifacts", "artifacts"), |path| vec![path]);
    let found = candidates.iter().find(|path| path.join("body.safetensors").is_file()).cloned();
    found.ok_or_else(|| LocationError::Artifacts { looked_for: looked(&candidates) })
}

/// The folder of the built try-on page, if there is one.
pub fn web(stated: Option<PathBuf>) -> Option<PathBuf> {
    let candidates = stated.map_or_else(|| beside("web/dist", "web"), |path| vec![path]);
    candidates.into_iter().find(|path| path.join("index.html").is_file())
}

/// The ONNX Runtime library: as stated (flag or `ORT_DYLIB_PATH`), or out of the repository's virtual environment.
///
/// # Errors
/// When there is none.
pub fn onnxruntime(stated: Option<PathBuf>) -> Result<PathBuf, LocationError> {
    if let Some(path) = stated {
        return if path.is_file() { Ok(path) } else { Err(LocationError::NamedOnnxRuntime(path)) };
    }
    let beside_binary = binary_folder().into_iter().filter_map(|folder| library_in(&folder));
    let in_environments = roots().into_iter().filter_map(|root| {
        let pythons =
            entries(&root.join(".venv/lib")).into_iter().filter(|path| name(path).starts_with("python3"));
        pythons.filter_map(|python| library_in(&python.join("site-packages/onnxruntime/capi"))).next()
    });
    beside_binary.chain(in_environments).next().ok_or(LocationError::OnnxRuntime)
}

fn library_in(folder: &Path) -> Option<PathBuf> {
    entries(folder).into_iter().find(|path| name(path).starts_with("libonnxruntime.so"))
}

/// `in_repository` under every root, and `installed` beside the binary.
fn beside(in_repository: &str, installed: &str) -> Vec<PathBuf> {
    let installed = binary_folder().map(|folder| folder.join(installed));
    installed.into_iter().chain(roots().into_iter().map(|root| root.join(in_repository))).collect()
}

/// The working directory and the repository around the binary (`<root>/target/<profile>/toile`).
fn roots() -> Vec<PathBuf> {
    let repository = binary_folder().and_then(|folder| folder.ancestors().nth(2).map(Path::to_owned));
    std::env::current_dir().ok().into_iter().chain(repository).collect()
}

fn binary_folder() -> Option<PathBuf> {
    std::env::current_exe().ok()?.canonicalize().ok()?.parent().map(Path::to_owned)
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.sort();
    paths
}

fn name(path: &Path) -> &str {
    path.file_name().and_then(|name| name.to_str()).unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_named_library_that_is_missing_is_an_error_and_not_searched_for() {
        let error = onnxruntime(Some("/nowhere/libonnxruntime.so".into())).unwrap_err();
        assert!(error.to_string().contains("/nowhere/libonnxruntime.so"));
    }

    #[test]
    fn artifacts_need_a_body() {
        let folder = tempfile::tempdir().unwrap();
        assert!(artifacts(Some(folder.path().to_owned())).is_err());
        std::fs::write(folder.path().join("body.safetensors"), b"").unwrap();
        assert_eq!(artifacts(Some(folder.path().to_owned())).unwrap(), folder.path());
    }
}
