//! Inspects a pixel: reads the frame's buffers and traces the paths again.

use std::ops::Range;

use caustics_kernels::declare::{BufferError, Buffers};
use caustics_kernels::gather::accumulator;
use caustics_kernels::interface::frame::FrameParams;
use caustics_kernels::interface::point::{PointGeometry, PointShading};
use caustics_kernels::light::emit::Emit;

use super::photons::{GatheredPhoton, Taker, choose};
use super::view::InspectedFrame;
use super::{Inspection, LightPath, Photons, camera, light};
use crate::runner::RunError;
use crate::session::last::{Last, Starts};
use crate::session::{Session, SessionError};
use caustics_scene::Scene;

/// Range of light paths and the buffers that emit them.
struct Group {
    paths: Range<u32>,
    starts: Buffers,
}

impl Group {
    fn new(paths: Range<u32>, starts: &Starts) -> Result<Group, BufferError> {
        let mut buffers = Buffers::default();
        for (name, bytes) in starts {
            buffers.add(name, bytes.len())?;
            buffers.write(name, 0, bytes)?;
        }
        Ok(Group { paths, starts: buffers })
    }
}

impl Session {
    /// Inspects a pixel of the last frame; `scene` must be the scene of that frame. It describes at most `light_paths` of
    /// the point's photons, each with its light path.
    /// The selection is spread over all photons and is denser where they contribute more. All light paths of the frame are
    /// traced again on the CPU.
    ///
    /// # Errors
    ///
    /// - If no frame was rendered since the scene changed, or the image has several tiles.
    /// - If the pixel is outside of the image.
    /// - If a buffer cannot be read.
    pub fn inspect(
        &mut self,
        scene: &Scene,
        x: u32,
        y: u32,
        light_paths: usize,
    ) -> Result<Inspection, SessionError> {
        if self.tiles() > 1 {
            return Err(SessionError::Tiles);
        }
        let last = self.last().cloned().ok_or(SessionError::NoFrame)?;
        let (method, _, features) = self.made_of();
        let view = InspectedFrame { scene, params: &last.params, features };
        let FrameParams { width, height, frame, .. } = last.params;
        if x >= width || y >= height {
            return Err(SessionError::NoPixel { x, y, width, height });
        }
        let pixel = y * width + x;
        let mut inspection = Inspection {
            pixel: [x, y],
            frame,
            camera_path: camera::path(view, pixel, method.gathers),
            point: None,
            photons: None,
            light_paths: Vec::new(),
            shared_light: None,
        };
        if method.gathers {
            let geometry = self.read::<PointGeometry>("point_geometry")?[pixel as usize];
            let shading = self.read::<PointShading>("point_shading")?[pixel as usize];
            let taker = Taker { view, geometry, shading };
            inspection.point = taker.point();
            inspection.shared_light = self.shared_light(pixel, &taker)?;
            if method.chooses_gather {
                let words = self.read::<u32>("accumulator")?;
                let gathered = words[((pixel + 1) * accumulator::WORDS - 1) as usize];
                let (photons, paths) = self.taken(&last, &taker, light_paths)?;
                inspection.photons = Some(Photons { gathered, ..photons });
                inspection.light_paths = paths;
            }
        }
        Ok(inspection)
    }

    /// Finds the photons of a point, and traces the light paths of some.
    fn taken(
        &mut self,
        last: &Last,
        taker: &Taker<'_>,
        max_count: usize,
    ) -> Result<(Photons, Vec<LightPath>), SessionError> {
        let groups = if taker.geometry.exists() { self.groups(last)? } else { Vec::new() };
        let mut found: Vec<GatheredPhoton> = Vec::new();
        for Group { paths, starts } in &groups {
            self.emit(taker.view, starts, |emit| found.extend(taker.find(paths.clone(), emit)))?;
        }
        let some = choose(&found, max_count);
        let mut light_paths = Vec::with_capacity(some.len());
        for Group { paths, starts } in &groups {
            let own = some.iter().filter(|found| paths.contains(&found.path));
            self.emit(taker.view, starts, |emit| {
                light_paths.extend(own.clone().map(|found| light::path(taker.view, emit, found)));
            })?;
        }
        let traced = groups.iter().map(|group| group.paths.len() as u32).sum();
        let all = if taker.geometry.exists() { last.params.light_path_count } else { 0 };
        let (flux, radiance) = taker.sum(&found);
        let photons = Photons {
            gathered: 0,
            count: found.len() as u32,
            light_paths: traced,
            skipped: all - traced,
            flux,
            radiance,
            some: some.iter().map(|found| taker.describe(found)).collect(),
        };
        Ok((photons, light_paths))
    }

    /// Returns the light paths of a frame that can be traced again, in order.
    fn groups(&mut self, last: &Last) -> Result<Vec<Group>, SessionError> {
        let (before, all) = (last.started_before, last.params.light_path_count);
        let kept = last.starts_before.as_ref().map(|starts| (0..before, starts));
        let now = self.starts()?;
        let groups = kept.into_iter().chain([(before..all, &now)]).filter(|(paths, _)| !paths.is_empty());
        let groups = groups.map(|(paths, starts)| Group::new(paths, starts).map_err(RunError::from));
        Ok(groups.collect::<Result<_, _>>()?)
    }

    /// Calls `then` with the emission that starts light paths.
    fn emit(
        &self,
        view: InspectedFrame<'_>,
        buffers: &Buffers,
        mut then: impl FnMut(&(dyn Emit + Sync)),
    ) -> Result<(), SessionError> {
        let InspectedFrame { scene, params, features } = view;
        let (_, parts, _) = self.made_of();
        let started = (parts.emission.starts)(scene.tables(), params, features, buffers, &mut then);
        let pass = parts.emission.shoot.name.to_string();
        started.map_err(|source| RunError::Pass { pass, source }.into())
    }
}
