//! Experiments: scenes rendered in several ways, and what each costs and how far off it is.
//!
//! `cell` is a way to render and `matrix` all combinations; `plan` says what is measured, `measure` renders the frames of all
//! cells in turn, `reference` keeps the truth of each frame, `error` and `gain` hold pictures against it, `row` and `summary`
//! are what is left of an animation, `timing` and `result` of a cell, `store` and `table` keep and show it; `sweep` does all
//! of it from a file.

pub mod cell;
pub mod cost;
pub mod error;
pub mod figure;
pub mod gain;
pub mod identity;
pub mod matrix;
pub mod measure;
pub mod memory;
pub mod plan;
pub mod reference;
pub mod result;
pub mod row;
pub mod store;
pub mod summary;
pub mod sweep;
pub mod table;
pub mod timing;
