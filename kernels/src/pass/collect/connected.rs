//! Connections of a vertex, made before its lobes are: with both at once a GPU runs short of registers.

use crate::light::connect::{CANDIDATES, Connection, FEW_LIGHTS};
use crate::seam::{put3, take3};

/// Words of one.
const WORDS: usize = 11;

/// Most that a vertex has: all lights where they are few, else the candidates of one connection.
const MOST: u32 = if FEW_LIGHTS > CANDIDATES { FEW_LIGHTS } else { CANDIDATES };

/// Words of as many.
pub const ROOM: usize = WORDS * MOST as usize;

/// Leaves one at a place.
#[inline(always)]
pub fn put(words: &mut [u32; ROOM], place: u32, connection: &Connection) {
    let first = first_of(place);
    put3(words, first, connection.target);
    put3(words, first + 3, connection.to_light);
    put3(words, first + 6, connection.radiance_over_pdf);
    words[first + 9] = connection.pdf_solid_angle.to_bits();
    words[first + 10] = u32::from(connection.endless);
}

/// The one at a place.
#[inline(always)]
pub fn take(words: &[u32; ROOM], place: u32) -> Connection {
    let first = first_of(place);
    Connection {
        target: take3(words, first),
        to_light: take3(words, first + 3),
        radiance_over_pdf: take3(words, first + 6),
        pdf_solid_angle: f32::from_bits(words[first + 9]),
        endless: words[first + 10] != 0,
    }
}

/// The first word of a place. That it has an end lets a CPU's compiler leave out all other checks.
#[inline(always)]
fn first_of(place: u32) -> usize {
    WORDS * place.min(MOST - 1) as usize
}
