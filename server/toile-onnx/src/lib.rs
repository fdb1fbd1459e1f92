//! Runs exported networks in ONNX Runtime. The only crate that names `ort`.

mod environment;
mod manifest;
mod networks;

pub use environment::{LibraryError, start};
pub use networks::{LoadError, OnnxNetworks};
