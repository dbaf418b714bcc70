//! Fields of the interface's records, to report differences by name.

use bytemuck::Pod;
use caustics_kernels::interface::auxiliary::Auxiliary;
use caustics_kernels::interface::history::{Reprojected, ValidationPhoton};
use caustics_kernels::interface::point::{PhotonGeometry, PhotonLight, PointGeometry, PointShading};
use caustics_kernels::interface::ray::Hit;
use caustics_kernels::interface::step::{EmitStep, SampleStep, ScatterOut};
use std::mem::offset_of;

/// Type of the words of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// f32 components of one vector.
    Floats,
    /// Ids, counts, flags.
    Words,
    /// Two signed shares of one (`interface::packed`) in each word.
    Shares,
}

/// A field of a record of 4-byte words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name.
    pub name: &'static str,
    /// Index of its first word.
    pub first: usize,
    /// Number of its words.
    pub words: usize,
    /// Type of its words.
    pub kind: Kind,
}

/// A record with fields that are known by name. Padding is no field.
pub trait Fields: Pod {
    /// The fields.
    const FIELDS: &'static [Field];
}

/// Lists the fields of a record: `name(.inner): words kind`.
macro_rules! fields {
    ($record:ty { $($($part:ident).+: $words:literal $kind:ident,)+ }) => {
        impl Fields for $record {
            const FIELDS: &'static [Field] = &[$(Field {
                name: stringify!($($part).+),
                first: offset_of!($record, $($part).+) / 4,
                words: $words,
                kind: Kind::$kind,
            }),+];
        }
    };
}

fields!(Hit { distance: 1 Floats, triangle: 1 Words, u: 1 Floats, v: 1 Floats, instance: 1 Words, });
fields!(SampleStep {
    uniform: 4 Words, sphere: 3 Floats, hemisphere: 3 Floats, facet: 3 Floats, triangle: 2 Floats,
});
fields!(ScatterOut {
    ray.origin: 3 Floats, ray.length: 1 Floats, ray.direction: 3 Floats, weight: 3 Floats, pdf: 1 Floats,
    class: 1 Words, transmitted: 1 Words, specular: 3 Floats, non_specular: 3 Floats, class_probability: 1 Floats,
});
fields!(EmitStep {
    ray.origin: 3 Floats, ray.length: 1 Floats, ray.direction: 3 Floats, flux: 3 Floats, to_light: 3 Floats,
    radiance_over_pdf: 3 Floats, pdf: 1 Floats,
});
fields!(PointGeometry { position: 3 Floats, radius: 1 Floats, normal: 3 Floats, depth: 1 Words, });
fields!(PointShading {
    to_viewer: 3 Floats, material: 1 Words, shading_normal: 3 Floats, red_green: 1 Words,
    throughput: 3 Floats, blue_roughness_metallic: 1 Words, eta: 1 Floats,
    instance: 1 Words, distance: 1 Floats, astigmatism: 1 Shares,
});
fields!(Auxiliary {
    position: 3 Floats, depth: 1 Floats, normal: 3 Floats, material: 1 Words, albedo: 3 Floats, motion: 2 Floats,
});
fields!(PhotonGeometry { position: 3 Floats, scatterings: 1 Words, normal: 3 Floats, });
fields!(PhotonLight { to_light: 3 Floats, flux: 3 Floats, });
fields!(Reprojected { mean: 3 Floats, samples: 1 Floats, offset: 3 Floats, radius: 1 Floats, });
fields!(ValidationPhoton { position: 3 Floats, flux: 1 Floats, instance: 1 Words, });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_do_not_overlap_and_fit_their_record() {
        fn check<T: Fields>() {
            let mut used = vec![false; size_of::<T>() / 4];
            for field in T::FIELDS {
                for used in &mut used[field.first..field.first + field.words] {
                    assert!(!std::mem::replace(used, true), "{} overlaps", field.name);
                }
            }
        }
        check::<Hit>();
        check::<SampleStep>();
        check::<ScatterOut>();
        check::<EmitStep>();
        check::<PointGeometry>();
        check::<PointShading>();
        check::<PhotonGeometry>();
        check::<PhotonLight>();
        check::<Reprojected>();
        check::<ValidationPhoton>();
        assert_eq!(ScatterOut::FIELDS.iter().map(|field| field.words).sum::<usize>(), 20);
    }
}
