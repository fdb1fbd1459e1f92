//! Times of the body's stages, one thread: `cargo run --release -p toile-geometry --example bench_body`.

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use toile_geometry::body::{Body, BodyShape};
use toile_geometry::poses::PoseLibrary;

const ROUNDS: usize = 200;

fn main() -> Result<(), Box<dyn Error>> {
    let artifacts = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../model/artifacts");
    let bytes = std::fs::read(artifacts.join("body.safetensors"))?;
    let start = Instant::now();
    let body = Body::from_safetensors(&bytes)?;
    println!("load                  {:8.3} ms", start.elapsed().as_secs_f64() * 1e3);
    let shape = BodyShape {
        phenotypes: [0.3, 0.7, 0.4, 0.6, 0.45, 0.55],
        local_changes: std::array::from_fn(|k| 0.1 * (k % 5) as f32 - 0.2),
    };
    let library = PoseLibrary::from_json(&std::fs::read(artifacts.join("poses.json"))?, &body)?;
    let pose = library.preset("contrapposto").ok_or("no contrapposto")?.pose.to_pose(&body)?;
    time("shape", || body.shape(&shape));
    let shaped = body.shape(&shape);
    time("world joints", || body.world_joints(&shaped, &pose));
    let world = body.world_joints(&shaped, &pose);
    time("garment transforms", || body.garment_transforms(&shaped, &world));
    time("posed vertices", || body.posed_vertices(&shaped, &world));
    let subset: Vec<u32> = (0..13_718).step_by(3).collect();
    time("posed subset of 4573", || body.posed_subset(&shaped, &world, &subset));
    time("grounded", || body.grounded(&shaped, pose.clone()));
    Ok(())
}

/// Prints the median time of a call.
fn time<T>(name: &str, mut call: impl FnMut() -> T) {
    let mut times: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            black_box(call());
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("{name:<22}{:8.3} ms   p95 {:8.3} ms", times[ROUNDS / 2], times[ROUNDS * 95 / 100]);
}
