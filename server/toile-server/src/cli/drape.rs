//! `toile drape`

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use serde::de::DeserializeOwned;
use toile_drape::network::Networks;
use toile_onnx::OnnxNetworks;

use super::{DEFAULT_DATA, Failure, Parts};
use crate::assets::Assets;
use crate::draping;
use crate::json;
use crate::requests::{BodyRequest, DrapeBody, Part, PoseRequest};
use crate::service::Service;
use crate::upload::{Metadata, Upload};
use crate::wardrobe::Prepared;

/// Arguments of `toile drape`.
#[derive(Args, Debug)]
pub struct DrapeFile {
    /// An outfit's file, or the id of one in the data directory
    #[arg(long, value_name = "FILE|ID")]
    outfit: String,
    /// JSON file with `body` as in POST /v1/drapes [default: the reference body]
    #[arg(long, value_name = "FILE")]
    body: Option<PathBuf>,
    /// JSON file with `pose` as in POST /v1/drapes, or the name of a preset [default: a-pose]
    #[arg(long, value_name = "FILE|NAME")]
    pose: Option<String>,
    /// Name of a motion, instead of a pose
    #[arg(long, value_name = "NAME", conflicts_with = "pose")]
    motion: Option<String>,
    /// deepsd, deepsd-concat, garnet, pixel_cloth, simulation or skinning; garnet needs `kinds` in the metadata
    #[arg(long, default_value = "deepsd", value_name = "METHOD")]
    method: String,
    /// What the GLB holds
    #[arg(long, value_delimiter = ',', default_value = "outfit", value_name = "outfit,body")]
    include: Vec<String>,
    /// JSON file with `metadata` as in POST /v1/outfits, for an outfit's file
    #[arg(long, value_name = "FILE")]
    metadata: Option<PathBuf>,
    /// Where the GLB goes
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Folder of the database, for an outfit's id
    #[arg(long, default_value = DEFAULT_DATA, value_name = "DIR")]
    data: PathBuf,
    #[command(flatten)]
    parts: Parts,
}

impl DrapeFile {
    /// Drapes and writes.
    pub async fn run(self) -> Result<(), Failure> {
        let request = self.request()?;
        request.check()?;
        let assets = Assets::load(&self.parts.artifacts()?)?;
        let mut networks = OnnxNetworks::load(&self.parts.artifacts()?, &self.parts.onnxruntime()?)?;
        let prepared = match Path::new(&self.outfit).is_file() {
            true => Arc::new(self.prepare_file(&assets, &mut networks)?),
            false => self.prepare_stored().await?,
        };
        let draped = draping::drape(&assets, &prepared, &request, &mut networks)?;
        std::fs::write(&self.output, &draped.glb)?;
        eprintln!("{}: {} bytes", self.output.display(), draped.glb.len());
        eprintln!("quality: {}", serde_json::to_string(&draped.quality)?);
        let stages = draped.timing.stages().map(|(name, milliseconds)| format!("{name} {milliseconds:.2}"));
        eprintln!("milliseconds: {}", stages.collect::<Vec<_>>().join(", "));
        Ok(())
    }

    fn request(&self) -> Result<DrapeBody, Failure> {
        let body = self.body.as_deref().map(read_json::<BodyRequest>).transpose()?;
        let pose = self.pose.as_deref().map(|pose| match Path::new(pose).is_file() {
            true => read_json::<PoseRequest>(Path::new(pose)),
            false => Ok(PoseRequest::preset(pose)),
        });
        let mut request = DrapeBody::single(&self.outfit, body, pose.transpose()?);
        request.motion.clone_from(&self.motion);
        request.set_method(&self.method);
        request.output.include = self.include.iter().map(|name| part(name)).collect::<Result<_, _>>()?;
        Ok(request)
    }

    fn prepare_file(&self, assets: &Assets, networks: &mut dyn Networks) -> Result<Prepared, Failure> {
        let metadata = self.metadata.as_deref().map_or_else(|| Ok(Metadata::default()), read_json)?;
        let upload = Upload { file_name: Some(self.outfit.clone()), metadata };
        let (outfit, report) = upload.read(&std::fs::read(&self.outfit)?, assets)?;
        report.notes.iter().for_each(|note| eprintln!("  {note}"));
        let statics = assets.studio.static_pass(&outfit, &upload.fitted_on(assets)?, networks)?;
        Ok(Prepared::new(outfit, statics, upload.metadata.kinds))
    }

    async fn prepare_stored(&self) -> Result<Arc<Prepared>, Failure> {
        if !self.data.is_dir() {
            let data = self.data.display();
            return Err(format!(
                "there is no file {}, and no data directory {data} to look it up in",
                self.outfit
            )
            .into());
        }
        let service = Service::open(&self.parts.settings(self.data.clone())?).await?;
        let found = service.wardrobe.get(&self.outfit).await;
        service.close().await;
        Ok(found?.0)
    }
}

fn part(name: &str) -> Result<Part, Failure> {
    match name {
        "outfit" => Ok(Part::Outfit),
        "body" => Ok(Part::Body),
        _ => Err(format!("\"{name}\" cannot be included; use outfit, body or both").into()),
    }
}

/// Reads a JSON file as strictly as a request.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, Failure> {
    let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(json::parse(&bytes).map_err(|error| format!("{}: {error}", path.display()))?)
}
