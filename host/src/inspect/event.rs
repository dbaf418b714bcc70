//! What a path does at a vertex, in words.

use caustics_kernels::interface::material::{FLAG_BLEND, FLAG_THIN, Material};
use caustics_kernels::interface::ray::Hit;
use caustics_kernels::surface::class::Classes;
use caustics_kernels::surface::ggx::DELTA_ROUGHNESS;
use caustics_kernels::surface::vertex::Vertex;
use caustics_kernels::surface::{Sampled, fresnel, names_of};
use caustics_kernels::texture::cut_out::CutOuts;
use serde::Serialize;

/// What a path does at a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Event {
    /// Is reflected: by a mirror, a coat, or glass.
    Reflected,
    /// Is reflected within a medium that it could not leave at this angle.
    TotallyReflected,
    /// Is refracted into a medium.
    Entered,
    /// Is refracted out of it.
    Left,
    /// Passes a wall that is too thin to refract it.
    Passed,
    /// Is scattered by lobes among which is a diffuse one.
    Scattered,
    /// Comes to the collection point.
    CollectionPoint,
    /// Leaves the photon.
    Photon,
    /// Ends on what emits.
    Emitter,
    /// Ends: what it meets scatters nothing, or as many vertices are behind it as paths have.
    Ended,
    /// Passes a hole: alpha is cut off there.
    Hole,
    /// Passes what blends, which is not there for this ray.
    Blended,
    /// Passes a face within a medium of higher priority.
    Covered,
}

impl Event {
    /// Its name, as in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Event::Reflected => "reflected",
            Event::TotallyReflected => "totally-reflected",
            Event::Entered => "entered",
            Event::Left => "left",
            Event::Passed => "passed",
            Event::Scattered => "scattered",
            Event::CollectionPoint => "collection-point",
            Event::Photon => "photon",
            Event::Emitter => "emitter",
            Event::Ended => "ended",
            Event::Hole => "hole",
            Event::Blended => "blended",
            Event::Covered => "covered",
        }
    }

    /// Whether it is a vertex of the path; else the path passes a face without a scattering.
    pub fn is_vertex(self) -> bool {
        !matches!(self, Event::Hole | Event::Blended | Event::Covered)
    }
}

/// How a face is passed that a ray of this key does not meet.
pub fn passed(cut_outs: &CutOuts<'_>, face: &Hit, key: u32) -> Event {
    let material = cut_outs.surfaces[face.triangle as usize].material;
    if cut_outs.is_there(face, key) {
        Event::Covered
    } else if cut_outs.materials[material as usize].flags & FLAG_BLEND != 0 {
        Event::Blended
    } else {
        Event::Hole
    }
}

/// How a path is scattered at a vertex, and the lobes that may have done so: reflections at facets are sampled together, and a
/// facet's lobe of roughness 1 cannot be told from a diffuse one.
pub fn event(material: &Material, here: &Vertex, sampled: &Sampled) -> (Event, Vec<&'static str>) {
    let glass = if sampled.roughness > 0.0 { "rough glass" } else { "glass" };
    if sampled.transmitted {
        let event = match (material.is_medium(), here.front) {
            (false, _) => Event::Passed,
            (true, true) => Event::Entered,
            (true, false) => Event::Left,
        };
        return (event, vec![glass]);
    }
    let (facets, diffuse) = names_of(material);
    let mut lobes = Vec::new();
    let is_delta = sampled.pdf_solid_angle == 0.0 && sampled.class == Classes::SPECULAR;
    if is_delta {
        // Smooth glass alone says by how much it would have refracted; a thin wall refracts nothing.
        let refracts = sampled.eta != 1.0;
        let cos = here.to_previous.dot(here.shading_normal).abs();
        if refracts && fresnel::dielectric_reflectance(cos, sampled.eta) >= 1.0 {
            return (Event::TotallyReflected, vec![glass]);
        }
        if !refracts && material.roughness < DELTA_ROUGHNESS {
            lobes.extend(facets);
        }
        if refracts || (material.transmits() && material.flags & FLAG_THIN != 0) {
            lobes.push(glass);
        }
        return (Event::Reflected, lobes);
    }
    let is_facet = sampled.roughness == material.roughness;
    let is_diffuse = sampled.class == Classes::NON_SPECULAR && sampled.roughness == 1.0;
    if is_facet {
        lobes.extend(facets);
        if material.transmits() {
            lobes.push(glass);
        }
    }
    let reflects = !is_diffuse || diffuse.is_empty();
    if is_diffuse {
        lobes.extend(diffuse);
    }
    (if reflects { Event::Reflected } else { Event::Scattered }, lobes)
}
