//! Letters in pixels: Noto Sans Mono, rasterized by the crate that brings it.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

const WEIGHT: FontWeight = FontWeight::Regular;

/// The letters of one size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Letters {
    height: RasterHeight,
}

impl Letters {
    /// Those that are nearest to a vector font of `size` pixels; there are four sizes.
    pub(crate) fn of(size: i64) -> Self {
        let height = match size {
            ..=15 => RasterHeight::Size16,
            16..=18 => RasterHeight::Size20,
            19..=23 => RasterHeight::Size24,
            _ => RasterHeight::Size32,
        };
        Self { height }
    }

    /// Pixels from a letter to the next.
    pub(crate) fn advance(self) -> i64 {
        get_raster_width(WEIGHT, self.height) as i64
    }

    /// Rows from the top to the baseline.
    pub(crate) fn ascent(self) -> i64 {
        let inked = self.rows('H').enumerate().filter(|(_, row)| row.iter().any(|ink| *ink > 127));
        inked.last().map_or(0, |(row, _)| row as i64 + 1)
    }

    /// How much ink each pixel of a character has, 0 to 255, row by row from the top; a question mark for one that the font lacks.
    pub(crate) fn rows(self, c: char) -> impl Iterator<Item = &'static [u8]> {
        let letter = [c, '?'].into_iter().find_map(|c| get_raster(c, WEIGHT, self.height));
        letter.into_iter().flat_map(|letter| letter.rows())
    }
}
