//! Names of the events of a path.

use caustics_kernels::interface::material::{FLAG_BLEND, FLAG_THIN, Material};
use caustics_kernels::interface::ray::Hit;
use caustics_kernels::surface::class::Classes;
use caustics_kernels::surface::ggx::DELTA_ROUGHNESS;
use caustics_kernels::surface::vertex::Vertex;
use caustics_kernels::surface::{Sampled, fresnel, names_of};
use caustics_kernels::texture::cut_out::CutOuts;
use serde::Serialize;

/// Event of a path at a vertex or a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Event {
    /// Reflection by a mirror, a coat or glass.
    Reflected,
    /// Total internal reflection.
    TotallyReflected,
    /// Refraction into a medium.
    Entered,
    /// Refraction out of a medium.
    Left,
    /// Transmission through a thin wall, without refraction.
    Passed,
    /// Scattering by lobes that include a diffuse one.
    Scattered,
    /// End of a camera path at its collection point.
    CollectionPoint,
    /// End of a light path at the inspected photon.
    Photon,
    /// End on an emitter.
    Emitter,
    /// End without scattering, or at the maximum path length.
    Ended,
    /// Passage through a hole, where alpha is cut off.
    Hole,
    /// Passage through a blended surface that this ray does not hit.
    Blended,
    /// Passage through a face within a medium of higher priority.
    Covered,
}

impl Event {
    /// Returns the event's name in JSON.
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

    /// Whether the event is a vertex of the path; otherwise the path passes a face without scattering.
    pub fn is_vertex(self) -> bool {
        !matches!(self, Event::Hole | Event::Blended | Event::Covered)
    }
}

/// Returns the event of a face that a ray of this key passes.
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

/// Determines the event at a vertex and the lobes that may have scattered the path. Facet reflections are sampled together,
/// and a facet lobe of roughness 1 looks like a diffuse one.
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
        // Only smooth glass has a relative index other than 1; a thin wall does not refract.
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
