//! Emission by power: lights by their share of the flux, positions and directions by their own share (`light::power`).

#[cfg(not(target_arch = "spirv"))]
use crate::declare::{Emission, FrameStage};

crate::shoot_pass!(shared_entry "shoot.store", |power| power);

/// Emission by power: lights by their share of the flux.
#[cfg(not(target_arch = "spirv"))]
pub const POWER: Emission = Emission {
    name: "power",
    description: "lights by their share of the flux, positions and directions by the light's emission",
    cost: "nothing",
    limitations: "most paths miss all visible caustics",
    uses_casters: false,
    shoot: &SHOOT,
    starts,
    stage: FrameStage::new("power"),
};
