//! Checked graphs and their sessions; one set per worker thread.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ort::environment::Environment;
use ort::session::builder::GraphOptimizationLevel;
use ort::session::{Session, SessionInputValue};
use ort::value::TensorRef as OrtTensorRef;
use sha2::{Digest, Sha256};
use thiserror::Error;
use toile_drape::network::{NetworkError, Networks, Tensor, TensorRef};

use crate::environment::{LibraryError, start};
use crate::manifest::{Extent, FORMAT, Graph, Manifest, Port};

/// Methods that come with networks, and whether these have a part in the static pass.
const METHODS: [(&str, bool); 4] =
    [("deepsd", true), ("deepsd-concat", true), ("garnet", false), ("pixel_cloth", false)];

/// The networks on disk cannot be used.
#[derive(Debug, Error)]
pub enum LoadError {
    /// ONNX Runtime itself.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// A file cannot be read.
    #[error("{path}: {reason}")]
    Read {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// A manifest promises something else than the file holds.
    #[error("{path} does not match its manifest: {reason}; run `make export`")]
    Mismatch {
        /// Which file.
        path: PathBuf,
        /// What differs.
        reason: String,
    },
}

/// A graph's file, read and checked once.
struct Checked {
    graph: Graph,
    bytes: Vec<u8>,
}

/// Every graph with a session of its own: give each worker thread one (`clone_sessions`).
pub struct OnnxNetworks {
    environment: Environment,
    files: Arc<BTreeMap<String, Checked>>,
    sessions: BTreeMap<String, Session>,
    fingerprint: String,
}

impl OnnxNetworks {
    /// Reads the manifests under `artifacts`, checks every file's hash and ports, and opens sessions.
    ///
    /// # Errors
    /// When the library, a manifest or a graph is missing, unreadable or not what its manifest says.
    pub fn load(artifacts: &Path, library: &Path) -> Result<Self, LoadError> {
        let environment = start(library)?;
        let mut files = BTreeMap::new();
        let mut hash = Sha256::new();
        for (method, in_static_pass) in METHODS {
            let folder = artifacts.join(method);
            let manifest = read_manifest(&folder.join("manifest.json"))?;
            for graph in manifest.graphs {
                if in_static_pass {
                    hash.update(&graph.sha256);
                }
                let bytes = read_checked(&folder.join(&graph.file), &graph)?;
                files.insert(format!("{method}/{}", graph.name), Checked { graph, bytes });
            }
        }
        let fingerprint = hex(&hash.finalize());
        let files = Arc::new(files);
        let sessions = open_all(&environment, &files, artifacts)?;
        Ok(Self { environment, files, sessions, fingerprint })
    }

    /// The same networks with sessions of their own, for another thread.
    ///
    /// # Errors
    /// When the runtime cannot open a session.
    pub fn clone_sessions(&self) -> Result<Self, LoadError> {
        Ok(Self {
            environment: self.environment.clone(),
            files: Arc::clone(&self.files),
            sessions: open_all(&self.environment, &self.files, Path::new("artifacts"))?,
            fingerprint: self.fingerprint.clone(),
        })
    }
}

fn read(path: &Path) -> Result<Vec<u8>, LoadError> {
    std::fs::read(path).map_err(|e| LoadError::Read { path: path.to_owned(), reason: e.to_string() })
}

fn read_manifest(path: &Path) -> Result<Manifest, LoadError> {
    let mismatch = |reason: String| LoadError::Mismatch { path: path.to_owned(), reason };
    let manifest: Manifest = serde_json::from_slice(&read(path)?).map_err(|e| mismatch(e.to_string()))?;
    let folder = path.parent().and_then(Path::file_name);
    if folder.is_none_or(|f| f != manifest.method.as_str()) {
        return Err(mismatch(format!("it is of method {}", manifest.method)));
    }
    if manifest.format != FORMAT {
        return Err(mismatch(format!("format {} instead of {FORMAT}", manifest.format)));
    }
    Ok(manifest)
}

fn read_checked(path: &Path, graph: &Graph) -> Result<Vec<u8>, LoadError> {
    let bytes = read(path)?;
    let found = hex(&Sha256::digest(&bytes));
    if found == graph.sha256 {
        return Ok(bytes);
    }
    let reason = format!("its SHA-256 is {found}, not {}", graph.sha256);
    Err(LoadError::Mismatch { path: path.to_owned(), reason })
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

fn open_all(
    environment: &Environment,
    files: &BTreeMap<String, Checked>,
    artifacts: &Path,
) -> Result<BTreeMap<String, Session>, LoadError> {
    files
        .iter()
        .map(|(name, checked)| {
            let path = || artifacts.join(name);
            let session = open(environment, &checked.bytes)
                .map_err(|reason| LoadError::Mismatch { path: path(), reason })?;
            check_ports(&session, &checked.graph)
                .map_err(|reason| LoadError::Mismatch { path: path(), reason })?;
            Ok((name.clone(), session))
        })
        .collect()
}

/// One thread a session, no spinning, no memory pattern: workers are the parallelism, and shapes vary.
fn open(environment: &Environment, bytes: &[u8]) -> Result<Session, String> {
    let text = |e: &dyn std::fmt::Display| e.to_string();
    Session::builder(environment)
        .map_err(|e| text(&e))?
        .with_optimization_level(GraphOptimizationLevel::Level3)
        .map_err(|e| text(&e))?
        .with_intra_threads(1)
        .map_err(|e| text(&e))?
        .with_intra_op_spinning(false)
        .map_err(|e| text(&e))?
        .with_memory_pattern(false)
        .map_err(|e| text(&e))?
        .commit_from_memory(bytes)
        .map_err(|e| text(&e))
}

fn check_ports(session: &Session, graph: &Graph) -> Result<(), String> {
    let names = |ports: &[Port]| ports.iter().map(|p| p.name.clone()).collect::<Vec<_>>();
    let found: Vec<String> = session.inputs().iter().map(|i| i.name().to_owned()).collect();
    if found != names(&graph.inputs) {
        return Err(format!("inputs are {found:?}"));
    }
    let found: Vec<String> = session.outputs().iter().map(|o| o.name().to_owned()).collect();
    if found != names(&graph.outputs) {
        return Err(format!("outputs are {found:?}"));
    }
    Ok(())
}

impl Networks for OnnxNetworks {
    fn run(&mut self, graph: &str, inputs: &[(&str, TensorRef<'_>)]) -> Result<Vec<Tensor>, NetworkError> {
        let failed = |reason: String| NetworkError { graph: graph.to_owned(), reason };
        let checked = self.files.get(graph).ok_or_else(|| failed("there is no such graph".to_owned()))?;
        let session = self.sessions.get_mut(graph).ok_or_else(|| failed("it has no session".to_owned()))?;
        check_inputs(&checked.graph, inputs).map_err(&failed)?;
        let values = inputs
            .iter()
            .map(|(name, tensor)| Ok((*name, value(tensor)?)))
            .collect::<Result<Vec<_>, ort::Error>>()
            .map_err(|e| failed(e.to_string()))?;
        let outputs = session.run(values).map_err(|e| failed(e.to_string()))?;
        checked
            .graph
            .outputs
            .iter()
            .map(|port| {
                let value =
                    outputs.get(&port.name).ok_or_else(|| failed(format!("no output {}", port.name)))?;
                let (shape, values) = value.try_extract_tensor::<f32>().map_err(|e| failed(e.to_string()))?;
                let shape = shape.iter().map(|&d| usize::try_from(d).unwrap_or(0)).collect();
                Ok(Tensor { shape, values: values.to_vec() })
            })
            .collect()
    }

    fn fingerprint(&self) -> &str {
        &self.fingerprint
    }
}

fn value<'a>(tensor: &TensorRef<'a>) -> Result<SessionInputValue<'a>, ort::Error> {
    Ok(match *tensor {
        TensorRef::F32(shape, values) => OrtTensorRef::from_array_view((shape, values))?.into(),
        TensorRef::I64(shape, values) => OrtTensorRef::from_array_view((shape, values))?.into(),
    })
}

/// Names, types and extents against the manifest; the same named extent must agree over all inputs.
fn check_inputs(graph: &Graph, inputs: &[(&str, TensorRef<'_>)]) -> Result<(), String> {
    if inputs.len() != graph.inputs.len() {
        return Err(format!("{} inputs instead of {}", inputs.len(), graph.inputs.len()));
    }
    let mut named: BTreeMap<&str, usize> = BTreeMap::new();
    for (port, (name, tensor)) in graph.inputs.iter().zip(inputs) {
        let (shape, dtype) = match tensor {
            TensorRef::F32(shape, _) => (*shape, "float32"),
            TensorRef::I64(shape, _) => (*shape, "int64"),
        };
        if port.name != *name || port.dtype != dtype || port.shape.len() != shape.len() {
            return Err(format!(
                "input {name} is not {} {} of rank {}",
                port.dtype,
                port.name,
                port.shape.len()
            ));
        }
        for (extent, &found) in port.shape.iter().zip(shape) {
            let expected = match extent {
                Extent::Fixed(size) => *size,
                Extent::Named(label) => *named.entry(label).or_insert(found),
            };
            if expected != found {
                return Err(format!("input {name} has extent {found} where {expected} is due"));
            }
        }
    }
    Ok(())
}
