//! Drapes as coarse meshes with normal maps: what `output.detail` asks for.

use std::sync::OnceLock;
use std::time::Instant;

use toile_drape::normal_map::{CoarseOutfit, NormalMapError};
use toile_drape::outfit::Outfit;
use toile_drape::pipeline::Frame;
use toile_gltf::{FrameView, OutfitTemplate, Relief, Scene, write_relief};

use crate::errors::ApiError;
use crate::server_timing::ServerTiming;
use crate::wardrobe::Prepared;

/// The coarse mesh of an outfit, made when it is first asked for, and why it cannot be.
#[derive(Debug, Default)]
pub struct CoarseMesh(OnceLock<Result<Coarse, NormalMapError>>);

#[derive(Debug)]
struct Coarse {
    mesh: CoarseOutfit,
    template: OutfitTemplate,
}

impl CoarseMesh {
    /// Bytes that it takes in memory at most.
    pub fn byte_bound(outfit: &Outfit) -> usize {
        CoarseOutfit::byte_bound(outfit)
    }

    /// Not for a tokio thread: the first call simplifies the outfit.
    fn get(&self, prepared: &Prepared) -> Result<&Coarse, ApiError> {
        let make = || {
            let mesh = CoarseOutfit::new(&prepared.outfit, prepared.statics.rest_positions())?;
            let template = prepared.template.of_mesh(&mesh.outfit);
            Ok(Coarse { mesh, template })
        };
        self.0.get_or_init(make).as_ref().map_err(|error| error.clone().into())
    }
}

/// The scene with the outfit's coarse mesh in the place of its own, and normal maps of this many texels each way, or as
/// many as the garment asks for, baked from `frame`.
///
/// # Errors
/// `no-uvs` when a garment's UVs do not do for it.
pub fn encode(
    prepared: &Prepared,
    frame: &Frame,
    scene: &Scene<'_>,
    side: Option<usize>,
    timing: &mut ServerTiming,
) -> Result<Vec<u8>, ApiError> {
    let started = Instant::now();
    let Coarse { mesh, template } = prepared.coarse.get(prepared)?;
    timing.add_since("coarse", started, None);
    let started = Instant::now();
    let shading = mesh.shade(&frame.positions);
    let maps = mesh.bake(&frame.normals, &shading, side);
    timing.add_since("bake", started, None);
    let started = Instant::now();
    let relief = Relief { tangents: &shading.tangents, uvs: &mesh.uvs, maps: &maps };
    let view = scene.frames.first().copied().unwrap_or_default();
    let frames = [FrameView { normals: &shading.normals, ..view }];
    let scene = Scene { outfit: Some(template), frames: &frames, ..*scene };
    let glb = write_relief(&scene, &relief).map_err(ApiError::internal)?;
    timing.add_since("encode", started, None);
    Ok(glb)
}
