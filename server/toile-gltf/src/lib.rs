//! Reads uploaded outfits (GLB, self-contained glTF, OBJ) and writes drapes as GLB.
//!
//! Uploads are hostile: everything is bounds-checked and capped before it is allocated, no reference to
//! another file is followed, and no input may panic.

mod read;
mod write;

pub use crate::read::{
    Format, Hints, MAX_BYTES, MAX_TRIANGLES, MAX_VERTICES, ReadError, Units, Up, preflight, read,
};
pub use crate::write::{
    BodyTemplate, FrameView, OutfitTemplate, Relief, Scene, WriteError, vertex_strain, write_body,
    write_drape, write_relief, write_rest,
};
