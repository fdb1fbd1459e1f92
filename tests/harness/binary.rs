//! The binary under test.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The repository's root.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the tests lie in the repository").to_owned()
}

/// Path of the binary: `TOILE_BIN`, or a release build made now.
pub(crate) fn path() -> &'static Path {
    static PATH: OnceLock<PathBuf> = OnceLock::new();
    PATH.get_or_init(|| {
        if let Some(stated) = std::env::var_os("TOILE_BIN") {
            let path = repository().join(stated);
            assert!(path.is_file(), "TOILE_BIN: there is no {}", path.display());
            return path;
        }
        let mut build = Command::new(env!("CARGO"));
        build.args(["build", "--release", "--package", "toile-server"]).current_dir(repository());
        assert!(build.status().expect("cargo runs").success(), "the binary does not build");
        let target =
            std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| repository().join("target"), PathBuf::from);
        target.join("release/toile")
    })
}

/// What a run of the command line left.
#[derive(Clone, Debug)]
pub struct Output {
    /// Exit code.
    pub code: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

/// Runs `toile` in the repository.
pub fn toile<S: AsRef<OsStr>>(arguments: &[S]) -> Output {
    toile_in(&repository(), arguments)
}

/// Runs `toile` in a folder.
pub fn toile_in<S: AsRef<OsStr>>(folder: &Path, arguments: &[S]) -> Output {
    let output = Command::new(path()).args(arguments).current_dir(folder).output().expect("toile runs");
    Output {
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}
