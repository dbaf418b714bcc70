//! Every light starts as many paths: an example that shows all that an emission consists of.

#[cfg(not(target_arch = "spirv"))]
use caustics_kernels::declare::{Emission, FrameStage};
use caustics_kernels::light::emit::{EmissionSample, Emit};
use caustics_kernels::light::power::ByPower;
use caustics_kernels::light::sample_emission;
use caustics_kernels::math::rng::Rng;

caustics_kernels::shoot_pass!("shoot.even", |power| Even(power));

/// Light paths of all lights alike.
#[cfg(not(target_arch = "spirv"))]
pub const EVEN: Emission = Emission {
    name: "even",
    description: "as many paths from every light: an example",
    cost: "nothing",
    limitations: "noise where lights differ",
    uses_casters: false,
    shoot: &SHOOT,
    starts,
    stage: FrameStage::new("even"),
};

/// Starts as many light paths at every light.
#[derive(Clone, Copy)]
pub struct Even<'a>(pub ByPower<'a>);

impl Emit for Even<'_> {
    #[inline(always)]
    fn sample(&self, rng: &mut Rng) -> EmissionSample {
        let (u_position, direction) = (rng.next4(), rng.next4());
        let ByPower { scene, params, features } = self.0;
        let light_count = params.light_count;
        let light_id = ((u_position.x * light_count as f32) as u32).min(light_count - 1);
        let mut light = scene.lights[light_id as usize];
        light.pdf_light_choice = 1.0 / light_count as f32;
        sample_emission(&light, scene, features, u_position, direction)
    }
}
