//! One drape from request to bytes, as it runs on a worker thread and in the command line.

use std::time::Instant;

use bytes::Bytes;
use toile_drape::methods::{ClothImages, GarmentKind, MethodKind};
use toile_drape::network::Networks;
use toile_drape::outfit::Garment;
use toile_drape::pipeline::{self, Drape, DrapeRequest, Motion, Quality};
use toile_gltf::{FrameView, Scene, write_drape};

use crate::assets::Assets;
use crate::errors::{ApiError, Code};
use crate::relief;
use crate::requests::{Attribute, Detail, DrapeBody, OutputRequest, Part};
use crate::server_timing::ServerTiming;
use crate::upload::check_names;
use crate::wardrobe::Prepared;

/// A finished drape.
#[derive(Debug)]
pub struct Draped {
    /// The scene.
    pub glb: Bytes,
    /// How good it is.
    pub quality: Quality,
    /// What a pixel-cloth network said of the first frame, one entry a garment.
    pub images: Vec<ClothImages>,
    /// Body and poses that it was made for.
    pub motion: Motion,
    /// Milliseconds of every stage.
    pub timing: ServerTiming,
}

/// Body and pose, drape, GLB.
///
/// # Errors
/// When body or pose is refused or a computation fails.
pub fn drape(
    assets: &Assets,
    prepared: &Prepared,
    request: &DrapeBody,
    networks: &mut dyn Networks,
) -> Result<Draped, ApiError> {
    let mut timing = ServerTiming::default();
    let started = Instant::now();
    let motion = request.motion(assets)?;
    timing.add_since("motion", started, None);
    let work = DrapeRequest {
        outfit: &prepared.outfit,
        statics: &prepared.statics,
        motion: &motion,
        method: request.method()?,
        kinds: &kinds(prepared, request)?,
        hero: prepared.hero.as_ref().map(|(hero, _)| hero),
        simulated: assets.simulations.of(&request.outfit).map_or(&[], |kept| &kept.drapes),
        resolve: true,
    };
    let drape = pipeline::drape(&assets.studio, &work, networks)?;
    drape.timing.stages().for_each(|(stage, milliseconds)| timing.add(stage, milliseconds));
    let glb = encode(assets, prepared, (&drape, &motion), &request.output, &mut timing)?;
    Ok(Draped { glb, quality: drape.quality, images: drape.images, motion, timing })
}

/// Kind of every garment, for the method that needs them; as the request says, otherwise as the outfit's metadata do.
///
/// # Errors
/// `unknown-kind` for a garment that neither says anything of, `invalid-field` for one that is not there.
fn kinds(prepared: &Prepared, request: &DrapeBody) -> Result<Vec<GarmentKind>, ApiError> {
    let stated = &request.output.kinds;
    check_names(stated, &prepared.outfit).map_err(|error| error.under("/output/kinds"))?;
    if request.method()? != MethodKind::Garnet {
        return Ok(Vec::new());
    }
    let kind = |garment: &Garment| {
        let found = stated.get(&garment.name).or_else(|| prepared.kinds.get(&garment.name));
        found.copied().ok_or_else(|| unknown_kind(&garment.name))
    };
    prepared.outfit.garments.iter().map(kind).collect()
}

fn unknown_kind(garment: &str) -> ApiError {
    let known: Vec<&str> = GarmentKind::ALL.iter().map(|kind| kind.name()).collect();
    let detail = format!(
        "Nothing says what kind of garment \"{garment}\" is. If it is one of {}, say so in `output.kinds` or in the \
         outfit's metadata; the method \"deepsd\" drapes any garment.",
        known.join(", ")
    );
    ApiError::new(Code::UnknownKind, detail).at("/output/kinds")
}

fn encode(
    assets: &Assets,
    prepared: &Prepared,
    (drape, motion): (&Drape, &Motion),
    output: &OutputRequest,
    timing: &mut ServerTiming,
) -> Result<Bytes, ApiError> {
    let started = Instant::now();
    let with = |attribute| output.attributes.contains(&attribute);
    let frames: Vec<FrameView<'_>> = drape
        .frames
        .iter()
        .map(|frame| FrameView {
            positions: &frame.positions,
            normals: &frame.normals,
            strain: if with(Attribute::Strain) { &frame.strain } else { &[] },
            penetration: if with(Attribute::Penetration) { &frame.penetration } else { &[] },
            body: &frame.body.vertices,
        })
        .collect();
    let scene = Scene {
        outfit: output.include.contains(&Part::Outfit).then_some(&prepared.template),
        body: output.include.contains(&Part::Body).then_some(&assets.body_template),
        frames: &frames,
        frame_rate: motion.frame_rate,
        textures: output.textures,
    };
    let glb = match drape.frames.as_slice() {
        [frame] if output.detail == Detail::NormalMap && scene.outfit.is_some() => {
            let side = output.normal_map_size.map(|size| size as usize);
            relief::encode(prepared, frame, &scene, side, timing)?
        }
        _ => {
            let glb = write_drape(&scene).map_err(ApiError::internal)?;
            timing.add_since("encode", started, None);
            glb
        }
    };
    Ok(glb.into())
}
