//! Drives the built `toile` binary over HTTP and by its command line, for the end-to-end tests.

// A harness that cannot do its work should stop the test at once.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod answer;
mod binary;
mod glb;
mod multipart;
mod sample;
mod server;
mod validator;

pub use answer::Answer;
pub use binary::{Output, repository, toile, toile_in};
pub use glb::{Glb, glb_of_json};
pub use multipart::Form;
pub use sample::{Mesh, skirt};
pub use server::{Server, ServerOptions};
pub use validator::assert_valid_glb;
