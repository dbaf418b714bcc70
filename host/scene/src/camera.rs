//! Cameras of a scene, and their camera records for images of a given size.

use caustics_kernels::interface::frame::Camera;
use glam::{DAffine3, DVec3, Vec3};

/// A perspective camera in the recentred scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// Name of the node, or of the camera if the node has none.
    pub name: String,
    /// Eye position (m).
    pub position: Vec3,
    /// Unit direction to the image's right.
    pub right: Vec3,
    /// Unit direction to the image's top.
    pub up: Vec3,
    /// Unit viewing direction.
    pub forward: Vec3,
    /// Vertical field of view (rad), in (0, pi).
    pub fov_y: f32,
    /// Aspect ratio (width over height) that the file suggests.
    pub aspect: Option<f32>,
}

impl SceneCamera {
    /// Creates a camera at `position` that looks at `target`, with `up` upwards.
    pub fn look_at(name: &str, position: Vec3, target: Vec3, up: Vec3, fov_y: f32) -> Self {
        let forward = (target - position).normalize();
        let right = forward.cross(up).normalize();
        let up = right.cross(forward);
        SceneCamera { name: name.into(), position, right, up, forward, fov_y, aspect: None }
    }

    /// Places the camera on a node, in a world recentred to `origin` (m).
    pub fn placed(&self, to_world: &DAffine3, origin: DVec3) -> Self {
        let forward = -to_world.matrix3.z_axis.normalize();
        let right = forward.cross(to_world.matrix3.y_axis).normalize();
        SceneCamera {
            position: (to_world.translation - origin).as_vec3(),
            right: right.as_vec3(),
            up: right.cross(forward).as_vec3(),
            forward: forward.as_vec3(),
            ..self.clone()
        }
    }

    /// Camera record of an image of this size (px). The vertical field of view stays; pixels are square.
    pub fn camera(&self, width: u32, height: u32) -> Camera {
        let tan_y = (0.5 * self.fov_y).tan();
        let tan_x = tan_y * width as f32 / height as f32;
        Camera {
            position: self.position,
            right: self.right * tan_x,
            up: self.up * tan_y,
            forward: self.forward,
        }
    }

    /// Spread of a pixel's ray cone (rad) (ray cones eq. 30).
    pub fn pixel_spread(&self, _width: u32, height: u32) -> f32 {
        (2.0 * (0.5 * self.fov_y).tan() / height as f32).atan()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn square_pixels_keep_the_vertical_field() {
        let camera = SceneCamera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
        assert_eq!((camera.right, camera.up), (Vec3::X, Vec3::Y));
        let wide = camera.camera(200, 100);
        assert_eq!(wide.right.length(), 2.0 * wide.up.length());
        assert_eq!(wide.up.y, 0.5_f32.tan());
        assert!((camera.pixel_spread(200, 100) - 0.01 * 2.0 * 0.5_f32.tan()).abs() < 1e-6);
    }
}
