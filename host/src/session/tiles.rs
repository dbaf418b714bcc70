//! Images rendered tile by tile: bands of rows, one after another, in buffers that hold one of them.

use std::ops::Range;

use caustics_kernels::declare::BufferSpec;
use caustics_kernels::interface::frame::{FrameParams, Window};

use crate::counters::Counters;
use crate::energy::EnergyLedger;
use caustics_files::rendered_image::RenderedImage;

/// What outlives a frame, by buffer.
pub type TileState = Vec<(&'static str, Vec<u8>)>;

/// The tiles of a film.
pub struct Tiles {
    film: Window,
    count: u32,
    /// The tile that the buffers are of; none before the first frame.
    pub current: Option<u32>,
    /// What the last frame left of each; empty before the first.
    pub states: Vec<TileState>,
    /// The last frame, where it was rendered in several.
    pub rendered: Rendered,
}

/// A frame of several tiles.
#[derive(Default)]
pub struct Rendered {
    /// Its image.
    pub image: RenderedImage,
    /// What the tiles counted.
    pub counters: Counters,
    /// The sum of the tiles' ledgers.
    pub energy: EnergyLedger,
}

impl Tiles {
    /// As many tiles of a film; a row at least is each.
    pub fn new(film: Window, count: u32) -> Tiles {
        let rows = film.film_height.div_ceil(count.clamp(1, film.film_height));
        let count = film.film_height.div_ceil(rows);
        Tiles { film, count, current: None, states: Vec::new(), rendered: Rendered::default() }
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Whether the image is one.
    pub fn is_one(&self) -> bool {
        self.count == 1
    }

    /// Rows of a tile.
    pub fn rows(&self, tile: u32) -> Range<u32> {
        let height = self.film.film_height.div_ceil(self.count);
        tile * height..((tile + 1) * height).min(self.film.film_height)
    }

    /// Pixels of a tile.
    pub fn pixels(&self, tile: u32) -> Range<usize> {
        let Range { start, end } = self.rows(tile);
        (start * self.film.film_width) as usize..(end * self.film.film_width) as usize
    }

    /// The settings of a frame, of a tile of it.
    pub fn params(&self, tile: u32, params: FrameParams) -> FrameParams {
        let Range { start, end } = self.rows(tile);
        FrameParams { height: end - start, window: Window { first_row: start, ..self.film }, ..params }
    }
}

/// As few tiles as have no buffer of more than `limit` bytes; none where tiles do not help. `buffers` says what some need.
pub fn within(limit: u64, height: u32, buffers: impl Fn(u32) -> Vec<BufferSpec>) -> Option<u32> {
    let fits = |count: &u32| buffers(*count).iter().all(|spec| spec.bytes as u64 <= limit);
    if fits(&1) { None } else { (2..=height).find(fits) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_of_one_tile() {
        for (height, count) in [(9, 1), (9, 2), (9, 4), (9, 9), (9, 20), (1, 3), (2160, 7)] {
            let tiles = Tiles::new(Window::all(5, height), count);
            assert!(tiles.count() <= count.min(height));
            let rows: Vec<u32> = (0..tiles.count()).flat_map(|tile| tiles.rows(tile)).collect();
            assert_eq!(rows, (0..height).collect::<Vec<_>>());
            assert!((0..tiles.count()).all(|tile| !tiles.rows(tile).is_empty()));
            // The first is the largest.
            assert!((0..tiles.count()).all(|tile| tiles.rows(tile).len() <= tiles.rows(0).len()));
        }
    }

    #[test]
    fn there_are_as_few_tiles_as_fit_and_none_where_they_do_not_help() {
        let buffers = |of_light: usize| {
            move |count| {
                let rows = Tiles::new(Window::all(10, 100), count).rows(0).len();
                vec![
                    BufferSpec { name: "pixels", bytes: rows * 10 * 4 },
                    BufferSpec { name: "light", bytes: of_light },
                ]
            }
        };
        assert_eq!(within(4000, 100, buffers(8)), None);
        assert_eq!(within(3999, 100, buffers(8)), Some(2));
        assert_eq!(within(1000, 100, buffers(8)), Some(4));
        assert_eq!(within(1000, 100, buffers(1001)), None);
    }
}
