//! What the last frame leaves that its light paths can be traced again by.

use caustics_kernels::declare::{Access, Bound, Pass, Step};
use caustics_kernels::interface::frame::FrameParams;

/// What light paths start by, scene tables aside: buffers by name.
pub type Starts = Vec<(&'static str, Vec<u8>)>;

/// A frame that was rendered.
#[derive(Clone, Default)]
pub struct Last {
    /// Its settings.
    pub params: FrameParams,
    /// So many of its light paths, the first, started by what the frame overwrote later.
    pub started_before: u32,
    /// What that was, if somebody asked to keep it.
    pub starts_before: Option<Starts>,
}

/// The buffers that a pass reads, scene tables aside.
pub fn reads(pass: &'static Pass) -> impl Iterator<Item = &'static Bound> {
    pass.buffers.iter().filter(|bound| bound.access == Access::Read)
}

/// The first of the steps that overwrites what `shoot` reads after light paths have started, and how many have.
pub fn overwritten(steps: &[Step], shoot: &'static Pass) -> Option<(usize, u32)> {
    let mut started = 0;
    steps.iter().enumerate().find_map(|(index, step)| {
        let Step::Dispatch { pass, dispatch, .. } = *step else { return None };
        if pass == shoot {
            started += dispatch.count;
        }
        let overwrites = pass.written().any(|bound| reads(shoot).any(|read| read.name == bound.name));
        (overwrites && started > 0).then_some((index, started))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustics_kernels::emission;
    use caustics_kernels::gather::variant::BRUTE;
    use caustics_kernels::method::{BASIC, Parts};

    #[test]
    fn a_pilot_s_maps_are_overwritten_once_it_has_been_learnt_from() {
        let params = |moved| FrameParams {
            width: 4,
            height: 4,
            light_path_count: 800,
            light_path_batch: 60,
            photon_capacity: 240,
            light_count: 1,
            moved,
            ..FrameParams::default()
        };
        for (emission, moved, expected) in
            [(&emission::GUIDED, 1, Some(100)), (&emission::GUIDED, 0, None), (&emission::AIMED, 1, None)]
        {
            let params = params(moved);
            let steps = BASIC.frame_steps(Parts { emission, ..Parts::from(&BRUTE) }, &params);
            let found = overwritten(&steps, emission.shoot);
            assert_eq!(found.map(|(_, started)| started), expected, "{}, {moved}", emission.name);
        }
    }
}
