//! What pages ask for between frames.

use anyhow::Context;
use caustics::output::png;
use caustics::scene::Edits;
use glam::Vec3;

use super::Engine;
use crate::command::say::told;
use crate::command::view::lane::Lane;
use crate::command::view::look::Shown;
use crate::command::view::pick::picked;
use crate::command::view::save;
use crate::command::view::shared::{Answer, Asked, Content};

/// Light paths that are shown of a pixel's photons.
const LIGHT_PATHS: usize = 8;

impl Engine<'_> {
    /// The answer to a page.
    pub(super) fn answer(&mut self, asked: &Asked) -> Answer {
        let bytes = match asked {
            Asked::Pick(image_position) => self.pick(*image_position),
            Asked::Inspect(image_position) => self.inspect(*image_position),
            Asked::Node(node) => {
                serde_json::to_vec(&self.edited.told(*node, self.time)).map_err(anyhow::Error::from)
            }
            Asked::Exr => self.exr(),
            Asked::Png => self.png(),
            Asked::Edits => return edits_answer(Ok(self.edited.edits(&self.shared.wish().camera))),
            Asked::Recording => return edits_answer(self.recorded()),
        };
        bytes.map(Content::Bytes).map_err(|error| told(&error))
    }

    fn pick(&mut self, image_position: [f64; 2]) -> anyhow::Result<Vec<u8>> {
        let wish = self.shared.wish();
        let camera = self.camera(&wish)?;
        let picked = picked(&self.edited.scene, &camera, wish.size, image_position);
        Ok(serde_json::to_vec(&picked)?)
    }

    /// The lane of the image, if it has frames.
    fn converged(&mut self) -> anyhow::Result<&mut Lane> {
        let standing = self.stands.is_some();
        let lane = self.still[0].as_mut().filter(|lane| standing && lane.sums.frames() > 0);
        lane.context("there is no image yet: wait until all stands still, and is not paused")
    }

    fn inspect(&mut self, image_position: [f64; 2]) -> anyhow::Result<Vec<u8>> {
        self.converged()?;
        let lane = self.still[0].as_mut().context("a session was opened")?;
        let [x, y] = [0, 1].map(|axis| {
            let size = lane.configuration.size[axis];
            // A position beyond the image is its border.
            ((image_position[axis] * f64::from(size)) as u32).min(size - 1)
        });
        let found = lane.opened.session.inspect(&self.edited.scene, x, y, LIGHT_PATHS)?;
        Ok(serde_json::to_vec(&found)?)
    }

    fn exr(&mut self) -> anyhow::Result<Vec<u8>> {
        let wish = self.shared.wish();
        let camera = self.camera(&wish)?;
        self.converged()?;
        if self.edited.is_edited() {
            // The file of edits has the camera too, and is known by all of it.
            let edits = self.edited.edits(&wish.camera).fingerprint();
            self.edited.scene.additions.insert("edits", edits);
        }
        let lane = self.still[0].as_ref().context("a session was opened")?;
        save::exr(lane, &self.edited.scene, &camera.name, &self.edited.file)
    }

    fn recorded(&self) -> anyhow::Result<Edits> {
        if self.recording.len() < 2 {
            anyhow::bail!("nothing that moved was recorded");
        }
        Ok(self.edited.recorded(self.recording.keys()))
    }

    fn png(&mut self) -> anyhow::Result<Vec<u8>> {
        let look = self.shared.wish().look;
        let suits = self.suits.unwrap_or_default();
        let raster = look.to_raster(&Shown { suits, ..self.converged()?.mean(look.layer) });
        let colors = raster.bytes.as_chunks::<3>().0.iter().map(|pixel| {
            let [r, g, b] = pixel.map(f32::from);
            Vec3::new(r, g, b) / 255.0
        });
        Ok(png::encode(raster.width, raster.height, &colors.collect::<Vec<_>>())?)
    }
}

/// Edits that can be used; their text is made while it is sent.
fn edits_answer(edits: anyhow::Result<Edits>) -> Answer {
    let edits = edits.and_then(|edits| edits.check().map(|()| edits).map_err(anyhow::Error::from));
    edits.map(|edits| Content::Edits(Box::new(edits))).map_err(|error| told(&error))
}
