//! Software tracer of the CPU runner: by the eight-wide BVH where this CPU supports it, else by the GPU's.

#[cfg(target_arch = "x86_64")]
pub use super::bvh8::Bvh8;

use std::sync::OnceLock;

use super::Tracer;
use super::bvh::BvhTracer;
#[cfg(target_arch = "x86_64")]
use super::bvh8;
#[cfg(target_arch = "x86_64")]
use crate::interface::features::Features;
use crate::interface::ray::{Hit, Ray};

/// Whether this CPU has AVX2 and all other instructions that `#[pass]` compiles for, and `CAUSTICS_AVX2` is not 0.
pub fn has_avx2() -> bool {
    static HAS: OnceLock<bool> = OnceLock::new();
    #[cfg(target_arch = "x86_64")]
    let detect = || {
        let wanted = std::env::var_os("CAUSTICS_AVX2").is_none_or(|value| value != "0");
        let has = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        wanted && has
    };
    #[cfg(not(target_arch = "x86_64"))]
    let detect = || false;
    *HAS.get_or_init(detect)
}

/// Type without values: other CPUs have no BVH of their own.
#[cfg(not(target_arch = "x86_64"))]
pub enum Bvh8 {}

#[cfg(not(target_arch = "x86_64"))]
impl Bvh8 {
    /// Makes no BVH.
    pub fn new(
        _: &[crate::interface::bvh::BvhNode],
        _: &[crate::interface::instance::Instance],
    ) -> Option<Bvh8> {
        None
    }
}

/// Tracer of a worker.
pub struct CpuTracer<'a> {
    bvh: BvhTracer<'a>,
    bvh8: Option<&'a Bvh8>,
    #[cfg(target_arch = "x86_64")]
    stack: bvh8::Stack,
}

impl<'a> CpuTracer<'a> {
    /// Tracer by the BVH that the host built, or by the one made of it.
    pub fn new(bvh: BvhTracer<'a>, bvh8: Option<&'a Bvh8>) -> Self {
        CpuTracer {
            bvh,
            bvh8,
            #[cfg(target_arch = "x86_64")]
            stack: bvh8::EMPTY,
        }
    }

    #[inline(always)]
    fn find<const ANY: bool>(&mut self, ray: &Ray) -> Hit {
        #[cfg(target_arch = "x86_64")]
        let BvhTracer { blocks, cut_outs, .. } = &self.bvh;
        match self.bvh8 {
            None => self.bvh.find::<ANY>(ray),
            #[cfg(target_arch = "x86_64")]
            Some(bvh8) if cut_outs.features.has(Features::INSTANCES) => {
                bvh8::find::<ANY, true>(bvh8, blocks, cut_outs, ray, &mut self.stack)
            }
            #[cfg(target_arch = "x86_64")]
            Some(bvh8) => bvh8::find::<ANY, false>(bvh8, blocks, cut_outs, ray, &mut self.stack),
            #[cfg(not(target_arch = "x86_64"))]
            Some(bvh8) => match *bvh8 {},
        }
    }
}

impl Tracer for CpuTracer<'_> {
    #[inline(always)]
    fn closest(&mut self, ray: &Ray) -> Hit {
        self.find::<false>(ray)
    }
    #[inline(always)]
    fn occluded(&mut self, ray: &Ray) -> bool {
        !self.find::<true>(ray).is_miss()
    }
}
