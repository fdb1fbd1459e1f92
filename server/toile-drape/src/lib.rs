//! What Toile does, without HTTP and without a network runtime: outfits, static passes, drapes.

pub mod binding;
pub mod features;
pub mod graph;
pub mod network;
pub mod outfit;
pub mod outfit_build;
pub mod reference;
