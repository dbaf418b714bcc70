//! Tiled images: bands of rows that are rendered one after another, in buffers for one band.

use std::ops::Range;

use caustics_kernels::declare::BufferSpec;
use caustics_kernels::interface::frame::{FrameParams, Window};

use crate::counters::Counters;
use crate::energy::EnergyLedger;
use caustics_files::rendered_image::RenderedImage;

/// State of a tile after a frame: bytes of each buffer that outlives it.
pub type TileState = Vec<(&'static str, Vec<u8>)>;

/// Tiles of a film.
pub struct Tiles {
    film: Window,
    count: u32,
    /// Tile in the buffers; `None` before the first frame.
    pub current: Option<u32>,
    /// State of each tile after the last frame; empty before the first.
    pub states: Vec<TileState>,
    /// Last frame, if it has several tiles.
    pub rendered: Rendered,
}

/// Frame of several tiles.
#[derive(Default)]
pub struct Rendered {
    /// Image of all tiles.
    pub image: RenderedImage,
    /// Sum of the tiles' counters.
    pub counters: Counters,
    /// Sum of the tiles' ledgers.
    pub energy: EnergyLedger,
}

impl Tiles {
    /// Divides a film into at most `count` tiles of at least a row.
    pub fn new(film: Window, count: u32) -> Tiles {
        let rows = film.film_height.div_ceil(count.clamp(1, film.film_height));
        let count = film.film_height.div_ceil(rows);
        Tiles { film, count, current: None, states: Vec::new(), rendered: Rendered::default() }
    }

    /// Returns the number of tiles.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Whether the image is a single tile.
    pub fn is_one(&self) -> bool {
        self.count == 1
    }

    /// Returns the rows of a tile.
    pub fn rows(&self, tile: u32) -> Range<u32> {
        let height = self.film.film_height.div_ceil(self.count);
        tile * height..((tile + 1) * height).min(self.film.film_height)
    }

    /// Returns the pixels of a tile.
    pub fn pixels(&self, tile: u32) -> Range<usize> {
        let Range { start, end } = self.rows(tile);
        (start * self.film.film_width) as usize..(end * self.film.film_width) as usize
    }

    /// Returns the parameters of a tile of a frame.
    pub fn params(&self, tile: u32, params: FrameParams) -> FrameParams {
        let Range { start, end } = self.rows(tile);
        FrameParams { height: end - start, window: Window { first_row: start, ..self.film }, ..params }
    }
}

/// Returns the smallest number of tiles with which no buffer exceeds `limit` bytes. `None` if one tile suffices, or tiles
/// do not help. `buffers` returns the buffers for a number of tiles.
pub fn within(limit: u64, height: u32, buffers: impl Fn(u32) -> Vec<BufferSpec>) -> Option<u32> {
    let fits = |count: &u32| buffers(*count).iter().all(|spec| spec.bytes as u64 <= limit);
    if fits(&1) { None } else { (2..=height).find(fits) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_belongs_to_exactly_one_tile() {
        for (height, count) in [(9, 1), (9, 2), (9, 4), (9, 9), (9, 20), (1, 3), (2160, 7)] {
            let tiles = Tiles::new(Window::all(5, height), count);
            assert!(tiles.count() <= count.min(height));
            let rows: Vec<u32> = (0..tiles.count()).flat_map(|tile| tiles.rows(tile)).collect();
            assert_eq!(rows, (0..height).collect::<Vec<_>>());
            assert!((0..tiles.count()).all(|tile| !tiles.rows(tile).is_empty()));
            // The first tile is the largest.
            assert!((0..tiles.count()).all(|tile| tiles.rows(tile).len() <= tiles.rows(0).len()));
        }
    }

    #[test]
    fn the_smallest_number_of_tiles_that_fits_is_chosen() {
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
