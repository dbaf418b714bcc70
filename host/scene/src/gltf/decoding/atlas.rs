//! Images of vertex colours: two by two texels a triangle. Three texel centres are the triangle's corners, and the fourth
//! completes a parallelogram. The texture interpolates like the vertex colours.

use glam::Vec2;

use crate::texture::{Image, MAX_SIDE, srgb};

/// Layout of triangles on an image of vertex colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Atlas {
    /// Number of triangles in a row of the image.
    columns: u32,
    /// Number of rows of triangles.
    rows: u32,
}

impl Atlas {
    /// Creates an atlas for a number of triangles; `None` for no triangles, or for more than an image holds.
    pub fn for_triangles(triangles: usize) -> Option<Atlas> {
        let columns = (triangles as f64).sqrt().ceil() as usize;
        let max_columns = MAX_SIDE as usize / 2;
        if columns == 0 || columns > max_columns {
            return None;
        }
        Some(Atlas { columns: columns as u32, rows: triangles.div_ceil(columns) as u32 })
    }

    /// Number of texels of the image.
    pub fn texels(&self) -> u64 {
        4 * u64::from(self.columns) * u64::from(self.rows)
    }

    /// Texture coordinates of a triangle's corners.
    pub fn corners(&self, triangle: usize) -> [Vec2; 3] {
        let (column, row) = (triangle as u32 % self.columns, triangle as u32 / self.columns);
        let size = Vec2::new((2 * self.columns) as f32, (2 * self.rows) as f32);
        let first = Vec2::new((2 * column) as f32 + 0.5, (2 * row) as f32 + 0.5);
        [first, first + Vec2::X, first + Vec2::Y].map(|texel| texel / size)
    }

    /// Image of triangles with these linear colours (and alpha) at their corners.
    pub fn image(&self, faces: &[[u32; 3]], colors: &[[f32; 4]]) -> Image {
        let (width, height) = (2 * self.columns, 2 * self.rows);
        let mut texels = vec![[255; 4]; width as usize * height as usize];
        for (triangle, face) in faces.iter().enumerate() {
            let [a, b, c] = face.map(|id| colors[id as usize]);
            let d = std::array::from_fn(|channel| b[channel] + c[channel] - a[channel]);
            let (column, row) =
                (2 * (triangle % self.columns as usize), 2 * (triangle / self.columns as usize));
            for (color, right, down) in [(a, 0, 0), (b, 1, 0), (c, 0, 1), (d, 1, 1)] {
                texels[(row + down) * width as usize + column + right] = encoded(color);
            }
        }
        Image { width, height, texels }
    }
}

/// Encodes a linear colour in bytes (sRGB).
fn encoded([red, green, blue, alpha]: [f32; 4]) -> [u8; 4] {
    let byte = |share: f32| (share * 255.0).round().clamp(0.0, 255.0) as u8;
    let [red, green, blue] = [red, green, blue].map(|linear| byte(srgb::encoded(linear)));
    [red, green, blue, byte(alpha)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_lie_on_the_texels_of_their_colours() {
        let colors = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 0.0], [0.0; 4]];
        let faces: Vec<[u32; 3]> = (0..7).map(|id| [id % 4, (id + 1) % 4, (id + 2) % 4]).collect();
        let atlas = Atlas::for_triangles(faces.len()).unwrap();
        let image = atlas.image(&faces, &colors);
        assert_eq!(image.texels.len() as u64, atlas.texels());
        for (triangle, face) in faces.iter().enumerate() {
            for (at, id) in atlas.corners(triangle).into_iter().zip(face) {
                let texel = at * Vec2::new(image.width as f32, image.height as f32);
                let index = texel.y as usize * image.width as usize + texel.x as usize;
                assert_eq!(image.texels[index], encoded(colors[*id as usize]), "{triangle}");
                assert!((texel.fract() - 0.5).length() < 1e-3);
            }
        }
        assert!(Atlas::for_triangles(0).is_none() && Atlas::for_triangles(1 << 30).is_none());
    }
}
