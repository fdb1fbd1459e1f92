//! Times of the body's stages, one thread: `cargo run --release -p toile-geometry --example bench_body`.

use std::collections::BTreeMap;
use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use toile_geometry::body::{Body, BodyShape, ShapedBody};
use toile_geometry::measurements::{measure, solve};
use toile_geometry::poses::PoseLibrary;

const ROUNDS: usize = 200;

fn main() -> Result<(), Box<dyn Error>> {
    let artifacts = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../model/artifacts");
    let bytes = std::fs::read(artifacts.join("body.safetensors"))?;
    let start = Instant::now();
    let body = Body::from_safetensors(&bytes)?;
    println!("load                            {:8.3} ms", start.elapsed().as_secs_f64() * 1e3);
    let shape = BodyShape {
        phenotypes: [0.3, 0.7, 0.4, 0.6, 0.45, 0.55],
        local_changes: std::array::from_fn(|k| 0.1 * (k % 5) as f32 - 0.2),
        ..BodyShape::default()
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
    time_measuring(&body, &shaped)?;
    Ok(())
}

/// One usual request, one with weight, one with everything: the measurements of a body off the average.
fn time_measuring(body: &Body, shaped: &ShapedBody) -> Result<(), Box<dyn Error>> {
    let all = measure(body, shaped);
    time("measure", || measure(body, shaped));
    for (name, count) in [("solve height", 1), ("solve 3, with weight", 3), ("solve all 11", 11)] {
        let requested = all.iter().take(count).collect();
        let steps = solve(body, &requested, &BTreeMap::new())?.iterations;
        time(&format!("{name}, {steps} steps"), || solve(body, &requested, &BTreeMap::new()));
    }
    Ok(())
}

/// Prints the median time of a call, and its mean processor time, which a busy machine does not change.
fn time<T>(name: &str, mut call: impl FnMut() -> T) {
    let processor = processor_ms();
    let mut times: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            black_box(call());
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    let processor = (processor_ms() - processor) / ROUNDS as f64;
    times.sort_by(f64::total_cmp);
    println!(
        "{name:<32}{:8.3} ms   p95 {:8.3} ms   processor {processor:8.3} ms",
        times[ROUNDS / 2],
        times[ROUNDS * 95 / 100]
    );
}

/// Processor time of this thread so far, ms (Linux; 0 elsewhere).
fn processor_ms() -> f64 {
    let read = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    read.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).unwrap_or(0.0) / 1e6
}
