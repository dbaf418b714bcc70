//! Experiments: scenes rendered in several ways, and what each costs and how far off it is.
//!
//! `plan` says what is measured, `measure` renders the frames of all cells in turn, `reference` keeps the truth of each
//! frame, `error` and `gain` hold pictures against it, `row` and `summary` are what is left, `figure` draws it.

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
