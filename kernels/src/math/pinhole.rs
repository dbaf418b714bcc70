//! The pinhole camera: from positions on the film (px; rows go down) to directions, and back.

use crate::interface::frame::{Camera, FrameParams, Window};
use spirv_std::glam::{Vec2, Vec3};

impl Camera {
    /// Unit direction that the film of a frame shows at a position.
    #[inline(always)]
    pub fn direction_of(&self, column: f32, row: f32, params: &FrameParams) -> Vec3 {
        let Window { film_width, film_height, .. } = params.window;
        let along_x = self.right * (2.0 * column / film_width as f32 - 1.0);
        let along_y = self.up * (1.0 - 2.0 * row / film_height as f32);
        (self.forward + along_x + along_y).normalize()
    }

    /// Position on the plane of the film of what lies along `from_eye`: x to the right and y up, 1 at the borders. The flag is
    /// false if that does not lie before the eye.
    #[inline(always)]
    pub fn on_plane(&self, from_eye: Vec3) -> (bool, Vec2) {
        let depth = from_eye.dot(self.forward);
        if depth <= 0.0 {
            return (false, Vec2::ZERO);
        }
        let x = from_eye.dot(self.right) / (depth * self.right.length_squared());
        let y = from_eye.dot(self.up) / (depth * self.up.length_squared());
        (true, Vec2::new(x, y))
    }

    /// Gradients of column and row on the film of a frame (px/m) by `from_eye`, which lies before the eye and is seen at
    /// `on_plane`.
    #[inline(always)]
    pub fn gradients(&self, from_eye: Vec3, on_plane: Vec2, params: &FrameParams) -> (Vec3, Vec3) {
        let per_metre = 0.5 / from_eye.dot(self.forward);
        let of_x = self.right / self.right.length_squared() - self.forward * on_plane.x;
        let of_y = self.up / self.up.length_squared() - self.forward * on_plane.y;
        let Window { film_width, film_height, .. } = params.window;
        (of_x * (film_width as f32 * per_metre), of_y * (-(film_height as f32) * per_metre))
    }
}

impl FrameParams {
    /// Position in the image (px) of a position on the film's plane.
    #[inline(always)]
    pub fn raster_position(&self, on_plane: Vec2) -> Vec2 {
        let Window { first_column, first_row, film_width, film_height } = self.window;
        let size = Vec2::new(film_width as f32, film_height as f32);
        let first = Vec2::new(first_column as f32, first_row as f32);
        Vec2::new(0.5 + 0.5 * on_plane.x, 0.5 - 0.5 * on_plane.y) * size - first
    }

    /// Whether a position (px) is in the image.
    #[inline(always)]
    pub fn shows(&self, position_px: Vec2) -> bool {
        let (width, height) = (self.width as f32, self.height as f32);
        position_px.x >= 0.0 && position_px.y >= 0.0 && position_px.x < width && position_px.y < height
    }
}
