//! `toile`: the server and its command line.

mod answers;
mod assets;
mod bakes;
mod cli;
mod cloth_png;
mod domain_errors;
mod draping;
mod errors;
mod files;
mod gallery;
mod hash;
mod heroes;
mod json;
mod lifecycle;
mod listener;
mod locations;
mod measurements;
mod relief;
mod request_id;
mod requests;
mod routes;
mod scan;
mod server_timing;
mod service;
mod simulations;
mod static_files;
mod store;
mod upload;
mod wardrobe;
mod workers;

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::Parser;
use tracing_subscriber::EnvFilter;

/// What is logged unless `RUST_LOG` says otherwise.
const DEFAULT_LOG: &str = "info,ort=warn,sqlx=warn";

#[tokio::main]
async fn main() -> ExitCode {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(DEFAULT_LOG));
    let colours = std::io::stderr().is_terminal();
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_ansi(colours).init();
    match cli::run(cli::Cli::parse()).await {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("toile: {error}");
            ExitCode::FAILURE
        }
    }
}
