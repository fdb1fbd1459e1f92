//! End-to-end tests: the built binary, over HTTP and by its command line.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod bad_uploads;
mod bakes;
mod bodies;
mod command_line;
mod connections;
mod drape_refusals;
mod drapes;
mod gallery;
mod garnet;
mod normal_map;
mod outfits;
mod persistence;
mod pixel_cloth;
mod service;
mod simulation;
