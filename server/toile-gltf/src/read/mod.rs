//! Reading uploads: framing, document, meshes, materials, units.

mod accessor;
mod container;
mod document;
mod error;
mod format;
mod material;
mod mesh;
mod node;
mod obj;
mod picture;
mod units;

use toile_drape::outfit::{Material, RawMesh, Report};
use toile_drape::outfit_build::OutfitSource;

use self::document::Document;
pub use self::error::ReadError;
pub use self::format::Format;
pub use self::units::{Hints, Units, Up};

/// Largest file, bytes.
pub const MAX_BYTES: usize = 64 * 1024 * 1024;
/// Most vertices over all meshes, counted as drawn.
pub const MAX_VERTICES: usize = 200_000;
/// Most triangles over all meshes.
pub const MAX_TRIANGLES: usize = 400_000;

/// Checks size, framing, references, extensions, the node tree and counts without reading any mesh.
///
/// # Errors
/// The first reason to refuse the file.
pub fn preflight(bytes: &[u8], format: Format) -> Result<(), ReadError> {
    check_size(bytes)?;
    match format {
        Format::Obj => Ok(()),
        Format::Glb | Format::Gltf => Document::open(bytes, format).map(drop),
    }
}

/// Reads an upload into meshes in metres and glTF axes. `name` wins over the name of the file's scene.
///
/// Skins and morph targets are ignored: what is read is the rest pose.
///
/// # Errors
/// The first reason to refuse the file.
pub fn read(
    bytes: &[u8],
    format: Format,
    hints: &Hints,
    name: Option<&str>,
) -> Result<OutfitSource, ReadError> {
    check_size(bytes)?;
    let mut contents = match format {
        Format::Obj => obj::read(bytes)?,
        Format::Glb | Format::Gltf => read_gltf(bytes, format)?,
    };
    if contents.meshes.is_empty() {
        return Err(ReadError::NoTriangles);
    }
    let mut report = Report { notes: contents.notes, ..Report::default() };
    units::normalise(&mut contents.meshes, hints, &mut report)?;
    let name = name.map(str::to_owned).or(contents.name).filter(|name| !name.trim().is_empty());
    let (meshes, materials) = (contents.meshes, contents.materials);
    Ok(OutfitSource { name, meshes, materials, layers: Vec::new(), report })
}

/// What a reader finds, in the file's own units and axes.
#[derive(Debug, Default)]
struct Contents {
    name: Option<String>,
    meshes: Vec<RawMesh>,
    materials: Vec<Material>,
    notes: Vec<String>,
}

fn read_gltf(bytes: &[u8], format: Format) -> Result<Contents, ReadError> {
    let document = Document::open(bytes, format)?.with_buffers()?;
    let meshes = mesh::read_all(&document)?;
    let mut notes = Vec::new();
    let materials = material::read_used(&document, &meshes, &mut notes)?;
    if document.root.nodes.iter().any(|node| node.skin.is_some()) {
        notes.push("The file's skeleton was ignored; its rest pose was taken.".to_owned());
    }
    Ok(Contents { name: document.scene_name(), meshes, materials, notes })
}

fn check_size(bytes: &[u8]) -> Result<(), ReadError> {
    if bytes.len() > MAX_BYTES { Err(ReadError::too_large(bytes.len(), "bytes", MAX_BYTES)) } else { Ok(()) }
}
