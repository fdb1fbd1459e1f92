//! What Toile does, without HTTP and without a network runtime: outfits, static passes, drapes.

pub mod arm_room;
pub mod bake;
pub mod binding;
pub mod contact;
pub mod dual_quaternions;
pub mod error;
pub mod evaluation;
pub mod features;
pub mod fitted;
pub mod folds;
pub mod garnet_tables;
pub mod graph;
pub mod hero;
pub mod layer_contact;
pub mod layers;
pub mod methods;
pub mod network;
pub mod ornaments;
pub mod outfit;
pub mod outfit_build;
pub mod outfit_codec;
pub mod pipeline;
pub mod posed_body;
pub mod push_out;
pub mod recent;
pub mod reference;
pub mod refine;
pub mod repair;
pub mod resolve;
pub mod shape;
pub mod skinning;
pub mod static_codec;
pub mod static_pass;
pub mod stretch;
pub mod studio;
#[cfg(test)]
mod test_meshes;
