//! Python's numbers against Rust's, from the graph to posed cloth, through the shipped networks.

#![allow(clippy::unwrap_used, clippy::expect_used)]

mod deepsd;
mod garnet;
mod pixel_cloth;
mod support;
