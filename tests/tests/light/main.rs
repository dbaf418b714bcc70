//! Light transport as a whole: known answers, energy, and statistics of images.

mod blended;
mod convergence;
mod degenerate;
mod energy;
mod environment;
mod invariances;
mod known_answers;
mod light_sampling;
mod modes;
mod partition;
mod path_counts;
mod samplers;
mod split;
mod starving;
mod thin_walls;
