//! Aimed emission: into cones around the casters (`light::aimed`).

#[cfg(not(target_arch = "spirv"))]
use crate::declare::{Emission, FrameStage};
use crate::light::aimed::Aimed;

crate::shoot_pass!(shared_entry "shoot.aimed", |power| Aimed { power });

/// Emission into cones around the casters.
#[cfg(not(target_arch = "spirv"))]
pub const AIMED: Emission = Emission {
    name: "aimed",
    description: "seven paths in eight towards spheres round the casters",
    cost: "up to 16 cones a path, and the way of paths that meet something",
    limitations: "nothing knows which of the casters is lit or seen; what casts beside the cones (a wall of mirrors, say) gets few and \
            heavy paths",
    uses_casters: true,
    shoot: &SHOOT,
    starts,
    stage: FrameStage::new("aimed"),
};
