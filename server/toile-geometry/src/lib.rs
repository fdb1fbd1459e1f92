//! Meshes, skeletons, the body and its measurements, skinning, nearest points, collision.
//!
//! No I/O, no async. Metres, glTF axes (Y up, the body faces +Z).

pub mod body;
pub mod crossings;
pub mod measurements;
pub mod mesh;
pub mod nearest;
pub mod normals;
pub mod pose;
pub mod poses;
pub mod scan;
pub mod skeleton;
pub mod skinning;
