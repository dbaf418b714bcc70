//! Recorder of a path's vertices while the kernels' code traces it.

use caustics_kernels::interface::NONE;
use caustics_kernels::interface::features::Features;
use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::ray::{Hit, Ray};
use caustics_kernels::math::offset;
use caustics_kernels::path::observer::{CollectionPoint, PathObserver};
use caustics_kernels::surface::class::Classes;
use caustics_kernels::surface::scatter::BsdfSample;
use caustics_kernels::surface::textured::material_at;
use caustics_kernels::surface::vertex::{Vertex as Here, vertex};
use caustics_kernels::texture::cut_out::{CutOuts, SOME_ARE_NOT_THERE};
use caustics_kernels::trace::Tracer;
use glam::Vec3;

use super::Vertex;
use super::event::{Event, event, passed};
use super::view::InspectedFrame;

/// Maximum number of faces that a segment is followed through. It only bounds the loop.
const MAX_PASSED: usize = 256;

/// Path observer that records vertices.
pub struct PathRecorder<'a> {
    view: InspectedFrame<'a>,
    /// Recorded vertices and faces.
    pub vertices: Vec<Vertex>,
    /// Last vertex and its material.
    here: Option<(Here, Material)>,
    /// Ray that left the scene.
    pub left: Option<Ray>,
    /// Whether the path has reached a collection point.
    pub has_point: bool,
}

impl<'a> PathRecorder<'a> {
    pub fn new(view: InspectedFrame<'a>) -> PathRecorder<'a> {
        PathRecorder { view, vertices: Vec::new(), here: None, left: None, has_point: false }
    }

    /// Sets the event of the last vertex.
    pub fn end(&mut self, event: Event) {
        if let Some(vertex) = self.vertices.last_mut() {
            vertex.event = event;
        }
    }

    /// Whether the last event is a non-specular scattering.
    pub fn is_scattered(&self) -> bool {
        let last = self.vertices.last().filter(|_| self.left.is_none());
        last.is_some_and(|vertex| !vertex.specular && !vertex.lobes.is_empty())
    }

    fn vertex(&self, here: &Here, hit: &Hit, event: Event, carries: Vec3) -> Vertex {
        let InspectedFrame { scene, features, .. } = self.view;
        let channels = ["red", "green", "blue"].into_iter().zip(carries.to_array());
        let mut carried = channels.filter(|(_, carries)| *carries > 0.0).map(|(name, _)| name);
        let only = carried.next().filter(|_| carried.next().is_none());
        Vertex {
            position: self.view.file_position(here.position),
            normal: here.face_normal.to_array(),
            event,
            lobes: Vec::new(),
            specular: false,
            material: scene.material_name(here.material).into(),
            material_index: scene.materials[here.material as usize].medium,
            instance: hit.instance,
            triangle: hit.triangle,
            carries: carries.to_array(),
            channel: only.filter(|_| features.has(Features::DISPERSION)),
        }
    }

    /// Records the faces that a ray passes before a hit: holes, blended surfaces, and faces within a medium of higher
    /// priority.
    fn pass(&mut self, ray: &Ray, hit: &Hit, carries: Vec3) {
        let InspectedFrame { scene, features, .. } = self.view;
        if !features.has(SOME_ARE_NOT_THERE | Features::NESTED) {
            return;
        }
        let (tables, bare) = (scene.tables(), Features(features.0 & Features::INSTANCES.0));
        let cut_outs = CutOuts::new(tables, features);
        let mut tracer = scene.tracer(bare);
        let (mut part, mut way) = (*ray, 0.0);
        for _ in 0..MAX_PASSED {
            let face = tracer.closest(&part);
            let is_end = (face.triangle, face.instance) == (hit.triangle, hit.instance);
            way += face.distance;
            if face.is_miss() || is_end || way >= hit.distance {
                return;
            }
            let here = vertex(tables, bare, &part, &face, 0.0);
            let event = passed(&cut_outs, &face, ray.key);
            self.vertices.push(self.vertex(&here, &face, event, carries));
            part.origin = offset::leave(here.position, here.face_normal, part.direction, here.clearance);
        }
    }
}

impl PathObserver for PathRecorder<'_> {
    type Kept = ();

    fn arrive(&mut self, ray: &Ray, hit: &Hit, here: &Here, carries: Vec3) {
        self.pass(ray, hit, carries);
        let InspectedFrame { scene, features, .. } = self.view;
        let event = if here.light == NONE { Event::Ended } else { Event::Emitter };
        self.vertices.push(self.vertex(here, hit, event, carries));
        self.here = Some((*here, material_at(scene.tables(), here, features)));
    }

    fn scatter(&mut self, departure: &BsdfSample) {
        if let (Some((here, material)), Some(vertex)) = (self.here.take(), self.vertices.last_mut()) {
            (vertex.event, vertex.lobes) = event(&material, &here, &departure.sampled);
            vertex.specular = departure.sampled.class == Classes::SPECULAR;
        }
    }

    fn escape(&mut self, ray: &Ray, carries: Vec3) {
        self.pass(ray, &Hit::MISS, carries);
        self.left = Some(*ray);
    }

    fn collect(&mut self, _kept: &mut (), _point: &CollectionPoint) {
        self.has_point = true;
    }

    fn end(&mut self, _kept: &mut (), _last: Vec3) {}
}
