//! Answers to queries of pages, between frames.

use anyhow::Context;
use caustics::output::png;
use caustics::scene::Edits;
use glam::Vec3;

use super::Engine;
use crate::command::console::error_chain;
use crate::command::view::look::DisplayedImage;
use crate::command::view::pick::picked;
use crate::command::view::render_job::RenderJob;
use crate::command::view::save;
use crate::command::view::shared::{Answer, Content, Query};

/// Maximum number of light paths to show for a pixel's photons.
const LIGHT_PATHS: usize = 8;

impl Engine<'_> {
    /// Returns the answer to a query.
    pub(super) fn answer(&mut self, query: &Query) -> Answer {
        let bytes = match query {
            Query::Pick(image_position) => self.pick(*image_position),
            Query::Inspect(image_position) => self.inspect(*image_position),
            Query::Node(node) => {
                serde_json::to_vec(&self.edited.node_info(*node, self.time)).map_err(anyhow::Error::from)
            }
            Query::Exr => self.exr(),
            Query::Png => self.png(),
            Query::Edits => return edits_answer(Ok(self.edited.edits(&self.shared.request().camera))),
            Query::Recording => return edits_answer(self.recorded()),
        };
        bytes.map(Content::Bytes).map_err(|error| error_chain(&error))
    }

    fn pick(&mut self, image_position: [f64; 2]) -> anyhow::Result<Vec<u8>> {
        let request = self.shared.request();
        let camera = self.camera(&request)?;
        let picked = picked(&self.edited.scene, &camera, request.size, image_position);
        Ok(serde_json::to_vec(&picked)?)
    }

    /// Returns the render job of the image, if it has frames.
    fn converged(&mut self) -> anyhow::Result<&mut RenderJob> {
        let standing = self.stands.is_some();
        let job = self.still[0].as_mut().filter(|job| standing && job.sums.frames() > 0);
        job.context("there is no image yet; wait until nothing moves, and end the pause")
    }

    fn inspect(&mut self, image_position: [f64; 2]) -> anyhow::Result<Vec<u8>> {
        self.converged()?;
        let job = self.still[0].as_mut().context("a session was opened")?;
        let [x, y] = [0, 1].map(|axis| {
            let size = job.configuration.size[axis];
            // Clamp positions beyond the image to its border.
            ((image_position[axis] * f64::from(size)) as u32).min(size - 1)
        });
        let found = job.opened.session.inspect(&self.edited.scene, x, y, LIGHT_PATHS)?;
        Ok(serde_json::to_vec(&found)?)
    }

    fn exr(&mut self) -> anyhow::Result<Vec<u8>> {
        let request = self.shared.request();
        let camera = self.camera(&request)?;
        self.converged()?;
        if self.edited.is_edited() {
            // The file of edits also holds the camera, so the fingerprint covers it.
            let edits = self.edited.edits(&request.camera).fingerprint();
            self.edited.scene.additions.insert("edits", edits);
        }
        let job = self.still[0].as_ref().context("a session was opened")?;
        save::exr(job, &self.edited.scene, &camera.name, &self.edited.file)
    }

    fn recorded(&self) -> anyhow::Result<Edits> {
        if self.recording.len() < 2 {
            anyhow::bail!("the recording has no movement; record an orbit or a drag");
        }
        Ok(self.edited.recorded(self.recording.keys()))
    }

    fn png(&mut self) -> anyhow::Result<Vec<u8>> {
        let look = self.shared.request().look;
        let suits = self.suits.unwrap_or_default();
        let raster = look.raster(&DisplayedImage { suits, ..self.converged()?.mean(look.layer) });
        let colors = raster.bytes.as_chunks::<3>().0.iter().map(|pixel| {
            let [r, g, b] = pixel.map(f32::from);
            Vec3::new(r, g, b) / 255.0
        });
        Ok(png::encode(raster.width, raster.height, &colors.collect::<Vec<_>>())?)
    }
}

/// Checks edits; their text is made while it is sent.
fn edits_answer(edits: anyhow::Result<Edits>) -> Answer {
    let edits = edits.and_then(|edits| edits.check().map(|()| edits).map_err(anyhow::Error::from));
    edits.map(|edits| Content::Edits(Box::new(edits))).map_err(|error| error_chain(&error))
}
