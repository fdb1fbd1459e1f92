//! `toile bench`: how long every stage takes, as a table.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use toile_drape::hero;
use toile_drape::methods::{GarmentKind, MethodKind};
use toile_drape::network::Networks;
use toile_onnx::OnnxNetworks;

use super::{Failure, Parts};
use crate::assets::Assets;
use crate::requests::{DrapeBody, PoseRequest};
use crate::server_timing::milliseconds_since;
use crate::upload::{Kinds, Upload};
use crate::wardrobe::Prepared;
use crate::{draping, gallery};

/// Fewest repetitions that a median is taken of.
const FEWEST: usize = 3;

/// Arguments of `toile bench`.
#[derive(Args, Debug)]
pub struct Bench {
    /// An outfit's file [default: the demo outfit that is marked for it]
    #[arg(long, value_name = "FILE")]
    outfit: Option<PathBuf>,
    /// Name of the pose
    #[arg(long, default_value = "contrapposto", value_name = "NAME")]
    pose: String,
    /// Seconds to measure each method for
    #[arg(long, default_value_t = 3.0, value_name = "SECONDS")]
    seconds: f32,
    /// Measure garnet too, every garment being of this kind: tee, sweater, dress or jeans
    #[arg(long, value_name = "KIND")]
    kind: Option<GarmentKind>,
    #[command(flatten)]
    parts: Parts,
}

/// Medians of the stages of repeated drapes.
struct Measured {
    stages: Vec<(&'static str, f64)>,
    whole: f64,
    repetitions: usize,
}

impl Measured {
    fn stage(&self, name: &str) -> f64 {
        self.stages.iter().find(|stage| stage.0 == name).map_or(f64::NAN, |stage| stage.1)
    }
}

impl Bench {
    /// Measures on one thread and prints Markdown.
    pub fn run(self) -> Result<(), Failure> {
        let artifacts = self.parts.artifacts()?;
        let path = self.outfit.clone().map_or_else(|| benchmark_outfit(&artifacts.join("gallery")), Ok)?;
        let assets = Assets::load(&artifacts)?;
        let mut networks = OnnxNetworks::load(&artifacts, &self.parts.onnxruntime()?)?;
        let mut prepared = prepare(&path, &assets, &mut networks)?;
        let names = prepared.outfit.garments.iter().map(|garment| garment.name.clone());
        prepared.kinds = names.zip(self.kind.into_iter().cycle()).collect();
        let has_networks = hero::known(&assets.studio.heroes.iter().collect::<Vec<_>>(), &prepared.outfit)
            .into_iter()
            .all(|known| known);
        let methods = MethodKind::ALL.into_iter().filter(|method| match method {
            MethodKind::Garnet => self.kind.is_some(),
            MethodKind::PixelCloth => has_networks,
            MethodKind::Simulation => false,
            _ => true,
        });
        let mut columns = Vec::new();
        for method in methods {
            eprintln!("measuring {method} …");
            let request = self.request(method);
            // The first drape fills caches.
            draping::drape(&assets, &prepared, &request, &mut networks)?;
            let time = Duration::try_from_secs_f32(self.seconds)?;
            columns.push((method, repeat(time, &assets, &prepared, &request, &mut networks)?));
        }
        print_table(&columns);
        let of = |method| columns.iter().find(|column| column.0 == method).map(|column| &column.1);
        if let (Some(basis), Some(printed)) = (of(MethodKind::Deepsd), of(MethodKind::DeepsdConcat)) {
            let ratio = printed.stage("dynamic") / basis.stage("dynamic");
            println!("\ndynamic pass: deepsd is {ratio:.0} times as fast as deepsd-concat");
            println!("warm drapes with GLB: {:.0} a second on one core", 1e3 / basis.whole);
        }
        Ok(())
    }

    fn request(&self, method: MethodKind) -> DrapeBody {
        let mut request = DrapeBody::single("", None, Some(PoseRequest::preset(&self.pose)));
        request.set_method(method.name());
        request.output.textures = false;
        request
    }
}

/// The demo outfit that is marked for it, otherwise the first.
fn benchmark_outfit(folder: &Path) -> Result<PathBuf, Failure> {
    let exhibits = gallery::exhibits(folder)?;
    let chosen = exhibits.iter().find(|exhibit| exhibit.benchmark).or(exhibits.first());
    let chosen = chosen.ok_or("there are no demo outfits; state one with --outfit FILE")?;
    Ok(folder.join(&chosen.file))
}

/// Reads the outfit and prints how long everything takes that is done once.
fn prepare(path: &Path, assets: &Assets, networks: &mut dyn Networks) -> Result<Prepared, Failure> {
    let upload = Upload { file_name: Some(path.display().to_string()), ..Upload::default() };
    let file = std::fs::read(path)?;
    let started = Instant::now();
    let (outfit, _) = upload.read(&file, assets)?;
    let build = milliseconds_since(started);
    let fitted_on = upload.fitted_on(assets)?;
    let mut statics = assets.studio.static_pass(&outfit, &fitted_on, networks)?;
    let mut times = Vec::new();
    for _ in 0..FEWEST {
        let started = Instant::now();
        statics = assets.studio.static_pass(&outfit, &fitted_on, networks)?;
        times.push(milliseconds_since(started));
    }
    println!(
        "{}: {} vertices, {} triangles\n",
        path.display(),
        outfit.positions.len(),
        outfit.triangles.len()
    );
    println!("| once per outfit | ms |\n|---|---:|");
    println!("| read and build | {build:.1} |\n| static pass | {:.1} |\n", median(&mut times));
    Ok(Prepared::new(outfit, statics, Kinds::new()))
}

fn repeat(
    time: Duration,
    assets: &Assets,
    prepared: &Prepared,
    request: &DrapeBody,
    networks: &mut dyn Networks,
) -> Result<Measured, Failure> {
    let mut stages: Vec<(&'static str, Vec<f64>)> = Vec::new();
    let mut whole = Vec::new();
    let begun = Instant::now();
    while whole.len() < FEWEST || begun.elapsed() < time {
        let started = Instant::now();
        let draped = draping::drape(assets, prepared, request, networks)?;
        whole.push(milliseconds_since(started));
        for (name, milliseconds) in draped.timing.stages() {
            match stages.iter_mut().find(|stage| stage.0 == name) {
                Some(stage) => stage.1.push(milliseconds),
                None => stages.push((name, vec![milliseconds])),
            }
        }
    }
    let repetitions = whole.len();
    let stages = stages.into_iter().map(|(name, mut times)| (name, median(&mut times))).collect();
    Ok(Measured { stages, whole: median(&mut whole), repetitions })
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

fn print_table(columns: &[(MethodKind, Measured)]) {
    let row = |head: &str, cell: &dyn Fn(&Measured) -> String| {
        let cells: Vec<String> = columns.iter().map(|(_, measured)| cell(measured)).collect();
        println!("| {head} | {} |", cells.join(" | "));
    };
    let heads: Vec<&str> = columns.iter().map(|(method, _)| method.name()).collect();
    println!("| stage, median ms | {} |\n|---|{}", heads.join(" | "), "---:|".repeat(columns.len()));
    let names = columns.first().map_or(&[][..], |(_, measured)| measured.stages.as_slice());
    for (name, _) in names {
        row(name, &|measured| match measured.stage(name) {
            ms if ms.is_nan() => String::new(),
            ms => format!("{ms:.3}"),
        });
    }
    row("whole", &|measured| format!("{:.3}", measured.whole));
    row("repetitions", &|measured| measured.repetitions.to_string());
}
