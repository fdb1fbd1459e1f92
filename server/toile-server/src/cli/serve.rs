//! `toile serve`

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use tokio::net::TcpListener;

use super::{DEFAULT_DATA, Failure, MEBIBYTE, Parts};
use crate::lifecycle::{Lifecycle, Phase, stop_signal};
use crate::listener::{self, Limits};
use crate::service::{Service, Settings};
use crate::{gallery, locations, routes};

/// Arguments of `toile serve`.
#[derive(Args, Debug)]
pub struct Serve {
    /// Address and port to listen on; port 0 takes a free one
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDR:PORT")]
    listen: SocketAddr,
    /// Folder of the database and of everything uploaded; created when missing
    #[arg(long, default_value = DEFAULT_DATA, value_name = "DIR")]
    data: PathBuf,
    #[command(flatten)]
    parts: Parts,
    /// Folder of the built try-on page [default: beside the binary, or web/dist]
    #[arg(long, value_name = "DIR")]
    web: Option<PathBuf>,
    /// Threads that compute [default: one for each core]
    #[arg(long, value_name = "N")]
    workers: Option<usize>,
    /// Requests that may wait for a thread before further ones are refused
    #[arg(long, default_value_t = 128, value_name = "N")]
    queue: usize,
    /// Memory for outfits that are ready to be draped, MiB
    #[arg(long, default_value_t = 384, value_name = "MIB")]
    cache: u64,
    /// Memory for drapes that a JSON answer gave a URL for, MiB
    #[arg(long, default_value_t = 64, value_name = "MIB")]
    answers: u64,
    /// Seconds for a request's head, and for a connection to stay idle
    #[arg(long, default_value_t = 30.0, value_name = "SECONDS")]
    header_timeout: f32,
    /// Seconds between two pieces of a request's body
    #[arg(long, default_value_t = 30.0, value_name = "SECONDS")]
    body_timeout: f32,
    /// Leave the demo outfits out
    #[arg(long)]
    no_gallery: bool,
}

impl Serve {
    /// Serves until told to stop.
    pub async fn run(self) -> Result<(), Failure> {
        let stop = stop_signal()?;
        let settings = self.settings()?;
        let service = Arc::new(Service::open(&settings).await?);
        let lifecycle = Lifecycle::default();
        let listener = TcpListener::bind(self.listen)
            .await
            .map_err(|error| format!("cannot listen on {}: {error}", self.listen))?;
        // On stdout, so that whoever started us with port 0 can read where we are.
        println!("listening on http://{}", listener.local_addr()?);
        let web = locations::web(self.web.clone());
        if web.is_none() {
            tracing::warn!("the try-on page is not built; only the API is served");
        }
        self.fill_gallery(&settings, &service, &lifecycle);
        let app = routes::App::new(Arc::clone(&service), lifecycle.clone());
        let router = routes::router(app, web.as_deref(), seconds(self.body_timeout)?);
        let limits = Limits {
            connections: 1024,
            header_read: seconds(self.header_timeout)?,
            drain: Duration::from_secs(30),
        };
        let stop = async move {
            stop.await;
            lifecycle.reach(Phase::Stopping);
        };
        listener::serve(listener, router, limits, stop).await;
        service.close().await;
        tracing::info!("stopped");
        Ok(())
    }

    fn settings(&self) -> Result<Settings, Failure> {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        Ok(Settings {
            workers: self.workers.unwrap_or_else(cores),
            queue: self.queue,
            cache_bytes: self.cache * MEBIBYTE,
            answer_bytes: self.answers * MEBIBYTE,
            ..self.parts.settings(self.data.clone())?
        })
    }

    /// Loads the demo outfits beside the first requests; ready when they are there.
    fn fill_gallery(&self, settings: &Settings, service: &Arc<Service>, lifecycle: &Lifecycle) {
        let (service, lifecycle) = (Arc::clone(service), lifecycle.clone());
        let gallery = (!self.no_gallery).then(|| settings.artifacts.join("gallery"));
        tokio::spawn(async move {
            if let Some(folder) = gallery
                && let Err(error) = gallery::load(&folder, &service.wardrobe, &service.store).await
                && lifecycle.phase() != Phase::Stopping
            {
                tracing::error!(%error, "the demo outfits could not all be loaded");
            }
            lifecycle.reach(Phase::Ready);
        });
    }
}

fn seconds(value: f32) -> Result<Duration, Failure> {
    let duration = Duration::try_from_secs_f32(value).ok().filter(|duration| !duration.is_zero());
    duration.ok_or_else(|| format!("{value} is not a time to wait, in seconds").into())
}
