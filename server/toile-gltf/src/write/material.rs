//! Materials and pictures of an outfit as glTF JSON, prepared once.

use serde_json::{Value, json};
use toile_drape::outfit::{Material, Outfit, Picture, UvTransform};

pub(super) const SHEEN: &str = "KHR_materials_sheen";
pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";

/// Materials with and without their pictures, and the pictures themselves, each once.
#[derive(Debug, Default)]
pub(super) struct Materials {
    pub(super) textured: Vec<Value>,
    pub(super) plain: Vec<Value>,
    pub(super) pictures: Vec<Picture>,
    pub(super) has_sheen: bool,
    pub(super) has_uv_transform: bool,
}

impl Materials {
    pub(super) fn new(outfit: &Outfit) -> Self {
        let mut out = Self::default();
        let can_be_textured = !outfit.surface.uvs.is_empty();
        for material in &outfit.materials {
            let plain = plain(material);
            out.has_sheen |= material.sheen.is_some();
            let textured =
                if can_be_textured { out.textured(material, plain.clone()) } else { plain.clone() };
            out.plain.push(plain);
            out.textured.push(textured);
        }
        out
    }

    fn textured(&mut self, material: &Material, mut json: Value) -> Value {
        if let Some(picture) = &material.base_color_picture {
            json["pbrMetallicRoughness"]["baseColorTexture"] = self.texture(picture, material.uv_transform);
        }
        if let Some(picture) = &material.normal_picture {
            json["normalTexture"] = self.texture(picture, material.uv_transform);
        }
        json
    }

    /// A reference to the texture of that picture; texture, picture and image share one index.
    fn texture(&mut self, picture: &Picture, transform: Option<UvTransform>) -> Value {
        let index = self.pictures.iter().position(|known| known == picture).unwrap_or_else(|| {
            self.pictures.push(picture.clone());
            self.pictures.len() - 1
        });
        let mut info = json!({"index": index});
        if let Some(UvTransform { offset, rotation, scale }) = transform {
            self.has_uv_transform = true;
            info["extensions"] =
                json!({TEXTURE_TRANSFORM: {"offset": offset, "rotation": rotation, "scale": scale}});
        }
        info
    }
}

fn plain(material: &Material) -> Value {
    let mut json = json!({
        "name": material.name,
        "doubleSided": true,
        "pbrMetallicRoughness": {
            "baseColorFactor": material.base_color,
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        },
    });
    if let Some(cutoff) = material.alpha_cutoff {
        json["alphaMode"] = "MASK".into();
        json["alphaCutoff"] = cutoff.into();
    }
    if let Some((color, roughness)) = material.sheen {
        json["extensions"] = json!({SHEEN: {"sheenColorFactor": color, "sheenRoughnessFactor": roughness}});
    }
    json
}
