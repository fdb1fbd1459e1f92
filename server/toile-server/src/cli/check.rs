//! `toile check`

use clap::Args;
use toile_drape::network::Networks;
use toile_onnx::OnnxNetworks;

use super::{Failure, Parts};
use crate::assets::Assets;
use crate::gallery;

/// Arguments of `toile check`.
#[derive(Args, Debug)]
pub struct Check {
    #[command(flatten)]
    parts: Parts,
}

impl Check {
    /// Loads everything that a server loads, and says what it is.
    pub fn run(self) -> Result<(), Failure> {
        let folder = self.parts.artifacts()?;
        println!("toile        {}", env!("CARGO_PKG_VERSION"));
        println!("artifacts    {}", folder.display());
        let assets = Assets::load(&folder)?;
        let body = assets.body();
        println!(
            "body         {} vertices, {} joints, {}",
            body.vertex_count(),
            body.joint_names().len(),
            assets.body_hash
        );
        println!("poses        {}, motions {}", assets.poses.presets().len(), assets.poses.motions().len());
        let library = self.parts.onnxruntime()?;
        println!("onnxruntime  {}", library.display());
        let networks = OnnxNetworks::load(&folder, &library)?;
        println!("networks     {}", networks.fingerprint());
        println!("gallery      {} outfits", gallery::exhibits(&folder.join("gallery"))?.len());
        Ok(())
    }
}
