//! What an export promises: graphs with their files, hashes and ports.

use serde::Deserialize;

/// The format this build reads.
pub const FORMAT: &str = "toile-networks/1";

/// `manifest.json` of a method.
#[derive(Clone, Debug, Deserialize)]
pub struct Manifest {
    /// Must be [`FORMAT`].
    pub format: String,
    /// Name of the method.
    pub method: String,
    /// Exported graphs.
    pub graphs: Vec<Graph>,
}

/// One exported graph.
#[derive(Clone, Debug, Deserialize)]
pub struct Graph {
    /// Name within the method.
    pub name: String,
    /// File beside the manifest.
    pub file: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// Inputs in order.
    pub inputs: Vec<Port>,
    /// Outputs in order.
    pub outputs: Vec<Port>,
}

/// An input or output.
#[derive(Clone, Debug, Deserialize)]
pub struct Port {
    /// Name in the graph.
    pub name: String,
    /// Extents; a name stands for one that varies.
    pub shape: Vec<Extent>,
    /// `float32` or `int64`.
    pub dtype: String,
}

/// Extent of one axis.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(untagged)]
pub enum Extent {
    /// Always this.
    Fixed(usize),
    /// Varies; the same name means the same extent within a run.
    Named(String),
}
