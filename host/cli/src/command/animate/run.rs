//! Run of an animation: frame after frame, with its files on disk.

use std::time::Instant;

use caustics::checkpoint::{Identity, difference};
use caustics::exposure::Exposure;
use caustics::file::read_file;
use caustics::output::target::{Target, remove};
use caustics::output::{exr, png};
use caustics::program::program;
use caustics::rendered_image::{Aov, RenderedImage};
use caustics::scene::Scene;
use caustics::session::Session;

use super::kept::{self, refusal};
use super::plan::AnimationPlan;
use super::record::RenderedFrame;
use super::state::{self, AnimationState};
use crate::command::checkpoint_writer::CheckpointWriter;
use crate::command::console::bar;
use crate::command::options::layer_attributes;

/// An animation that is being rendered.
pub struct Run {
    /// Plan of the animation.
    pub plan: AnimationPlan,
    /// Scene, posed.
    pub scene: Scene,
    /// Name of the camera.
    pub camera: String,
    /// Session that renders.
    pub session: Session,
    /// Everything that decides the bits.
    pub identity: Identity,
    /// Frame that scene and session are posed at.
    pub posed: Option<u32>,
    /// Writer of the history's state, which remembers whether it succeeded.
    pub checkpoint_writer: CheckpointWriter,
}

impl Run {
    /// Removes the existing frames and the state.
    pub fn forget(&self) -> anyhow::Result<()> {
        for frame in self.plan.frames.clone() {
            remove(&self.plan.pattern.frame(frame, "exr"))?;
            remove(&self.plan.pattern.frame(frame, "png"))?;
        }
        Ok(remove(&self.plan.state())?)
    }

    /// Poses scene and session at a frame; where motion is needed, first at the frame before.
    fn pose(&mut self, frame: u32) -> anyhow::Result<()> {
        if let Some(before) = frame.checked_sub(1)
            && self.plan.aov.contains(&Aov::Motion)
            && self.posed != Some(before)
        {
            self.pose_at(self.plan.time_of(before))?;
            self.session.stand();
        }
        self.posed = Some(frame);
        self.pose_at(self.plan.time_of(frame))
    }

    /// Poses scene and session at a time (s).
    fn pose_at(&mut self, time: f64) -> anyhow::Result<()> {
        self.scene.pose(time)?;
        let camera = self.scene.camera(Some(&self.camera))?;
        Ok(self.session.pose(&self.scene, camera)?)
    }

    /// Returns the frames to render for the missing ones, in order. Where state outlives a frame, restores the last known
    /// state and returns all frames after it.
    fn begin(&mut self, missing: &[u32]) -> anyhow::Result<Vec<u32>> {
        let path = self.plan.state();
        let (Some(&first), Some(&last), true) = (missing.first(), missing.last(), self.plan.goes_on()) else {
            return Ok(missing.to_vec());
        };
        let mut begin = self.plan.frames.start;
        if let Some(state) = AnimationState::load(&path)? {
            if let Some(other) = difference(&self.identity, &state.identity) {
                return Err(refusal(&path.display().to_string(), &other).into());
            }
            if (begin..first).contains(&state.frame) {
                // The next frame reads the positions of this one.
                self.pose(state.frame)?;
                let restored = self.session.restore(state.frame, &state.buffers);
                restored.map_err(|error| state::damaged(&path, error))?;
                begin = state.frame + 1;
            }
        }
        Ok((begin..=last).collect())
    }

    /// Renders the missing frames. Returns their records, and whether all frames exist.
    pub fn render(
        &mut self,
        missing: &[u32],
        is_interrupted: &dyn Fn() -> bool,
    ) -> anyhow::Result<(Vec<RenderedFrame>, bool)> {
        let frames = self.begin(missing)?;
        let path = self.plan.state();
        let bar = bar();
        let mut records: Vec<RenderedFrame> = Vec::with_capacity(frames.len());
        let mut saved = Instant::now();
        for (done, &frame) in frames.iter().enumerate() {
            bar.set_position(bar.length().unwrap_or(1) * done as u64 / frames.len() as u64);
            bar.set_message(format!("frame {frame}"));
            let last = records.last().map(|record| record.frame).filter(|_| self.plan.goes_on());
            let stop = is_interrupted();
            if let Some(last) = last.filter(|_| stop || saved.elapsed() >= self.plan.every) {
                let kept = self.save(last, &path);
                self.checkpoint_writer.keep(kept);
                saved = Instant::now();
            }
            if stop {
                bar.finish_and_clear();
                return Ok((records, false));
            }
            let start = Instant::now();
            self.pose(frame)?;
            let times = self.session.frame(frame)?;
            let wall = start.elapsed();
            let written = missing.binary_search(&frame).is_ok();
            let frame_info = (frame, self.plan.time_of(frame), written);
            records.push(RenderedFrame::new(frame_info, wall, &times, self.session.counters()?));
            if written {
                self.write(frame)?;
            }
        }
        bar.finish_and_clear();
        // Keep a state beyond the range: a longer run may resume from it.
        let end = self.plan.frames.end;
        let is_used = |state: AnimationState| state.frame < end && state.identity == self.identity;
        if AnimationState::load(&path).ok().flatten().is_some_and(is_used) {
            remove(&path)?;
        }
        Ok((records, true))
    }

    fn save(&mut self, frame: u32, path: &std::path::Path) -> anyhow::Result<()> {
        let buffers = self.session.state()?.into_iter().map(|(name, bytes)| (name.to_string(), bytes));
        AnimationState { identity: self.identity.clone(), frame, buffers: buffers.collect() }.save(path)
    }

    /// Writes the current frame.
    fn write(&mut self, frame: u32) -> anyhow::Result<()> {
        let mut image = self.session.image()?;
        image.auxiliary.keep(&self.plan.aov);
        let mut attributes = self.identity.clone();
        attributes.extend([
            ("frame".into(), frame.to_string()),
            ("time_s".into(), self.plan.time_of(frame).to_string()),
            ("commit".into(), program().commit.clone()),
        ]);
        attributes.extend(layer_attributes(&self.plan.aov, &self.scene));
        let path = self.plan.pattern.frame(frame, "exr");
        let target = Target::claim(&path, kept::is_damaged(&path))?;
        target.finish(&exr::encode(&image, None, &attributes)?)?;
        if self.plan.pngs {
            self.write_png(frame, &image)?;
        }
        Ok(())
    }

    fn write_png(&mut self, frame: u32, image: &RenderedImage) -> anyhow::Result<()> {
        // All frames share the exposure of the first one, which is written before all others.
        if self.plan.exposure == Exposure::Auto {
            let first = kept::image(&self.plan.pattern, self.plan.frames.start)?;
            self.plan.exposure = Exposure::Stops(self.plan.exposure.stops_for(&first));
        }
        self.session.expose(self.plan.exposure.stops_for(image) as f32);
        let colors = self.session.display(image)?;
        let bytes = png::encode(self.plan.config.width, self.plan.config.height, &colors)?;
        let path = self.plan.pattern.frame(frame, "png");
        if read_file(&path).is_ok_and(|there| there == bytes) {
            return Ok(());
        }
        Ok(Target::claim(&path, true)?.finish(&bytes)?)
    }

    /// Writes the PNGs of existing frames that lack one or have one of another exposure.
    pub fn write_kept_pngs(&mut self, missing: &[u32]) -> anyhow::Result<()> {
        for frame in self.plan.frames.clone().filter(|frame| missing.binary_search(frame).is_err()) {
            let image = kept::image(&self.plan.pattern, frame)?;
            self.write_png(frame, &image)?;
        }
        Ok(())
    }
}
