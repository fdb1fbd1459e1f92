//! The seam between draping and a network runtime.

use thiserror::Error;

/// A borrowed input tensor, row-major.
#[derive(Clone, Copy, Debug)]
pub enum TensorRef<'a> {
    /// 32-bit floats with their shape.
    F32(&'a [usize], &'a [f32]),
    /// 64-bit integers with their shape (gather indices).
    I64(&'a [usize], &'a [i64]),
}

/// An output tensor, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensor {
    /// Extent of every axis.
    pub shape: Vec<usize>,
    /// Values, the last axis fastest.
    pub values: Vec<f32>,
}

/// Why a network could not be run.
#[derive(Debug, Error)]
#[error("network {graph}: {reason}")]
pub struct NetworkError {
    /// Name of the exported graph, such as `deepsd/static`.
    pub graph: String,
    /// What the runtime said.
    pub reason: String,
}

/// Runs exported graphs. One per worker thread: running needs exclusive access.
pub trait Networks: Send {
    /// Runs `graph` (`<method>/<name>`, as in the manifest) on named inputs; outputs in manifest order.
    ///
    /// # Errors
    /// When there is no such graph, an input does not match the manifest, or the runtime fails.
    fn run(&mut self, graph: &str, inputs: &[(&str, TensorRef<'_>)]) -> Result<Vec<Tensor>, NetworkError>;

    /// SHA-256 over the networks of the static pass, part of the address of every static pass.
    fn fingerprint(&self) -> &str;
}
