//! The only crate that names ort.
