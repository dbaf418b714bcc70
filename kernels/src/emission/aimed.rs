//! Aimed emission: into cones around the casters (`light::aimed`).

#[cfg(not(target_arch = "spirv"))]
use crate::declare::{Emission, FrameStage};
use crate::light::aimed::Aimed;

crate::shoot_pass!(shared_entry "shoot.aimed", |power| Aimed { power });

/// Emission into cones around the casters.
#[cfg(not(target_arch = "spirv"))]
pub const AIMED: Emission = Emission {
    name: "aimed",
    description: "seven paths in eight towards the bounding spheres of casters",
    cost: "up to 16 cones a path; more paths that meet a surface",
    limitations: "ignores which casters are lit or seen; casters outside of the cones (a wall of mirrors, for instance) get \
            few paths of large weight",
    uses_casters: true,
    shoot: &SHOOT,
    starts,
    stage: FrameStage::new("aimed"),
};
