//! `toile evaluate`: the figures of a method over many bodies and poses, as a table.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Deserialize;
use toile_drape::evaluation::{Figures, crossed, turned};
use toile_drape::methods::{GarmentKind, MethodKind};
use toile_drape::network::Networks;
use toile_drape::outfit::{Garment, Outfit};
use toile_drape::pipeline::{DrapeRequest, Motion, drape};
use toile_drape::static_pass::StaticPass;
use toile_onnx::OnnxNetworks;

use super::kept_drapes::KeptDrapes;
use super::{Failure, Parts};
use crate::assets::Assets;
use crate::gallery::exhibit_at;
use crate::requests::{BodyRequest, DrapeBody, PoseRequest};
use crate::upload::Upload;

/// Arguments of `toile evaluate`.
#[derive(Args, Debug)]
pub struct Evaluate {
    /// Outfits' files
    #[arg(required = true, value_name = "FILE")]
    outfits: Vec<PathBuf>,
    /// Bodies and poses [default: evaluation.json of the artifacts]
    #[arg(long, value_name = "FILE")]
    set: Option<PathBuf>,
    /// deepsd, deepsd-concat, garnet, pixel_cloth or skinning
    #[arg(long, default_value = "deepsd", value_name = "METHOD")]
    method: String,
    /// Kind of every garment, for garnet: tee, sweater, dress or jeans [default: as the gallery says of its own]
    #[arg(long, value_name = "KIND")]
    kind: Option<GarmentKind>,
    /// Use only this many poses of the set
    #[arg(long, value_name = "N")]
    poses: Option<usize>,
    /// Also write every drape into this folder, a safetensors file an outfit
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Print the pose with the largest stretch of every outfit
    #[arg(long)]
    worst: bool,
    #[command(flatten)]
    parts: Parts,
}

/// Bodies and poses to evaluate on, as the API's `body` and `pose` objects.
#[derive(Debug, Deserialize)]
struct EvaluationSet {
    bodies: Vec<BodyRequest>,
    poses: Vec<PoseRequest>,
}

/// Figures before and after the resolve.
struct Row {
    before: Figures,
    after: Figures,
    /// Percent of the edges that pass through their own garment and through another in the rest pose.
    rest_crossed: (f32, f32),
    /// Percent of the triangles that the resolve turned over, mean and worst frame.
    turned: (f32, f32),
}

impl Evaluate {
    /// Drapes every outfit on every body in every pose and prints Markdown.
    pub fn run(self) -> Result<(), Failure> {
        let artifacts = self.parts.artifacts()?;
        let assets = Assets::load(&artifacts)?;
        let mut networks = OnnxNetworks::load(&artifacts, &self.parts.onnxruntime()?)?;
        let method: MethodKind = self.method.parse()?;
        let path = self.set.clone().unwrap_or_else(|| artifacts.join("evaluation.json"));
        let mut set: EvaluationSet = serde_json::from_slice(&std::fs::read(path)?)?;
        set.poses.truncate(self.poses.unwrap_or(usize::MAX));
        let motions = set.motions(&assets)?;
        println!(
            "{method}, {} bodies x {} poses; % inside the body at vertices / triangle centroids, edges and stretch before / after",
            set.bodies.len(),
            set.poses.len()
        );
        println!(
            "| outfit | before % | after % | edge mm before / after | edge % | stretch p99.9 | max | turned over % mean / worst | self-crossed % rest / before / after | layers crossed % |"
        );
        println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
        let (kind, keep) = (self.kind, self.keep.as_deref());
        let judge = Judge { assets: &assets, method, kind, motions: &motions, keep };
        let mut rows = Vec::new();
        for path in &self.outfits {
            let name = path.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
            let worn = judge.read(path, &mut networks)?;
            let Draped { frames, turned, rest_crossed } = judge.frames(&worn, &name, &mut networks)?;
            if self.worst {
                report_worst(&name, &frames, set.poses.len());
            }
            let (before, after): (Vec<_>, Vec<_>) = frames.into_iter().unzip();
            let turned =
                (turned.iter().sum::<f32>() / turned.len().max(1) as f32, largest(turned.iter().copied()));
            let row =
                Row { before: Figures::mean(&before), after: Figures::mean(&after), rest_crossed, turned };
            row.print(&name);
            rows.push(row);
        }
        Row::mean(&rows).print("**mean**");
        Ok(())
    }
}

/// Figures of every frame before and after the resolve, and what is crossed in the rest pose already.
struct Draped {
    frames: Vec<(Figures, Figures)>,
    /// Percent of the triangles of every frame that the resolve turned over.
    turned: Vec<f32>,
    rest_crossed: (f32, f32),
}

/// What every outfit is draped on, and how.
struct Judge<'a> {
    assets: &'a Assets,
    method: MethodKind,
    kind: Option<GarmentKind>,
    motions: &'a [Motion],
    keep: Option<&'a Path>,
}

/// An outfit ready to be draped.
struct Worn {
    outfit: Outfit,
    statics: StaticPass,
    /// Kind of every garment, empty where that of one is not known.
    kinds: Vec<GarmentKind>,
}

impl Judge<'_> {
    /// An outfit's file; one of the gallery as the gallery has it.
    fn read(&self, path: &Path, networks: &mut dyn Networks) -> Result<Worn, Failure> {
        let upload = exhibit_at(path)?.map_or_else(
            || Upload { file_name: Some(path.display().to_string()), ..Upload::default() },
            |exhibit| exhibit.upload(),
        );
        let (outfit, _) = upload.read(&std::fs::read(path)?, self.assets)?;
        let statics = self.assets.studio.static_pass(&outfit, &upload.fitted_on(self.assets)?, networks)?;
        let known = &upload.metadata.kinds;
        let kind = |garment: &Garment| self.kind.or_else(|| known.get(&garment.name).copied());
        let kinds: Option<Vec<_>> = outfit.garments.iter().map(kind).collect();
        if kinds.is_none() && self.method == MethodKind::Garnet {
            return Err(format!("{}: the method garnet needs --kind", path.display()).into());
        }
        Ok(Worn { outfit, statics, kinds: kinds.unwrap_or_default() })
    }

    /// Figures of an outfit; keeps the drapes where that is asked for.
    fn frames(&self, worn: &Worn, name: &str, networks: &mut dyn Networks) -> Result<Draped, Failure> {
        let Worn { outfit, statics, kinds } = worn;
        let (mut frames, mut over, mut drapes) = (Vec::new(), Vec::new(), KeptDrapes::default());
        let (studio, method) = (&self.assets.studio, self.method);
        for motion in self.motions {
            let work = DrapeRequest {
                outfit,
                statics,
                motion,
                method,
                kinds,
                hero: None,
                simulated: &[],
                resolve: false,
            };
            let before = drape(studio, &work, networks)?.frames;
            let after = drape(studio, &DrapeRequest { resolve: true, ..work }, networks)?.frames;
            let shaped = self.assets.shaped(&motion.shape);
            let fitted = statics.fitted(studio, outfit, &motion.shape, &shaped);
            let measure = |f| Figures::measure(outfit, f, &statics.edges, &fitted.lengths);
            frames.extend(before.iter().map(measure).zip(after.iter().map(measure)));
            over.extend(before.iter().zip(&after).map(|(b, a)| turned(outfit, &b.positions, &a.positions)));
            if self.keep.is_some() {
                drapes.add((&fitted.rest, &shaped.apose_vertices), &before, &after);
            }
        }
        if let Some(folder) = self.keep {
            drapes.write(outfit, &folder.join(format!("{name}.safetensors")))?;
        }
        Ok(Draped { frames, turned: over, rest_crossed: crossed(outfit, &statics.rest, &statics.edges) })
    }
}

impl EvaluationSet {
    fn motions(&self, assets: &Assets) -> Result<Vec<Motion>, Failure> {
        let mut out = Vec::new();
        for body in &self.bodies {
            let mut request = DrapeBody::single("", Some(body.clone()), None);
            request.poses = Some(self.poses.clone());
            out.push(request.motion(assets)?);
        }
        Ok(out)
    }
}

fn report_worst(name: &str, frames: &[(Figures, Figures)], poses: usize) {
    let worst = frames.iter().enumerate().max_by(|a, b| a.1.1.stretch_max.total_cmp(&b.1.1.stretch_max));
    if let Some((index, (before, after))) = worst {
        eprintln!("{name}: body {} pose {}: before {before:?} after {after:?}", index / poses, index % poses);
    }
}

fn largest(values: impl Iterator<Item = f32>) -> f32 {
    values.fold(0.0, f32::max)
}

impl Row {
    fn mean(rows: &[Self]) -> Self {
        let column = |f: fn(&Self) -> Figures| Figures::mean(&rows.iter().map(f).collect::<Vec<_>>());
        let rest = |f: fn(&Self) -> f32| rows.iter().map(f).sum::<f32>() / rows.len().max(1) as f32;
        Self {
            before: column(|r| r.before),
            after: column(|r| r.after),
            rest_crossed: (rest(|r| r.rest_crossed.0), rest(|r| r.rest_crossed.1)),
            turned: (rest(|r| r.turned.0), largest(rows.iter().map(|r| r.turned.1))),
        }
    }

    fn print(&self, name: &str) {
        let (b, a) = (&self.before, &self.after);
        println!(
            "| {name} | {:.2} / {:.2} | {:.3} / {:.3} | {:.2} / {:.2} | {:.1} / {:.1} | {:.2} / {:.2} | {:.1} | {:.2} / {:.1} | {:.2} / {:.2} / {:.2} | {:.2} / {:.2} / {:.2} |",
            b.vertices_inside,
            b.centroids_inside,
            a.vertices_inside,
            a.centroids_inside,
            b.edge_mm,
            a.edge_mm,
            b.edge_percent,
            a.edge_percent,
            b.stretch_p999,
            a.stretch_p999,
            a.stretch_max,
            self.turned.0,
            self.turned.1,
            self.rest_crossed.0,
            b.self_crossed,
            a.self_crossed,
            self.rest_crossed.1,
            b.layers_crossed,
            a.layers_crossed
        );
    }
}
