//! The project itself: its dependencies, its layers, its metrics against those of others, its corpus, and the bits that a refactoring must
//! keep.

mod ci;
mod corpus;
mod dependencies;
mod flip;
mod images;
mod layers;
mod quotes;
mod ray_queries;
mod reading;
mod unused;
mod words;
