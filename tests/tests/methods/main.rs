//! Tests of methods, histories, the denoiser and animations.

mod animation;
mod auxiliary;
mod balance;
mod baselines;
mod denoiser;
mod edits;
mod example_variants;
mod fading;
mod fireflies;
mod guided;
mod inspect;
mod kim2019;
mod mirrored;
mod more_points;
mod path_history;
mod radiance_cache;
mod reuse;
mod share;
mod stability;
mod tiles;
mod widen;
mod yang2021;
