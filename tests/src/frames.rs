//! Consecutive frames of a view, as an animation renders them.

use caustics::render_config::RenderConfig;
use caustics::scene::{Scene, SceneCamera};
use caustics::session::{RunnerChoice, Session};
use caustics_kernels::gather::variant::PHOTONS_GRID;
use caustics_kernels::history::History;
use caustics_kernels::interface::history::HistoryPoint;
use glam::Vec3;

/// Frames of OurBasic with a history.
pub struct Frames {
    /// The session.
    pub session: Session,
    /// Index of the next frame.
    pub next: u32,
}

impl Frames {
    /// Opens a session on the CPU for the first camera of a scene.
    pub fn new(scene: &Scene, config: &RenderConfig, history: &'static History) -> Frames {
        Frames::open(&RunnerChoice::Cpu { threads: 0 }, scene, config, history)
    }

    /// Opens a session on a runner for the first camera of a scene.
    pub fn open(
        choice: &RunnerChoice,
        scene: &Scene,
        config: &RenderConfig,
        history: &'static History,
    ) -> Frames {
        let config = RenderConfig { history, gather: Some(&PHOTONS_GRID), ..config.clone() };
        let features = scene.features(config.specular_roughness);
        let camera = &scene.cameras[0];
        let session = Session::new(choice, scene, camera, &config, features).expect("a session opens");
        Frames { session, next: 0 }
    }

    /// Renders the next frame and returns its caustics.
    pub fn render(&mut self) -> Vec<Vec3> {
        self.session.frame(self.next).expect("a frame runs");
        self.next += 1;
        self.session.read("caustic_radiance").expect("caustics")
    }

    /// Renders the next frame of a posed scene and returns its caustics.
    pub fn pose(&mut self, scene: &Scene, camera: &SceneCamera) -> Vec<Vec3> {
        self.session.pose(scene, camera).expect("a pose");
        self.render()
    }

    /// Reads the history that the last frame leaves to the next one.
    pub fn history(&mut self) -> Vec<HistoryPoint> {
        self.session.read("history_points").expect("a history")
    }
}

/// Sum of the channels of each pixel.
pub fn sums(layer: &[Vec3]) -> Vec<f64> {
    layer.iter().map(|v| f64::from(v.element_sum())).collect()
}

/// Pixels within `side` pixels of a pixel in each direction, itself included, in an image of this width and height.
pub fn around(pixel: usize, side: usize, (width, height): (usize, usize)) -> Vec<usize> {
    let (column, row) = (pixel % width, pixel / width);
    let rows = row.saturating_sub(side)..=(row + side).min(height - 1);
    let columns = || column.saturating_sub(side)..=(column + side).min(width - 1);
    rows.flat_map(|row| columns().map(move |column| row * width + column)).collect()
}
