//! `toile poses`

use clap::Args;

use super::{Failure, Parts};
use crate::assets::Assets;

/// Arguments of `toile poses`.
#[derive(Args, Debug)]
pub struct Poses {
    #[command(flatten)]
    parts: Parts,
}

impl Poses {
    /// Lists what there is.
    pub fn run(self) -> Result<(), Failure> {
        let assets = Assets::load(&self.parts.artifacts()?)?;
        for pose in assets.poses.presets() {
            println!("pose    {:<16} {:<10} {}", pose.id, pose.group, pose.label);
        }
        for motion in assets.poses.motions() {
            let (frames, rate) = (motion.frames.len(), motion.frame_rate);
            println!("motion  {:<16} {frames} frames at {rate}/s  {}", motion.id, motion.label);
        }
        Ok(())
    }
}
