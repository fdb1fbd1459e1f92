//! An outfit: garments in layer order, as one welded mesh, and what it takes to draw it.

use std::ops::Range;

use glam::{Vec2, Vec3};

/// A node's mesh as read from a file, before anything is mended. Corners index positions and, if any, UVs.
#[derive(Clone, Debug, Default)]
pub struct RawMesh {
    /// Node or mesh name in the file, possibly empty.
    pub name: String,
    /// Positions in metres, glTF axes (units and up-axis already applied), vertex order of the file.
    pub positions: Vec<Vec3>,
    /// One UV per position, or empty.
    pub uvs: Vec<Vec2>,
    /// Triangles by material.
    pub parts: Vec<RawPart>,
}

/// Triangles of a [`RawMesh`] that share a material.
#[derive(Clone, Debug, Default)]
pub struct RawPart {
    /// Triangles over the mesh's positions.
    pub triangles: Vec<[u32; 3]>,
    /// Index into the materials of the file; none is plain cloth.
    pub material: Option<usize>,
}

/// A picture that a material refers to, kept as it came.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// `image/png` or `image/jpeg`.
    pub mime_type: String,
    /// Encoded bytes.
    pub bytes: Vec<u8>,
}

/// How UVs become texture coordinates: scaled, then rotated, then moved (KHR_texture_transform).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Offset, in texture widths and heights.
    pub offset: [f32; 2],
    /// Counter-clockwise, radians.
    pub rotation: f32,
    /// Factors.
    pub scale: [f32; 2],
}

/// How cloth looks (glTF metallic-roughness with KHR_materials_sheen).
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: [f32; 4],
    /// Base colour texture.
    pub base_color_picture: Option<Picture>,
    /// Normal map.
    pub normal_picture: Option<Picture>,
    /// How UVs are placed on both pictures, if not as they are.
    pub uv_transform: Option<UvTransform>,
    /// Roughness factor, 0 to 1.
    pub roughness: f32,
    /// Metallic factor, 0 to 1.
    pub metallic: f32,
    /// Sheen colour and roughness, if the material has sheen.
    pub sheen: Option<([f32; 3], f32)>,
    /// `MASK` cutoff, if alpha-tested.
    pub alpha_cutoff: Option<f32>,
}

impl Default for Material {
    /// Plain cloth: matt, light grey, with a faint sheen.
    fn default() -> Self {
        Self {
            name: "cloth".to_owned(),
            base_color: [0.6, 0.6, 0.6, 1.0],
            base_color_picture: None,
            normal_picture: None,
            uv_transform: None,
            roughness: 0.9,
            metallic: 0.0,
            sheen: Some(([0.1, 0.1, 0.1], 0.5)),
            alpha_cutoff: None,
        }
    }
}

/// Triangles of a garment that share a material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Index into `Outfit::materials`.
    pub material: usize,
    /// Range of `Outfit::triangles` (and of `Surface::triangles`).
    pub triangles: Range<u32>,
}

/// One connected piece of clothing, with the small pieces (buttons, pockets) that it carries.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Garment {
    /// Unique within the outfit.
    pub name: String,
    /// 0 is next to the skin.
    pub layer: u32,
    /// Range of `Outfit::positions`.
    pub vertices: Range<u32>,
    /// Range of `Surface::vertex_of`; within it, vertices keep the order of the file.
    pub drawn_vertices: Range<u32>,
    /// Its triangles by material; contiguous.
    pub parts: Vec<Part>,
}

impl Garment {
    /// Range of `Outfit::triangles` over all parts.
    #[must_use]
    pub fn triangles(&self) -> Range<u32> {
        match (self.parts.first(), self.parts.last()) {
            (Some(first), Some(last)) => first.triangles.start..last.triangles.end,
            _ => 0..0,
        }
    }
}

/// The mesh as drawn: welded vertices split again along UV seams.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Drawn vertex -> welded vertex.
    pub vertex_of: Vec<u32>,
    /// One UV per drawn vertex, or empty.
    pub uvs: Vec<Vec2>,
    /// `Outfit::triangles`, over drawn vertices.
    pub triangles: Vec<[u32; 3]>,
}

/// Garments in layer order (innermost first) in rest pose on the body that they are fitted on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outfit {
    /// Human-readable name.
    pub name: String,
    /// Welded positions, metres, `rest` space. Sorted by garment.
    pub positions: Vec<Vec3>,
    /// Triangles over `positions`. Sorted by garment, then material.
    pub triangles: Vec<[u32; 3]>,
    /// Innermost first.
    pub garments: Vec<Garment>,
    /// What is drawn.
    pub surface: Surface,
    /// Materials of the file that are in use.
    pub materials: Vec<Material>,
}

/// What was found and mended while an outfit was built.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Report {
    /// Factor from file units to metres.
    pub scale_applied: f32,
    /// `y` or `z`.
    pub up_axis: String,
    /// `m`, `cm`, `mm` or `in`, stated or detected.
    pub units: String,
    /// File vertices merged into others.
    pub welded_vertices: usize,
    /// Triangles without area that were dropped.
    pub degenerate_faces_removed: usize,
    /// Triangles over the same three vertices that were dropped.
    pub duplicate_faces_removed: usize,
    /// Connected pieces of the welded mesh.
    pub components: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Triangles whose winding was turned to face outwards.
    pub flipped_normals: usize,
    /// Share of vertices inside the body in the rest pose as uploaded, percent.
    pub rest_penetration_percent: f32,
    /// Share of edges that pass through their own garment in the rest pose, percent.
    #[serde(default)]
    pub self_crossed_percent: f32,
    /// Sentences for a person.
    pub notes: Vec<String>,
}
