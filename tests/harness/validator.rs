//! The Khronos glTF validator.

use std::process::Command;
use std::sync::OnceLock;

use crate::repository;

/// Asserts that the validator has neither an error nor a warning about a GLB.
#[track_caller]
pub fn assert_valid_glb(bytes: &[u8]) {
    install();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("answer.glb");
    std::fs::write(&path, bytes).expect("a temporary file");
    let mut validate = Command::new("node");
    validate.arg(repository().join("tests/validator/validate.js")).arg(&path);
    let output = validate.output().expect("node runs");
    assert!(output.status.success(), "not valid glTF:\n{}", String::from_utf8_lossy(&output.stderr));
}

fn install() {
    static INSTALLED: OnceLock<()> = OnceLock::new();
    INSTALLED.get_or_init(|| {
        let folder = repository().join("tests/validator");
        if !folder.join("node_modules").is_dir() {
            let mut install = Command::new("npm");
            install.args(["ci", "--no-audit", "--no-fund"]).current_dir(&folder);
            assert!(install.status().expect("npm runs").success(), "the glTF validator cannot be installed");
        }
    });
}
