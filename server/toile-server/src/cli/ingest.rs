//! `toile ingest`

use std::path::{Path, PathBuf};

use clap::Args;

use super::{DEFAULT_DATA, Failure, Parts};
use crate::server_timing::ServerTiming;
use crate::service::Service;
use crate::upload::{Metadata, Upload};

/// Arguments of `toile ingest`.
#[derive(Args, Debug)]
pub struct Ingest {
    /// GLB, self-contained glTF or OBJ
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Folder of the database; created when missing. A server may be running on it
    #[arg(long, default_value = DEFAULT_DATA, value_name = "DIR")]
    data: PathBuf,
    /// JSON file with `metadata` as in POST /v1/outfits, for all files
    #[arg(long, value_name = "FILE")]
    metadata: Option<PathBuf>,
    #[command(flatten)]
    parts: Parts,
}

impl Ingest {
    /// Takes in every file that can be taken in.
    pub async fn run(self) -> Result<(), Failure> {
        let metadata =
            self.metadata.as_deref().map_or_else(|| Ok(Metadata::default()), super::drape::read_json)?;
        let service = Service::open(&self.parts.settings(self.data.clone())?).await?;
        let mut refused = 0;
        for path in &self.files {
            if let Err(error) = ingest(&service, path, metadata.clone()).await {
                eprintln!("{}: {error}", path.display());
                refused += 1;
            }
        }
        service.close().await;
        match refused {
            0 => Ok(()),
            _ => Err(format!("{refused} of {} files were refused", self.files.len()).into()),
        }
    }
}

async fn ingest(service: &Service, path: &Path, metadata: Metadata) -> Result<(), Failure> {
    let file = std::fs::read(path)?;
    let upload =
        Upload { file_name: path.file_name().map(|name| name.to_string_lossy().into_owned()), metadata };
    let (stored, is_new) = service.wardrobe.add(file.into(), upload, &mut ServerTiming::default()).await?;
    let (outfit, state) = (stored.outfit, if is_new { "new" } else { "known" });
    let summary = &outfit.summary;
    println!(
        "{}  {state}  {}  {} vertices  {} triangles",
        outfit.id, outfit.name, summary.vertices, summary.triangles
    );
    for note in &outfit.report.notes {
        eprintln!("  {note}");
    }
    Ok(())
}
