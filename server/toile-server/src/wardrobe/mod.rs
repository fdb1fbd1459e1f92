//! Outfits ready to be draped: memory, then disk, then computed, each only once however many ask.

mod own;

use std::sync::Arc;
use std::time::Instant;

use bytes::Bytes;
use moka::future::Cache;
use moka::policy::EvictionPolicy;
use toile_drape::hero::Hero;
use toile_drape::network::Networks;
use toile_drape::outfit::{Outfit, Report};
use toile_drape::static_pass::StaticPass;
use toile_geometry::normals::vertex_normals;
use toile_gltf::{FrameView, OutfitTemplate, Scene, WriteError, write_drape};

use crate::assets::Assets;
use crate::bakes::{self, BakeReport};
use crate::errors::{ApiError, Code};
use crate::files::DataDir;
use crate::heroes::{self, HeroReport};
use crate::relief::CoarseMesh;
use crate::server_timing::ServerTiming;
use crate::static_files;
use crate::store::{NewOutfit, Store, StoredOutfit, Summary};
use crate::upload::{Kinds, Upload};
use crate::workers::Workers;

/// Everything about an outfit that does not depend on body or pose.
#[derive(Debug)]
pub struct Prepared {
    /// The outfit as built.
    pub outfit: Outfit,
    /// Its static pass.
    pub statics: StaticPass,
    /// What all its GLBs have in common.
    pub template: OutfitTemplate,
    /// Kinds of its garments, as far as they were stated.
    pub kinds: Kinds,
    /// What the bake in the static pass buys, if there is one.
    pub bake: Option<BakeReport>,
    /// Its own pixel-cloth network, if there is one, and how near that comes.
    pub hero: Option<(Hero, HeroReport)>,
    /// Its coarse mesh, once a normal map was asked for.
    pub coarse: CoarseMesh,
}

impl Prepared {
    /// Puts an outfit and its static pass together.
    pub fn new(mut outfit: Outfit, statics: StaticPass, kinds: Kinds) -> Self {
        let template = OutfitTemplate::new(&outfit);
        // The template has them now, and nothing else asks for them.
        for material in &mut outfit.materials {
            (material.base_color_picture, material.normal_picture) = (None, None);
        }
        Self { outfit, statics, template, kinds, bake: None, hero: None, coarse: CoarseMesh::default() }
    }

    /// With what the outfit has of its own: a bake in the place of the networks' answers, a pixel-cloth network.
    fn with_own(self, data: &DataDir, id: &str, key: &str, body: usize) -> Self {
        let hero = heroes::load(&data.hero(id), id, &self.outfit, body);
        match bakes::load(&data.bake(key), &self.statics, key) {
            Some((bake, report)) => {
                Self { statics: self.statics.baked(bake), bake: Some(report), hero, ..self }
            }
            None => Self { hero, ..self },
        }
    }

    /// The repaired rest pose on the reference body as a GLB.
    ///
    /// # Errors
    /// When it cannot be written, which is a mistake of ours.
    pub fn rest_glb(&self) -> Result<Vec<u8>, WriteError> {
        let positions = self.statics.rest_positions();
        let normals = vertex_normals(positions, &self.outfit.triangles);
        let frame = FrameView { positions, normals: &normals, ..FrameView::default() };
        let outfit = Some(&self.template);
        write_drape(&Scene { outfit, body: None, frames: &[frame], frame_rate: 1.0, textures: true })
    }

    fn byte_size(&self) -> usize {
        let outfit = &self.outfit;
        let corners = (outfit.triangles.len() + outfit.surface.triangles.len()) * size_of::<[u32; 3]>();
        let points = size_of_val(outfit.positions.as_slice()) + size_of_val(outfit.surface.uvs.as_slice());
        let drawn = size_of_val(outfit.surface.vertex_of.as_slice());
        let hero = self.hero.as_ref().map_or(0, |(hero, _)| hero.byte_size());
        let coarse = CoarseMesh::byte_bound(outfit);
        corners + points + drawn + hero + coarse + self.statics.byte_size() + self.template.byte_size()
    }
}

/// Where a prepared outfit came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// It was in memory, or another request was already getting it.
    Memory,
    /// Its static pass was on disk.
    Disk,
    /// Its static pass had to be computed.
    Computed,
}

impl Source {
    /// The word in `Server-Timing`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Memory => "memory",
            Self::Disk => "disk",
            Self::Computed => "computed",
        }
    }
}

/// The cache of prepared outfits, and the way in for new ones.
pub struct Wardrobe {
    kept: Cache<String, Arc<Prepared>>,
    assets: Arc<Assets>,
    store: Store,
    workers: Arc<Workers>,
    fingerprint: String,
}

impl Wardrobe {
    /// Keeps at most `memory_bytes` of prepared outfits. `fingerprint` is that of the workers' networks.
    pub fn new(
        assets: Arc<Assets>,
        store: Store,
        workers: Arc<Workers>,
        fingerprint: String,
        memory_bytes: u64,
    ) -> Self {
        let weigher =
            |_: &String, prepared: &Arc<Prepared>| u32::try_from(prepared.byte_size()).unwrap_or(u32::MAX);
        let policy = EvictionPolicy::lru();
        let kept =
            Cache::builder().max_capacity(memory_bytes).weigher(weigher).eviction_policy(policy).build();
        Self { kept, assets, store, workers, fingerprint }
    }

    /// The address of an outfit's static pass.
    pub fn static_key(&self, id: &str) -> String {
        static_files::key(id, &self.fingerprint, &self.assets.body_hash)
    }

    /// The outfit of this id, ready to be draped.
    ///
    /// # Errors
    /// `unknown-outfit`, or why it cannot be prepared now.
    pub async fn get(&self, id: &str) -> Result<(Arc<Prepared>, Source), ApiError> {
        let mut source = Source::Memory;
        let load = async {
            let (prepared, from) = self.load(id).await?;
            source = from;
            Ok(prepared)
        };
        let entry = self.kept.entry_by_ref(id).or_try_insert_with(load).await;
        let prepared = entry.map_err(|error: Arc<ApiError>| (*error).clone())?.into_value();
        Ok((prepared, source))
    }

    async fn load(&self, id: &str) -> Result<(Arc<Prepared>, Source), ApiError> {
        let stored = self.stored(id).await?;
        let kinds = stored.outfit.upload.metadata.kinds.clone();
        let (key, statics) = (self.static_key(id), self.statics(stored));
        let (data, body, owner) =
            (self.store.data().clone(), self.assets.body().vertex_count(), id.to_owned());
        let prepare = move |networks: &mut dyn Networks| {
            let (outfit, statics, source) = statics(networks)?;
            Ok::<_, ApiError>((
                Prepared::new(outfit, statics, kinds).with_own(&data, &owner, &key, body),
                source,
            ))
        };
        let (prepared, source) = self.workers.run(prepare).await??;
        // It may have been deleted meanwhile.
        self.stored(id).await?;
        Ok((Arc::new(prepared), source))
    }

    /// What a worker does to get an outfit and what the networks say of it: from disk, or computed and kept there.
    fn statics(
        &self,
        stored: StoredOutfit,
    ) -> impl FnOnce(&mut dyn Networks) -> Result<(Outfit, StaticPass, Source), ApiError> + use<> {
        let (assets, data) = (Arc::clone(&self.assets), self.store.data().clone());
        let key = self.static_key(&stored.outfit.id);
        move |networks| {
            let path = data.static_pass(&key);
            if let Some((outfit, statics)) = static_files::load(&path, &key) {
                return Ok((outfit, statics, Source::Disk));
            }
            let file = std::fs::read(data.outfit(&stored.outfit.id)).map_err(ApiError::internal)?;
            let (outfit, _) = stored.outfit.upload.read(&file, &assets)?;
            let statics = compute(&outfit, &stored.outfit.upload, &assets, networks)?;
            static_files::save(&path, &key, &outfit, &statics);
            Ok((outfit, statics, Source::Computed))
        }
    }

    /// The file that a bake is made of: what the networks say of an outfit, whether it has a bake or not.
    ///
    /// # Errors
    /// `unknown-outfit`, or why it cannot be prepared now.
    pub async fn tensors(&self, id: &str) -> Result<Vec<u8>, ApiError> {
        let statics = self.statics(self.stored(id).await?);
        let (key, networks_hash) = (self.static_key(id), self.fingerprint.clone());
        let write = move |networks: &mut dyn Networks| {
            let (outfit, statics, _) = statics(networks)?;
            statics.to_tensors(&outfit, &key, &networks_hash).map_err(ApiError::from)
        };
        self.workers.run(write).await?
    }

    /// The row of an outfit.
    ///
    /// # Errors
    /// `unknown-outfit` when there is none.
    pub async fn stored(&self, id: &str) -> Result<StoredOutfit, ApiError> {
        let unknown = || ApiError::new(Code::UnknownOutfit, format!("There is no outfit \"{id}\"."));
        self.store.get(id).await?.ok_or_else(unknown)
    }

    /// Takes in an upload: read, build, static pass, and only then file and row, so that an outfit that
    /// cannot be draped leaves nothing behind. Returns whether it is new.
    ///
    /// # Errors
    /// Why the upload is refused or cannot be kept.
    pub async fn add(
        &self,
        file: Bytes,
        upload: Upload,
        timing: &mut ServerTiming,
    ) -> Result<(StoredOutfit, bool), ApiError> {
        let started = Instant::now();
        let (hashed, bytes) = (upload.clone(), file.clone());
        let id = self.workers.run(move |_| hashed.id(&bytes)).await?.map_err(ApiError::internal)?;
        if let Some(stored) = self.store.get(&id).await? {
            return Ok((stored, false));
        }
        timing.add_since("hash", started, None);
        let (new, prepared) = self.prepare_new(id, file.clone(), upload, timing).await?;
        let started = Instant::now();
        let key = self.static_key(&new.id);
        let id = new.id.clone();
        let is_new = match self.store.keep(new, file).await {
            Ok(is_new) => is_new,
            Err(error) => {
                crate::files::remove_if_present(&self.store.data().static_pass(&key))
                    .map_err(ApiError::internal)?;
                return Err(error.into());
            }
        };
        self.kept.insert(id.clone(), Arc::new(prepared)).await;
        timing.add_since("keep", started, None);
        Ok((self.stored(&id).await?, is_new))
    }

    async fn prepare_new(
        &self,
        id: String,
        file: Bytes,
        upload: Upload,
        timing: &mut ServerTiming,
    ) -> Result<(NewOutfit, Prepared), ApiError> {
        let (assets, data, key) = (Arc::clone(&self.assets), self.store.data().clone(), self.static_key(&id));
        let mut stages = std::mem::take(timing);
        let prepare = move |networks: &mut dyn Networks| {
            let started = Instant::now();
            let (outfit, report) = upload.read(&file, &assets)?;
            stages.add_since("build", started, None);
            let started = Instant::now();
            let statics = compute(&outfit, &upload, &assets, networks)?;
            static_files::save(&data.static_pass(&key), &key, &outfit, &statics);
            stages.add_since("static", started, Some(Source::Computed.name()));
            let kinds = upload.metadata.kinds.clone();
            let new = new_outfit(id, upload, &outfit, &assets.studio.heroes, report);
            Ok::<_, ApiError>((new, Prepared::new(outfit, statics, kinds), stages))
        };
        let (new, prepared, stages) = self.workers.run(prepare).await??;
        *timing = stages;
        Ok((new, prepared))
    }

    /// Drops an outfit from memory; the next who asks has it from disk.
    pub async fn set_aside(&self, id: &str) {
        self.kept.invalidate(id).await;
        self.kept.run_pending_tasks().await;
    }

    /// Removes an outfit from disk and memory. Returns whether there was one.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn remove(&self, id: &str) -> Result<bool, ApiError> {
        let removed = self.store.delete(id, &self.static_key(id)).await?;
        self.set_aside(id).await;
        Ok(removed)
    }
}

fn compute(
    outfit: &Outfit,
    upload: &Upload,
    assets: &Assets,
    networks: &mut dyn Networks,
) -> Result<StaticPass, ApiError> {
    let started = Instant::now();
    let statics = assets.studio.static_pass(outfit, &upload.fitted_on(assets)?, networks)?;
    let milliseconds = crate::server_timing::milliseconds_since(started);
    tracing::info!(
        outfit = outfit.name,
        vertices = outfit.positions.len(),
        milliseconds,
        "static pass computed"
    );
    Ok(statics)
}

fn new_outfit(id: String, upload: Upload, outfit: &Outfit, heroes: &[Hero], report: Report) -> NewOutfit {
    NewOutfit { id, name: outfit.name.clone(), upload, summary: Summary::of(outfit, heroes), report }
}
