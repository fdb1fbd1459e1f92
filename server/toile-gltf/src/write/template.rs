//! What every drape of an outfit, or of the body, has in common, prepared once.

use std::ops::Range;
use std::sync::Arc;

use toile_drape::outfit::{Garment, Outfit};

use super::material::Materials;

/// Everything of an outfit's GLB but positions, normals and attributes. Keep it beside the static pass.
#[derive(Debug)]
pub struct OutfitTemplate {
    pub(super) name: String,
    /// Drawn vertex -> welded vertex.
    pub(super) vertex_of: Vec<u32>,
    pub(super) welded_count: usize,
    pub(super) garments: Vec<GarmentTemplate>,
    /// UVs of all drawn vertices, or empty.
    pub(super) uvs: Vec<u8>,
    pub(super) indices: Vec<u8>,
    pub(super) materials: Arc<Materials>,
}

/// A node to be.
#[derive(Debug)]
pub(super) struct GarmentTemplate {
    pub(super) name: String,
    pub(super) layer: u32,
    pub(super) drawn: Range<usize>,
    pub(super) primitives: Vec<PrimitiveTemplate>,
}

/// Indices that share a material.
#[derive(Debug)]
pub(super) struct PrimitiveTemplate {
    pub(super) material: usize,
    pub(super) indices: IndexRange,
}

/// Where indices lie in the index bytes, and how wide they are.
#[derive(Clone, Copy, Debug)]
pub(super) struct IndexRange {
    pub(super) offset: usize,
    pub(super) count: usize,
    pub(super) component_type: u32,
}

impl OutfitTemplate {
    /// Prepares the constant parts of `outfit`'s GLB.
    #[must_use]
    pub fn new(outfit: &Outfit) -> Self {
        Self::with(outfit, Arc::new(Materials::new(outfit)))
    }

    /// The same for another mesh of the outfit, which shares this one's materials and pictures.
    #[must_use]
    pub fn of_mesh(&self, mesh: &Outfit) -> Self {
        Self::with(mesh, Arc::clone(&self.materials))
    }

    fn with(outfit: &Outfit, materials: Arc<Materials>) -> Self {
        let mut indices = Vec::new();
        let garments =
            outfit.garments.iter().map(|garment| garment_template(garment, outfit, &mut indices)).collect();
        Self {
            name: outfit.name.clone(),
            vertex_of: outfit.surface.vertex_of.clone(),
            welded_count: outfit.positions.len(),
            garments,
            uvs: bytemuck::cast_slice(&outfit.surface.uvs).to_vec(),
            indices,
            materials,
        }
    }

    /// Bytes held in memory, roughly, for a cache that counts them.
    #[must_use]
    pub fn byte_size(&self) -> usize {
        let pictures: usize = self.materials.pictures.iter().map(|picture| picture.bytes.len()).sum();
        self.vertex_of.len() * 4 + self.uvs.len() + self.indices.len() + pictures + 4096
    }
}

fn garment_template(garment: &Garment, outfit: &Outfit, indices: &mut Vec<u8>) -> GarmentTemplate {
    let drawn = garment.drawn_vertices.start as usize..garment.drawn_vertices.end as usize;
    let primitives = garment.parts.iter().map(|part| {
        let range = part.triangles.start as usize..part.triangles.end as usize;
        let triangles = outfit.surface.triangles.get(range).unwrap_or(&[]);
        let indices = append_indices(triangles, garment.drawn_vertices.clone(), indices);
        PrimitiveTemplate { material: part.material, indices }
    });
    GarmentTemplate {
        name: garment.name.clone(),
        layer: garment.layer,
        primitives: primitives.collect(),
        drawn,
    }
}

/// Appends indices counted from the start of `vertices`, 16-bit where they fit, padded to four bytes.
fn append_indices(triangles: &[[u32; 3]], vertices: Range<u32>, bytes: &mut Vec<u8>) -> IndexRange {
    const UNSIGNED_SHORT: u32 = 5123;
    const UNSIGNED_INT: u32 = 5125;
    let offset = bytes.len();
    let local = triangles.iter().flatten().map(|index| index.saturating_sub(vertices.start));
    // The largest 16-bit value is the primitive restart, so it must not be an index.
    let narrow = vertices.len() <= usize::from(u16::MAX);
    if narrow {
        bytes.extend(local.flat_map(|index| (index as u16).to_le_bytes()));
    } else {
        bytes.extend(local.flat_map(u32::to_le_bytes));
    }
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let component_type = if narrow { UNSIGNED_SHORT } else { UNSIGNED_INT };
    IndexRange { offset, count: triangles.len() * 3, component_type }
}

/// Everything of the body's GLB but positions and normals.
#[derive(Debug)]
pub struct BodyTemplate {
    pub(super) vertex_count: usize,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) index_bytes: Vec<u8>,
    pub(super) indices: IndexRange,
}

impl BodyTemplate {
    /// Prepares the constant parts; triangles that point beyond `vertex_count` are left out.
    #[must_use]
    pub fn new(vertex_count: usize, triangles: &[[u32; 3]]) -> Self {
        let within = |t: &&[u32; 3]| t.iter().all(|&corner| (corner as usize) < vertex_count);
        let triangles: Vec<[u32; 3]> = triangles.iter().filter(within).copied().collect();
        let mut index_bytes = Vec::new();
        let end = u32::try_from(vertex_count).unwrap_or(u32::MAX);
        let indices = append_indices(&triangles, 0..end, &mut index_bytes);
        Self { vertex_count, triangles, index_bytes, indices }
    }
}
