//! The baked body: against Anny, against wrong files, measured and posed.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod anny_parity;
mod body_file;
mod measuring;
mod posing;
mod scanning;

use std::path::PathBuf;
use std::sync::OnceLock;

use toile_geometry::body::Body;

/// Bytes of a shipped artifact.
fn artifact(name: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../model/artifacts").join(name);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The shipped body, read once.
fn body() -> &'static Body {
    static BODY: OnceLock<Body> = OnceLock::new();
    BODY.get_or_init(|| Body::from_safetensors(&artifact("body.safetensors")).unwrap())
}
