//! Writing GLB: a drape (one frame or a sequence), a rest pose, the body.

mod error;
mod frames;
mod glb;
mod material;
mod relief;
mod root;
mod strain;
mod template;

use glam::Vec3;
use serde_json::{Map, Value, json};
use toile_drape::outfit::Outfit;

pub use self::error::WriteError;
pub use self::relief::Relief;
pub use self::strain::vertex_strain;
pub use self::template::{BodyTemplate, OutfitTemplate};

use self::error::check_length;
use self::frames::{Morphs, mesh_vertices};
use self::glb::{GlbBuilder, Piece, ViewKind};
use self::material::{SHEEN, TEXTURE_TRANSFORM};
use self::root::SceneRoot;
use self::template::{GarmentTemplate, IndexRange};

/// One pose of the scene, world space, metres. Outfit lists run over welded vertices.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameView<'a> {
    /// Outfit positions.
    pub positions: &'a [Vec3],
    /// Outfit unit normals.
    pub normals: &'a [Vec3],
    /// `_STRAIN`, or empty for none. A sequence shows that of its first frame.
    pub strain: &'a [f32],
    /// `_PENETRATION` in metres, or empty for none. A sequence shows that of its first frame.
    pub penetration: &'a [f32],
    /// Body positions; needed only with a body template.
    pub body: &'a [Vec3],
}

/// What goes into the GLB.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The outfit, or none to leave it out.
    pub outfit: Option<&'a OutfitTemplate>,
    /// The body, or none to leave it out.
    pub body: Option<&'a BodyTemplate>,
    /// At least one; the caller caps the number.
    pub frames: &'a [FrameView<'a>],
    /// Frames per second of a sequence.
    pub frame_rate: f32,
    /// Whether the outfit's pictures are embedded.
    pub textures: bool,
}

/// Writes one frame as plain meshes, several as morph targets with a linear weights animation.
///
/// Every garment is a node under its own name, the body is the node `body`. The same scene gives the same
/// bytes. After glTF 2.0, sections 3.7.2 (meshes, morph targets) and 3.11 (animations).
///
/// # Errors
/// When lengths do not match the templates, a value is not finite, or there is nothing to write.
pub fn write_drape(scene: &Scene<'_>) -> Result<Vec<u8>, WriteError> {
    write(scene, None)
}

/// Writes one frame with a normal map a garment in the place of the outfit's own.
///
/// # Errors
/// As [`write_drape`], and when the normal maps are not the outfit's or there are several frames.
pub fn write_relief(scene: &Scene<'_>, relief: &Relief<'_>) -> Result<Vec<u8>, WriteError> {
    relief.check(scene)?;
    write(scene, Some(relief))
}

fn write<'a>(scene: &Scene<'a>, relief: Option<&Relief<'a>>) -> Result<Vec<u8>, WriteError> {
    check(scene)?;
    let mut glb = GlbBuilder::default();
    let mut root = SceneRoot::default();
    if let Some(outfit) = scene.outfit {
        add_outfit(&mut glb, &mut root, (outfit, relief), scene)?;
    }
    if let Some(body) = scene.body {
        add_body(&mut glb, &mut root, body, scene)?;
    }
    if scene.frames.len() > 1 {
        root.animation = Some(frames::animation(&mut glb, scene, root.nodes.len()));
    }
    let name = scene.outfit.map_or("body", |outfit| outfit.name.as_str());
    glb.finish(root.into_json(name))
}

/// Writes an outfit's rest pose, positions over welded vertices, with normals and pictures.
///
/// # Errors
/// When there are not as many positions as the outfit has, or one is not finite.
pub fn write_rest(outfit: &Outfit, positions: &[Vec3]) -> Result<Vec<u8>, WriteError> {
    let normals = toile_geometry::normals::vertex_normals(positions, &outfit.triangles);
    let frame = FrameView { positions, normals: &normals, ..FrameView::default() };
    let template = OutfitTemplate::new(outfit);
    write_drape(&Scene {
        outfit: Some(&template),
        body: None,
        frames: &[frame],
        frame_rate: 1.0,
        textures: true,
    })
}

/// Writes a body, positions in metres.
///
/// # Errors
/// When a position is not finite or there are none.
pub fn write_body(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<Vec<u8>, WriteError> {
    let template = BodyTemplate::new(positions.len(), triangles);
    let frame = FrameView { body: positions, ..FrameView::default() };
    write_drape(&Scene {
        outfit: None,
        body: Some(&template),
        frames: &[frame],
        frame_rate: 1.0,
        textures: false,
    })
}

fn check(scene: &Scene<'_>) -> Result<(), WriteError> {
    if scene.frames.is_empty() {
        return Err(WriteError::EmptyScene("no frames"));
    }
    if scene.outfit.is_none_or(|o| o.garments.is_empty()) && scene.body.is_none_or(|b| b.triangles.is_empty())
    {
        return Err(WriteError::EmptyScene("neither outfit nor body"));
    }
    if !(scene.frame_rate.is_finite() && scene.frame_rate > 0.0) {
        return Err(WriteError::EmptyScene("a frame rate that is not positive"));
    }
    for frame in scene.frames {
        if let Some(outfit) = scene.outfit {
            check_length("positions", outfit.welded_count, frame.positions.len())?;
            check_length("normals", outfit.welded_count, frame.normals.len())?;
        }
        if let Some(body) = scene.body {
            check_length("body positions", body.vertex_count, frame.body.len())?;
        }
    }
    Ok(())
}

fn add_outfit<'a>(
    glb: &mut GlbBuilder<'a>,
    root: &mut SceneRoot,
    (outfit, relief): (&'a OutfitTemplate, Option<&Relief<'a>>),
    scene: &Scene<'a>,
) -> Result<(), WriteError> {
    let uvs = (!outfit.uvs.is_empty()).then(|| glb.view(Piece::Bytes(&outfit.uvs), ViewKind::Vertices(8)));
    let indices = glb.view(Piece::Bytes(&outfit.indices), ViewKind::Indices);
    let ranges: Vec<_> = outfit.garments.iter().map(|garment| garment.drawn.clone()).collect();
    let mut vertices = frames::outfit_vertices(glb, outfit, scene.frames, &ranges)?;
    let first_material = match relief {
        None => {
            add_materials(glb, root, outfit, scene.textures);
            None
        }
        Some(relief) => {
            relief.add_vertices(glb, &ranges, &mut vertices);
            Some(relief.add_materials(glb, root, outfit, scene.textures)?)
        }
    };
    for (index, (garment, (mut attributes, morphs))) in outfit.garments.iter().zip(vertices).enumerate() {
        if let Some(view) = uvs {
            let accessor = glb.floats(view, garment.drawn.start * 8, garment.drawn.len(), "VEC2");
            attributes.insert("TEXCOORD_0".into(), accessor.into());
        }
        let materials = first_material.as_ref().and_then(|first| first.get(index).copied());
        let vertices = Vertices { attributes, morphs };
        let primitives = garment_primitives(glb, garment, (indices, materials), &vertices);
        root.add_node(&garment.name, primitives, Some(garment.layer));
    }
    Ok(())
}

struct Vertices {
    attributes: Map<String, Value>,
    morphs: Morphs,
}

/// The garment's parts, with materials of the outfit or, from `own` on, one of its own a part.
fn garment_primitives(
    glb: &mut GlbBuilder<'_>,
    garment: &GarmentTemplate,
    (view, own): (usize, Option<usize>),
    vertices: &Vertices,
) -> Vec<Value> {
    let parts = garment.primitives.iter().enumerate();
    let material = |index: usize, of_outfit: usize| own.map_or(of_outfit, |first| first + index);
    parts
        .map(|(index, part)| primitive(glb, vertices, (view, part.indices), material(index, part.material)))
        .collect()
}

fn primitive(
    glb: &mut GlbBuilder<'_>,
    vertices: &Vertices,
    (view, range): (usize, IndexRange),
    material: usize,
) -> Value {
    let indices = glb.accessor(json!({
        "bufferView": view, "byteOffset": range.offset, "componentType": range.component_type,
        "count": range.count, "type": "SCALAR"
    }));
    let mut primitive = json!({"attributes": vertices.attributes, "indices": indices, "material": material});
    if !vertices.morphs.is_empty() {
        primitive["targets"] = json!(vertices.morphs);
    }
    primitive
}

fn add_materials<'a>(
    glb: &mut GlbBuilder<'a>,
    root: &mut SceneRoot,
    outfit: &'a OutfitTemplate,
    textures: bool,
) {
    let materials = &outfit.materials;
    root.materials.extend_from_slice(if textures { &materials.textured } else { &materials.plain });
    if materials.has_sheen {
        root.extensions.push(SHEEN);
    }
    if textures && materials.has_uv_transform {
        root.extensions.push(TEXTURE_TRANSFORM);
    }
    for picture in materials.pictures.iter().filter(|_| textures) {
        let view = glb.view(Piece::Bytes(&picture.bytes), ViewKind::Other);
        root.images.push(json!({"bufferView": view, "mimeType": picture.mime_type}));
    }
}

fn add_body<'a>(
    glb: &mut GlbBuilder<'a>,
    root: &mut SceneRoot,
    body: &'a BodyTemplate,
    scene: &Scene<'a>,
) -> Result<(), WriteError> {
    let view = glb.view(Piece::Bytes(&body.index_bytes), ViewKind::Indices);
    let normals: Vec<Vec<Vec3>> = scene
        .frames
        .iter()
        .map(|frame| toile_geometry::normals::vertex_normals(frame.body, &body.triangles))
        .collect();
    let shown: Vec<_> =
        scene.frames.iter().zip(&normals).map(|(f, n)| (f.body.to_vec(), n.clone())).collect();
    let range = 0..body.vertex_count;
    let all = mesh_vertices(glb, shown, std::slice::from_ref(&range))?;
    for (attributes, morphs) in all {
        let material = root.materials.len();
        let primitive = primitive(glb, &Vertices { attributes, morphs }, (view, body.indices), material);
        root.add_node("body", vec![primitive], None);
    }
    root.materials.push(json!({
        "name": "body",
        "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorFactor": [0.62, 0.56, 0.52, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.65},
    }));
    Ok(())
}
