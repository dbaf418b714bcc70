//! What the kernels counted in a frame.

use std::collections::BTreeMap;

use caustics_kernels::interface::counters::{COUNTER_NAMES, Counter};

/// Light paths that make a photon, at least one in so many: at the default of 2^20 a frame has a hundred then, a noise of
/// 10 % even where one pixel takes them all.
const PATHS_PER_PHOTON: u64 = 10_000;
/// Fewer light paths may miss at random.
const STARVING_PATHS: u64 = 1 << 16;

/// What the kernels counted.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(transparent)]
pub struct Counters(BTreeMap<&'static str, u64>);

impl Counters {
    /// The counters in the words of the buffer `counters`.
    pub fn from_words(words: &[u32]) -> Counters {
        let value = |slot: Counter| words.get(slot as usize).copied().unwrap_or(0);
        Counters(COUNTER_NAMES.iter().map(|&(slot, name)| (name, u64::from(value(slot)))).collect())
    }

    /// One counter.
    pub fn get(&self, counter: Counter) -> u64 {
        let name = COUNTER_NAMES.iter().find(|(slot, _)| *slot == counter).map(|(_, name)| *name);
        name.and_then(|name| self.0.get(name).copied()).unwrap_or(0)
    }

    /// Adds another frame's.
    pub fn add(&mut self, other: &Counters) {
        for (name, value) in &other.0 {
            *self.0.entry(name).or_default() += value;
        }
    }

    /// What a person should be warned of.
    pub fn warnings(&self) -> Vec<String> {
        let faults = [
            (Counter::PhotonsDropped, "photons found no room and are missing"),
            (Counter::Clamped, "addends were clamped by the accumulator"),
            (Counter::NonFinite, "non-finite values were left out"),
            (Counter::MediaOverflow, "paths were inside more than four nested media"),
            (
                Counter::UnexpectedFaces,
                "times a path met the back of a medium that it was not in: is a mesh open?",
            ),
        ]
        .iter()
        .filter(|(counter, _)| self.get(*counter) > self.tolerated(*counter))
        .map(|(counter, what)| format!("{} {what}", self.get(*counter)));
        faults.chain(self.starvation()).collect()
    }

    /// Caustics of which too little is found: casters, receivers and lights are there, but hardly a light path goes from one
    /// to the other.
    fn starvation(&self) -> Option<String> {
        let (paths, photons) = (self.get(Counter::LightPaths), self.get(Counter::Photons));
        let starves = paths >= STARVING_PATHS && photons * PATHS_PER_PHOTON < paths;
        starves.then(|| {
            format!(
                "caustics starve: {photons} photons of {paths} light paths; give more --light-paths, make the scene \
                 smaller around what casts caustics (a directional light shines on all of its bounds), or, where walls \
                 light what casts them, take --caustics any"
            )
        })
    }

    /// Up to which value a counter gives no warning. At an edge a path leaves a solid beside the face that it should meet:
    /// rounding, for one ray in a hundred thousand.
    fn tolerated(&self, counter: Counter) -> u64 {
        if counter != Counter::UnexpectedFaces {
            return 0;
        }
        (self.get(Counter::CameraRays) + self.get(Counter::LightRays)) / 100_000
    }
}
