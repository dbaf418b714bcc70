//! Images of the report. Each PNG is stored once, however many elements show it.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use anyhow::Context;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use caustics::file::read_file;

/// An image that is in the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReportImage {
    id: usize,
    /// Width (px).
    pub width: u32,
    /// Height (px).
    pub height: u32,
}

impl ReportImage {
    /// Reference to the image for other elements.
    pub fn reference(&self) -> String {
        format!("#image-{}", self.id)
    }

    /// Element that shows the image, with a description.
    pub fn show(&self, description: &str) -> Markup {
        html! {
            svg .image viewBox=(format!("0 0 {} {}", self.width, self.height)) role="img" aria-label=(description) {
                use href=(self.reference()) {}
            }
        }
    }
}

/// All images of a report.
#[derive(Debug, Default)]
pub struct ReportImages {
    /// By path; none where the file is missing.
    known: BTreeMap<PathBuf, Option<ReportImage>>,
    /// By content.
    ids: HashMap<Vec<u8>, ReportImage>,
    /// Data URL and size of each.
    all: Vec<(String, ReportImage)>,
    /// Paths of missing files.
    pub missing: Vec<PathBuf>,
}

impl ReportImages {
    /// Returns the image of a file; none where the file is missing. A file that is not a PNG is an error.
    pub fn get(&mut self, path: &Path) -> anyhow::Result<Option<ReportImage>> {
        if let Some(known) = self.known.get(path) {
            return Ok(*known);
        }
        let image = match read_file(path) {
            Ok(bytes) => Some(self.add(path, bytes)?),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                self.missing.push(path.into());
                None
            }
            Err(error) => return Err(error).with_context(|| format!("cannot read {}", path.display())),
        };
        self.known.insert(path.into(), image);
        Ok(image)
    }

    fn add(&mut self, path: &Path, bytes: Vec<u8>) -> anyhow::Result<ReportImage> {
        if let Some(image) = self.ids.get(&bytes) {
            return Ok(*image);
        }
        // Decode the whole file: a browser shows half of a truncated one without an error.
        let decoded = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png)
            .with_context(|| format!("{} is no PNG; measure its run configuration again", path.display()))?;
        let image = ReportImage { id: self.all.len(), width: decoded.width(), height: decoded.height() };
        self.all.push((format!("data:image/png;base64,{}", STANDARD.encode(&bytes)), image));
        self.ids.insert(bytes, image);
        Ok(image)
    }

    /// Hidden element that holds all images once; other elements refer to them.
    pub fn store(&self) -> Markup {
        html! {
            svg .store width="0" height="0" aria-hidden="true" {
                defs {
                    @for (address, image) in &self.all {
                        image id=(format!("image-{}", image.id)) width=(image.width) height=(image.height)
                            href=(address) {}
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics::output::png;
    use glam::Vec3;

    fn save(folder: &Path, name: &str, level: f32) -> PathBuf {
        let path = folder.join(name);
        std::fs::write(&path, png::encode(3, 2, &[Vec3::splat(level); 6]).unwrap()).unwrap();
        path
    }

    #[test]
    fn equal_images_are_in_the_report_once() {
        let folder = tempfile::tempdir().unwrap();
        let mut images = ReportImages::default();
        let [a, b, c] = [("a.png", 0.2), ("b.png", 0.2), ("c.png", 0.7)]
            .map(|(name, level)| save(folder.path(), name, level));
        let [a, b, c] = [a, b, c].map(|path| images.get(&path).unwrap().unwrap());
        assert_eq!((a, a.width, a.height), (b, 3, 2));
        assert_ne!(a, c);
        assert_eq!(images.store().into_string().matches("data:image/png;base64,").count(), 2);
    }

    #[test]
    fn missing_images_are_listed_and_damaged_ones_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let mut images = ReportImages::default();
        let nowhere = folder.path().join("nowhere.png");
        for _ in 0..2 {
            assert_eq!(images.get(&nowhere).unwrap(), None);
        }
        assert_eq!(images.missing, [nowhere]);
        let whole = save(folder.path(), "half.png", 0.5);
        let bytes = std::fs::read(&whole).unwrap();
        std::fs::write(&whole, &bytes[..bytes.len() - 20]).unwrap();
        let error = format!("{:#}", images.get(&whole).unwrap_err());
        assert!(error.contains("half.png"), "{error}");
    }
}
