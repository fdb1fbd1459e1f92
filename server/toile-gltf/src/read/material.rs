//! Materials that the meshes use (glTF 2.0, section 3.9; KHR_materials_sheen; KHR_texture_transform).

use std::collections::BTreeSet;

use gltf::json::material::{AlphaMode, Material as JsonMaterial};
use gltf::json::validation::Checked;
use gltf::json::{Index, texture};
use serde_json::{Map, Value};
use toile_drape::outfit::{Material, Picture, RawMesh, UvTransform};

use super::ReadError;
use super::document::Document;
use super::picture::PictureReader;

/// Roughness of cloth where the file states it by a texture, which is not kept.
const CLOTH_ROUGHNESS: f32 = 0.9;

/// One material per material of the file, so that indices hold; those that no mesh uses stay plain.
pub(super) fn read_used(
    document: &Document<'_>,
    meshes: &[RawMesh],
    notes: &mut Vec<String>,
) -> Result<Vec<Material>, ReadError> {
    let used: BTreeSet<usize> =
        meshes.iter().flat_map(|mesh| mesh.parts.iter().filter_map(|part| part.material)).collect();
    let Some(last) = used.last() else { return Ok(Vec::new()) };
    let mut pictures = PictureReader::new(document);
    let read = |(index, json)| {
        if used.contains(&index) {
            material(json, document, &mut pictures, notes)
        } else {
            Ok(Material::default())
        }
    };
    document.root.materials.iter().take(last + 1).enumerate().map(read).collect()
}

fn material(
    json: &JsonMaterial,
    document: &Document<'_>,
    pictures: &mut PictureReader<'_, '_>,
    notes: &mut Vec<String>,
) -> Result<Material, ReadError> {
    let surface = &json.pbr_metallic_roughness;
    let base = surface.base_color_texture.as_ref();
    let base_color_picture = picture(base.map(|info| info.index), document, pictures, notes)?;
    let normal_picture =
        picture(json.normal_texture.as_ref().map(|info| info.index), document, pictures, notes)?;
    let (metallic, roughness) = match surface.metallic_roughness_texture {
        Some(_) => (0.0, CLOTH_ROUGHNESS),
        None => (unit(surface.metallic_factor.0), unit(surface.roughness_factor.0)),
    };
    let base_extensions = base.and_then(|info| info.extensions.as_ref()).map(|extensions| &extensions.others);
    let normal_extensions = json
        .normal_texture
        .as_ref()
        .and_then(|info| info.extensions.as_ref())
        .map(|extensions| &extensions.others);
    Ok(Material {
        name: json.name.clone().unwrap_or_default(),
        base_color: surface.base_color_factor.0.map(unit),
        base_color_picture,
        normal_picture,
        uv_transform: base_extensions.or(normal_extensions).and_then(uv_transform),
        roughness,
        metallic,
        sheen: json.extensions.as_ref().and_then(|extensions| sheen(&extensions.others)),
        alpha_cutoff: alpha_cutoff(json),
    })
}

fn picture(
    texture: Option<Index<texture::Texture>>,
    document: &Document<'_>,
    pictures: &mut PictureReader<'_, '_>,
    notes: &mut Vec<String>,
) -> Result<Option<Picture>, ReadError> {
    let Some(index) = texture else { return Ok(None) };
    match document.root.textures.get(index.value()) {
        Some(texture) => pictures.read(texture.source, notes),
        None => {
            notes.push(format!(
                "A material refers to texture {}, which does not exist; it was left out.",
                index.value()
            ));
            Ok(None)
        }
    }
}

/// Blended cloth would need sorting, so it is cut out instead.
fn alpha_cutoff(json: &JsonMaterial) -> Option<f32> {
    const HALF: f32 = 0.5;
    let textured = json.pbr_metallic_roughness.base_color_texture.is_some();
    match json.alpha_mode {
        Checked::Valid(AlphaMode::Mask) => {
            Some(json.alpha_cutoff.map_or(HALF, |cutoff| cutoff.0.clamp(0.0, 1.0)))
        }
        Checked::Valid(AlphaMode::Blend) if textured => Some(HALF),
        _ => None,
    }
}

fn sheen(extensions: &Map<String, Value>) -> Option<([f32; 3], f32)> {
    let sheen = extensions.get("KHR_materials_sheen")?;
    let color = numbers(sheen.get("sheenColorFactor")).unwrap_or([0.0; 3]).map(unit);
    let roughness = sheen.get("sheenRoughnessFactor").and_then(Value::as_f64).unwrap_or(0.0);
    Some((color, unit(roughness as f32)))
}

fn uv_transform(extensions: &Map<String, Value>) -> Option<UvTransform> {
    let transform = extensions.get("KHR_texture_transform")?;
    let rotation = transform.get("rotation").and_then(Value::as_f64).unwrap_or(0.0) as f32;
    Some(UvTransform {
        offset: numbers(transform.get("offset")).unwrap_or([0.0; 2]),
        rotation: if rotation.is_finite() { rotation } else { 0.0 },
        scale: numbers(transform.get("scale")).unwrap_or([1.0; 2]),
    })
}

/// `N` finite numbers.
fn numbers<const N: usize>(value: Option<&Value>) -> Option<[f32; N]> {
    let list: Option<Vec<f32>> = value?.as_array()?.iter().map(|v| v.as_f64().map(|v| v as f32)).collect();
    let numbers: [f32; N] = list?.try_into().ok()?;
    numbers.iter().all(|number| number.is_finite()).then_some(numbers)
}

fn unit(value: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) }
}
