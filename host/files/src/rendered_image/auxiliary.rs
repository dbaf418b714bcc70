//! Auxiliary layers of an image, made on demand for other tools.

use caustics_kernels::interface::auxiliary::Auxiliary as Pixel;
use clap::ValueEnum;
use glam::{DVec3, Vec2, Vec3};

/// A layer for other tools.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Aov {
    /// Unit shading normal, on the viewer's side
    Normal,
    /// Base colour of the material, linear
    Albedo,
    /// Length of the path from the camera (m)
    Depth,
    /// Position in the file's coordinates (m)
    Position,
    /// Way from the image before (px), to the right and down
    Motion,
    /// Index of the material
    Material,
    /// Number of the radiance cache's cell
    Cell,
}

impl Aov {
    /// Returns the layer's name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Aov::Normal => "normal",
            Aov::Albedo => "albedo",
            Aov::Depth => "depth",
            Aov::Position => "position",
            Aov::Motion => "motion",
            Aov::Material => "material",
            Aov::Cell => "cell",
        }
    }
}

/// Value of `material` and of `cell` where a pixel has no collection point.
pub const NO_MATERIAL: f32 = -1.0;

/// Auxiliary layers of an image's collection points, which are the first non-specular vertices of the camera paths. Mirrors
/// and glass show the surfaces behind them.
/// A pixel without a collection point has zeros. A layer that was not requested is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Auxiliary {
    /// Shading normal, on the viewer's side, of unit length in one frame.
    pub normal: Vec<Vec3>,
    /// Base colour of the material.
    pub albedo: Vec<Vec3>,
    /// Length of the camera path (m).
    pub depth: Vec<f32>,
    /// Position in the file's coordinates (m).
    pub position: Vec<Vec3>,
    /// Position in this image less the position in the image before (px); x to the right, y down.
    pub motion: Vec<Vec2>,
    /// Index of the material in the scene; [`NO_MATERIAL`] where there is none.
    pub material: Vec<f32>,
    /// Number of the radiance cache's cell around the position; [`NO_MATERIAL`] where there is none.
    pub cell: Vec<f32>,
}

impl Auxiliary {
    /// Converts the kernels' records of pixels. The scene's coordinates are relative to `origin` (m).
    pub fn new(pixels: &[Pixel], origin: DVec3) -> Auxiliary {
        let file_position = |pixel: &Pixel| (pixel.position.as_dvec3() + origin).as_vec3();
        let is_there = |pixel: &Pixel| pixel.depth > 0.0;
        let number = |pixel: &Pixel, number: u32| if is_there(pixel) { number as f32 } else { NO_MATERIAL };
        Auxiliary {
            normal: pixels.iter().map(|pixel| pixel.normal).collect(),
            albedo: pixels.iter().map(|pixel| pixel.albedo).collect(),
            depth: pixels.iter().map(|pixel| pixel.depth).collect(),
            position: pixels
                .iter()
                .map(|pixel| if is_there(pixel) { file_position(pixel) } else { Vec3::ZERO })
                .collect(),
            motion: pixels.iter().map(|pixel| pixel.motion).collect(),
            material: pixels.iter().map(|pixel| number(pixel, pixel.material)).collect(),
            cell: pixels.iter().map(|pixel| number(pixel, pixel.cell)).collect(),
        }
    }

    /// Appends the layers of the rows below.
    pub fn append(&mut self, below: Auxiliary) {
        let Auxiliary { normal, albedo, depth, position, motion, material, cell } = below;
        self.normal.extend(normal);
        self.albedo.extend(albedo);
        self.depth.extend(depth);
        self.position.extend(position);
        self.motion.extend(motion);
        self.material.extend(material);
        self.cell.extend(cell);
    }

    /// Drops all layers but these.
    pub fn keep(&mut self, layers: &[Aov]) {
        let Auxiliary { normal, albedo, depth, position, motion, material, cell } = std::mem::take(self);
        let kept = |layer: Aov| layers.contains(&layer);
        let or_none = |layer, values: Vec<Vec3>| if kept(layer) { values } else { Vec::new() };
        let number_or_none = |layer, values: Vec<f32>| if kept(layer) { values } else { Vec::new() };
        *self = Auxiliary {
            normal: or_none(Aov::Normal, normal),
            albedo: or_none(Aov::Albedo, albedo),
            depth: number_or_none(Aov::Depth, depth),
            position: or_none(Aov::Position, position),
            motion: if kept(Aov::Motion) { motion } else { Vec::new() },
            material: number_or_none(Aov::Material, material),
            cell: number_or_none(Aov::Cell, cell),
        };
    }

    /// Whether all layers are empty.
    pub fn is_empty(&self) -> bool {
        *self == Auxiliary::default()
    }

    /// Returns the channels of all layers by their names in a file.
    pub fn channels(&self) -> Vec<(String, Vec<f32>)> {
        const XYZ: &[&str] = &["X", "Y", "Z"];
        let layers: [(Aov, &[&str], &[f32]); 7] = [
            (Aov::Normal, XYZ, bytemuck::cast_slice(&self.normal)),
            (Aov::Albedo, &["R", "G", "B"], bytemuck::cast_slice(&self.albedo)),
            (Aov::Depth, &["Z"], &self.depth),
            (Aov::Position, XYZ, bytemuck::cast_slice(&self.position)),
            (Aov::Motion, &["X", "Y"], bytemuck::cast_slice(&self.motion)),
            (Aov::Material, &["V"], &self.material),
            (Aov::Cell, &["V"], &self.cell),
        ];
        let of_layer = |(layer, channels, values): (Aov, &'static [&str], &[f32])| {
            let values = values.to_vec();
            channels.iter().enumerate().map(move |(channel, name)| {
                let own = values.iter().skip(channel).step_by(channels.len()).copied().collect();
                (format!("{}.{name}", layer.name()), own)
            })
        };
        layers.into_iter().filter(|(.., values)| !values.is_empty()).flat_map(of_layer).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_have_their_command_line_names_and_dropped_layers_have_no_channel() {
        for layer in Aov::value_variants() {
            assert_eq!(layer.to_possible_value().unwrap().get_name(), layer.name());
        }
        let there = Pixel {
            position: Vec3::new(1.0, 2.0, 3.0),
            depth: 4.0,
            material: 5,
            cell: 8,
            motion: Vec2::new(6.0, 7.0),
            ..Pixel::default()
        };
        let mut auxiliary = Auxiliary::new(&[there, Pixel::default()], DVec3::new(0.0, 100.0, 0.0));
        assert_eq!(auxiliary.channels().len(), 14);
        auxiliary.keep(&[Aov::Material, Aov::Position, Aov::Motion, Aov::Cell]);
        let channels = auxiliary.channels();
        let expected = [
            ("position.X", [1.0, 0.0]),
            ("position.Y", [102.0, 0.0]),
            ("position.Z", [3.0, 0.0]),
            ("motion.X", [6.0, 0.0]),
            ("motion.Y", [7.0, 0.0]),
            ("material.V", [5.0, NO_MATERIAL]),
            ("cell.V", [8.0, NO_MATERIAL]),
        ];
        assert!(
            channels
                .iter()
                .map(|(name, values)| (name.as_str(), &values[..]))
                .eq(expected.iter().map(|(name, values)| (*name, &values[..])))
        );
    }
}
