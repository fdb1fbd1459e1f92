//! Normal maps of a drape: tangents, a second UV set, a picture a garment and materials that show it.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::ops::Range;

use glam::{Vec2, Vec4};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use serde_json::{Map, Value, json};
use toile_drape::normal_map::NormalMap;

use super::error::check_length;
use super::frames::Morphs;
use super::glb::{GlbBuilder, Piece, ViewKind};
use super::material::{Materials, SHEEN, TEXTURE_TRANSFORM};
use super::root::SceneRoot;
use super::template::OutfitTemplate;
use super::{Scene, WriteError};

/// What one frame of an outfit's mesh has beside positions and normals.
#[derive(Clone, Copy, Debug)]
pub struct Relief<'a> {
    /// `TANGENT` of each drawn vertex: a unit vector and the bitangent's sign.
    pub tangents: &'a [Vec4],
    /// `TEXCOORD_1` of each drawn vertex.
    pub uvs: &'a [Vec2],
    /// One picture a garment, for `TEXCOORD_1`.
    pub maps: &'a [NormalMap],
}

impl<'a> Relief<'a> {
    pub(super) fn check(&self, scene: &Scene<'_>) -> Result<(), WriteError> {
        let Some(outfit) = scene.outfit else {
            return Err(WriteError::EmptyScene("normal maps but no outfit"));
        };
        check_length("frames with normal maps", 1, scene.frames.len())?;
        check_length("tangents", outfit.vertex_of.len(), self.tangents.len())?;
        check_length("map UVs", outfit.vertex_of.len(), self.uvs.len())?;
        check_length("normal maps", outfit.garments.len(), self.maps.len())?;
        let finite = self.tangents.iter().all(|t| t.is_finite()) && self.uvs.iter().all(|uv| uv.is_finite());
        if finite { Ok(()) } else { Err(WriteError::NonFinite("tangents")) }
    }

    /// Adds `TANGENT` and `TEXCOORD_1` to each garment's attributes.
    pub(super) fn add_vertices(
        &self,
        glb: &mut GlbBuilder<'a>,
        ranges: &[Range<usize>],
        meshes: &mut [(Map<String, Value>, Morphs)],
    ) {
        let tangents = glb.view(Piece::Bytes(bytemuck::cast_slice(self.tangents)), ViewKind::Vertices(16));
        let uvs = glb.view(Piece::Bytes(bytemuck::cast_slice(self.uvs)), ViewKind::Vertices(8));
        for (range, (attributes, _)) in ranges.iter().zip(meshes) {
            let tangent = glb.floats(tangents, range.start * 16, range.len(), "VEC4");
            let uv = glb.floats(uvs, range.start * 8, range.len(), "VEC2");
            attributes.insert("TANGENT".into(), tangent.into());
            attributes.insert("TEXCOORD_1".into(), uv.into());
        }
    }

    /// Adds pictures, and for each garment one material a part. The first material of each garment.
    pub(super) fn add_materials(
        &self,
        glb: &mut GlbBuilder<'a>,
        root: &mut SceneRoot,
        outfit: &'a OutfitTemplate,
        textures: bool,
    ) -> Result<Vec<usize>, WriteError> {
        let materials = &outfit.materials;
        let looks = if textures { &materials.textured } else { &materials.plain };
        let mut kept = BTreeMap::new();
        let mut firsts = Vec::new();
        for (garment, map) in outfit.garments.iter().zip(self.maps) {
            let image = root.images.len();
            let view = glb.view(Piece::Owned(png(map)?), ViewKind::Other);
            root.images.push(json!({"bufferView": view, "mimeType": "image/png"}));
            firsts.push(root.materials.len());
            for part in &garment.primitives {
                let mut material = looks.get(part.material).cloned().unwrap_or_else(|| json!({}));
                let colour = &mut material["pbrMetallicRoughness"]["baseColorTexture"];
                match colour.get("index").and_then(Value::as_u64) {
                    Some(picture) => {
                        colour["index"] = add_picture(glb, root, materials, (picture, &mut kept)).into();
                    }
                    None => drop(
                        material["pbrMetallicRoughness"]
                            .as_object_mut()
                            .map(|m| m.remove("baseColorTexture")),
                    ),
                }
                material["normalTexture"] = json!({"index": image, "texCoord": 1});
                root.materials.push(material);
            }
        }
        if materials.has_sheen {
            root.extensions.push(SHEEN);
        }
        if textures && materials.has_uv_transform && !kept.is_empty() {
            root.extensions.push(TEXTURE_TRANSFORM);
        }
        Ok(firsts)
    }
}

/// Adds one of the outfit's own pictures, the first time that it is asked for; its index in the file.
fn add_picture<'a>(
    glb: &mut GlbBuilder<'a>,
    root: &mut SceneRoot,
    materials: &'a Materials,
    (picture, kept): (u64, &mut BTreeMap<u64, usize>),
) -> usize {
    *kept.entry(picture).or_insert_with(|| {
        if let Some(picture) = materials.pictures.get(picture as usize) {
            let view = glb.view(Piece::Bytes(&picture.bytes), ViewKind::Other);
            root.images.push(json!({"bufferView": view, "mimeType": picture.mime_type}));
        }
        root.images.len() - 1
    })
}

/// Eight bits a channel.
fn png(map: &NormalMap) -> Result<Vec<u8>, WriteError> {
    let mut out = Cursor::new(Vec::new());
    let encoder = PngEncoder::new_with_quality(&mut out, CompressionType::Default, FilterType::Adaptive);
    let side = map.side as u32;
    let written = encoder.write_image(map.texels.as_flattened(), side, side, ExtendedColorType::Rgb8);
    written.map_err(|error| WriteError::Picture(error.to_string()))?;
    Ok(out.into_inner())
}
