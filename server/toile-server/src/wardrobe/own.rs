//! What an outfit may have of its own: a bake, a pixel-cloth network. The next drape has it.

use std::sync::Arc;

use bytes::Bytes;
use toile_drape::network::Networks;

use super::Wardrobe;
use crate::bakes::{self, BakeReport};
use crate::errors::ApiError;
use crate::files::remove_if_present;
use crate::heroes::{self, HeroReport};

impl Wardrobe {
    /// Takes in a bake's file.
    ///
    /// # Errors
    /// `unknown-outfit`, `invalid-bake` or `outdated-bake`; the outfit is then as it was.
    pub async fn bake(&self, id: &str, file: Bytes) -> Result<BakeReport, ApiError> {
        let (prepared, _) = self.get(id).await?;
        let (data, key) = (self.store.data().clone(), self.static_key(id));
        let keep = move |_: &mut dyn Networks| {
            let (_, report) = bakes::read(&file, &prepared.statics, &key)?;
            bakes::save(&data.bake(&key), &key, &file).map_err(ApiError::internal)?;
            Ok::<_, ApiError>(report)
        };
        let report = self.workers.run(keep).await??;
        self.set_aside(id).await;
        Ok(report)
    }

    /// Drops the bake of an outfit. Returns whether there was one.
    ///
    /// # Errors
    /// When its file cannot be removed.
    pub async fn unbake(&self, id: &str) -> Result<bool, ApiError> {
        self.drop_file(id, &self.store.data().bake(&self.static_key(id))).await
    }

    /// Takes in the file of a pixel-cloth network.
    ///
    /// # Errors
    /// `unknown-outfit` or `invalid-hero`; the outfit is then as it was.
    pub async fn add_hero(&self, id: &str, file: Bytes) -> Result<HeroReport, ApiError> {
        let (prepared, _) = self.get(id).await?;
        let (data, assets, owner) = (self.store.data().clone(), Arc::clone(&self.assets), id.to_owned());
        let keep = move |_: &mut dyn Networks| {
            let (_, report) = heroes::read(&file, &prepared.outfit, assets.body().vertex_count())?;
            heroes::save(&data.hero(&owner), &owner, &file).map_err(ApiError::internal)?;
            Ok::<_, ApiError>(report)
        };
        let report = self.workers.run(keep).await??;
        self.set_aside(id).await;
        Ok(report)
    }

    /// Drops the pixel-cloth network of an outfit. Returns whether there was one.
    ///
    /// # Errors
    /// When its file cannot be removed.
    pub async fn drop_hero(&self, id: &str) -> Result<bool, ApiError> {
        self.drop_file(id, &self.store.data().hero(id)).await
    }

    async fn drop_file(&self, id: &str, path: &std::path::Path) -> Result<bool, ApiError> {
        let existed = path.exists();
        remove_if_present(path).map_err(ApiError::internal)?;
        self.set_aside(id).await;
        Ok(existed)
    }
}
