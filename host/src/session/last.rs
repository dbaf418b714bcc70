//! Data of the last frame for tracing its light paths again.

use caustics_kernels::declare::{Access, Bound, Pass, Step};
use caustics_kernels::interface::frame::FrameParams;

/// Buffers that light paths start from, by name, without scene tables.
pub type Starts = Vec<(&'static str, Vec<u8>)>;

/// Last rendered frame.
#[derive(Clone, Default)]
pub struct Last {
    /// Parameters of the frame.
    pub params: FrameParams,
    /// Number of light paths whose starts the frame overwrote later. They are the first of the frame.
    pub started_before: u32,
    /// Overwritten starts, if the session keeps them.
    pub starts_before: Option<Starts>,
}

/// Returns the buffers that a pass reads, without scene tables.
pub fn reads(pass: &'static Pass) -> impl Iterator<Item = &'static Bound> {
    pass.buffers.iter().filter(|bound| bound.access == Access::Read)
}

/// Finds the first step that overwrites a buffer of `shoot` after light paths have started. Returns its index and the
/// number of started light paths. Training paths, whose indices follow the `count` paths of the frame, are left out.
pub fn overwritten(steps: &[Step], shoot: &'static Pass, count: u32) -> Option<(usize, u32)> {
    let mut started = 0;
    steps.iter().enumerate().find_map(|(index, step)| {
        let Step::Dispatch { pass, dispatch, .. } = *step else { return None };
        if pass == shoot && dispatch.first < count {
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
    use caustics_kernels::interface::frame::FIRST_FRAME;
    use caustics_kernels::method::{BASIC, Parts};

    #[test]
    fn guided_emission_overwrites_its_starts_after_the_pilot_and_not_after_training() {
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
        for (emission, moved, expected) in [
            (&emission::GUIDED, 1, Some(100)),
            (&emission::GUIDED, 0, None),
            (&emission::GUIDED, FIRST_FRAME, None),
            (&emission::AIMED, 1, None),
        ] {
            let params = params(moved);
            let steps = BASIC.frame_steps(Parts { emission, ..Parts::from(&BRUTE) }, &params);
            let found = overwritten(&steps, emission.shoot, params.light_path_count);
            assert_eq!(found.map(|(_, started)| started), expected, "{}, {moved}", emission.name);
        }
    }
}
