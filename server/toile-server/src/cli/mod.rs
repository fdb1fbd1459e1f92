//! The command line.

mod bench;
mod check;
mod drape;
mod evaluate;
mod ingest;
mod kept_drapes;
mod poses;
mod serve;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::locations;
use crate::service::Settings;

/// Whatever stops a command: a sentence for stderr.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

const MEBIBYTE: u64 = 1024 * 1024;
/// Where everything is kept when nobody says.
const DEFAULT_DATA: &str = "data";

/// Toile drapes outfits on bodies.
#[derive(Debug, Parser)]
#[command(name = "toile", version, about)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Serve the HTTP API and the try-on page
    Serve(serve::Serve),
    /// Take outfits into a data directory, as an upload would
    Ingest(ingest::Ingest),
    /// Drape one outfit and write a GLB, without a server
    Drape(drape::DrapeFile),
    /// Measure how long every stage takes
    Bench(bench::Bench),
    /// Print penetrations and stretch of outfits over many bodies and poses
    Evaluate(evaluate::Evaluate),
    /// List preset poses and motions
    Poses(poses::Poses),
    /// Check body, poses, networks and their runtime
    Check(check::Check),
}

/// Where the parts that are not in the binary lie.
#[derive(Args, Clone, Debug)]
struct Parts {
    /// Folder of body, poses, networks and demo outfits [default: beside the binary, or model/artifacts]
    #[arg(long, value_name = "DIR", env = "TOILE_ARTIFACTS")]
    artifacts: Option<PathBuf>,
    /// ONNX Runtime library [default: the one in the repository's .venv]
    #[arg(long, value_name = "PATH", env = "ORT_DYLIB_PATH")]
    onnxruntime: Option<PathBuf>,
}

impl Parts {
    fn artifacts(&self) -> Result<PathBuf, Failure> {
        Ok(locations::artifacts(self.artifacts.clone())?)
    }

    fn onnxruntime(&self) -> Result<PathBuf, Failure> {
        Ok(locations::onnxruntime(self.onnxruntime.clone())?)
    }

    /// Settings of a command that is alone: one worker that is never too busy.
    fn settings(&self, data: PathBuf) -> Result<Settings, Failure> {
        Ok(Settings {
            artifacts: self.artifacts()?,
            onnxruntime: self.onnxruntime()?,
            data,
            workers: 1,
            queue: 16,
            cache_bytes: 256 * MEBIBYTE,
            answer_bytes: MEBIBYTE,
        })
    }
}

/// Runs the command that was asked for.
///
/// # Errors
/// What stopped it.
pub async fn run(cli: Cli) -> Result<(), Failure> {
    match cli.command {
        Command::Serve(serve) => serve.run().await,
        Command::Ingest(ingest) => ingest.run().await,
        Command::Drape(drape) => drape.run().await,
        Command::Bench(bench) => bench.run(),
        Command::Evaluate(evaluate) => evaluate.run(),
        Command::Poses(poses) => poses.run(),
        Command::Check(check) => check.run(),
    }
}
