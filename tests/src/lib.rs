//! Comparers of the results of two runners, each with a test in which it must fail, and shared parts of the tests.

#![forbid(unsafe_code)]

pub mod blocks;
pub mod chi_square;
pub mod collected;
pub mod compare;
pub mod direct;
pub mod document;
pub mod energy;
pub mod fading;
pub mod failed_image;
pub mod fields;
pub mod frames;
pub mod gpu;
pub mod lobes;
pub mod matching;
pub mod moving;
pub mod parity;
pub mod quadrature;
pub mod rays;
pub mod scenes;
pub mod statistics;
pub mod table;
pub mod tremble;
