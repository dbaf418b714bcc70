//! The software tracer of the CPU runner: by the eight-wide tree where this CPU has what that needs, else by the GPU's.

#[cfg(target_arch = "x86_64")]
pub use super::wide::WideTree;

use std::sync::OnceLock;

use super::Tracer;
use super::bvh::BvhTracer;
#[cfg(target_arch = "x86_64")]
use super::wide;
#[cfg(target_arch = "x86_64")]
use crate::interface::features::Features;
use crate::interface::ray::{Hit, Ray};

/// Whether this CPU has AVX2 and what came with it, all that `#[pass]` compiles for, and `CAUSTICS_AVX2` is not 0.
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

/// No other CPU has a tree of its own.
#[cfg(not(target_arch = "x86_64"))]
pub enum WideTree {}

#[cfg(not(target_arch = "x86_64"))]
impl WideTree {
    /// None.
    pub fn new(
        _: &[crate::interface::tree::TreeNode],
        _: &[crate::interface::instance::Instance],
    ) -> Option<WideTree> {
        None
    }
}

/// A worker's tracer.
pub struct CpuTracer<'a> {
    bvh: BvhTracer<'a>,
    wide: Option<&'a WideTree>,
    #[cfg(target_arch = "x86_64")]
    stack: wide::Stack,
}

impl<'a> CpuTracer<'a> {
    /// By the tree that the host built, or by what was made of it.
    pub fn new(bvh: BvhTracer<'a>, wide: Option<&'a WideTree>) -> Self {
        CpuTracer {
            bvh,
            wide,
            #[cfg(target_arch = "x86_64")]
            stack: wide::EMPTY,
        }
    }

    #[inline(always)]
    fn find<const ANY: bool>(&mut self, ray: &Ray) -> Hit {
        #[cfg(target_arch = "x86_64")]
        let BvhTracer { blocks, cut_outs, .. } = &self.bvh;
        match self.wide {
            None => self.bvh.find::<ANY>(ray),
            #[cfg(target_arch = "x86_64")]
            Some(tree) if cut_outs.features.has(Features::INSTANCES) => {
                wide::find::<ANY, true>(tree, blocks, cut_outs, ray, &mut self.stack)
            }
            #[cfg(target_arch = "x86_64")]
            Some(tree) => wide::find::<ANY, false>(tree, blocks, cut_outs, ray, &mut self.stack),
            #[cfg(not(target_arch = "x86_64"))]
            Some(tree) => match *tree {},
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
