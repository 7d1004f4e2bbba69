//! Which pixels of a box are the ball's.

use super::letterbox::Letterbox;
use crate::PixelBox;

/// Pixels of a part of the image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    /// Left and upper pixel.
    pub corner: [usize; 2],
    /// Pixels across and down.
    pub size: [usize; 2],
    /// Whether a pixel is the ball's, row by row.
    pub bits: Vec<bool>,
}

impl Mask {
    /// Whether a pixel of the image is the ball's.
    pub fn holds(&self, x: usize, y: usize) -> bool {
        let (Some(x), Some(y)) = (x.checked_sub(self.corner[0]), y.checked_sub(self.corner[1])) else {
            return false;
        };
        x < self.size[0] && y < self.size[1] && self.bits[y * self.size[0] + x]
    }

    /// Number of the ball's pixels.
    pub fn area(&self) -> usize {
        self.bits.iter().filter(|bit| **bit).count()
    }

    /// The mask of a box: where the sum of prototypes `[coefficients, rows, columns]`, weighted by the coefficients, is above zero. The
    /// prototypes cover the network's input, `cell` pixels of it each.
    pub(super) fn of_prototypes(
        coefficients: &[f32],
        prototypes: &[f32],
        [columns, rows]: [usize; 2],
        cell: f64,
        outline: &PixelBox,
        fit: &Letterbox,
        picture: [usize; 2],
    ) -> Self {
        let part = outline.clipped(picture[0], picture[1]);
        let corner = [0, 1].map(|k| part.min[k].floor().max(0.0) as usize);
        let size = [0, 1].map(|k| (part.max[k].ceil().max(0.0) as usize).saturating_sub(corner[k]));
        let plane = rows * columns;
        let value = |x: usize, y: usize| -> f32 {
            coefficients.iter().zip(prototypes.chunks_exact(plane)).map(|(c, p)| c * p[y * columns + x]).sum()
        };
        // The part of the prototypes that the box needs.
        let to_cell = |p: [f64; 2]| {
            let at = fit.to_input(p);
            [at[0] / cell - 0.5, at[1] / cell - 0.5]
        };
        let (low, high) = (to_cell(part.min), to_cell(part.max));
        let bound = |v: f64, last: usize| v.clamp(0.0, last as f64);
        let first = [bound(low[0].floor(), columns - 1) as usize, bound(low[1].floor(), rows - 1) as usize];
        let last = [bound(high[0].ceil(), columns - 1) as usize, bound(high[1].ceil(), rows - 1) as usize];
        let width = last[0] - first[0] + 1;
        let values: Vec<f32> = (first[1]..=last[1])
            .flat_map(|y| (first[0]..=last[0]).map(move |x| (x, y)))
            .map(|(x, y)| value(x, y))
            .collect();
        let between = |p: [f64; 2]| {
            let [u, v] = to_cell(p);
            let (u, v) = (
                bound(u - first[0] as f64, last[0] - first[0]),
                bound(v - first[1] as f64, last[1] - first[1]),
            );
            let (x0, y0) = (u as usize, v as usize);
            let (x1, y1) = ((x0 + 1).min(last[0] - first[0]), (y0 + 1).min(last[1] - first[1]));
            let (fx, fy) = (u.fract() as f32, v.fract() as f32);
            let at = |x: usize, y: usize| values[y * width + x];
            let top = at(x0, y0) + fx * (at(x1, y0) - at(x0, y0));
            let low = at(x0, y1) + fx * (at(x1, y1) - at(x0, y1));
            top + fy * (low - top)
        };
        let mut bits = Vec::with_capacity(size[0] * size[1]);
        for y in 0..size[1] {
            for x in 0..size[0] {
                let p = [(corner[0] + x) as f64 + 0.5, (corner[1] + y) as f64 + 0.5];
                let inside = (0..2).all(|k| p[k] >= outline.min[k] && p[k] <= outline.max[k]);
                bits.push(inside && between(p) > 0.0);
            }
        }
        Self { corner, size, bits }
    }
}

#[cfg(test)]
mod tests {
    use super::super::letterbox::Anchor;
    use super::*;

    #[test]
    fn a_mask_is_the_weighted_sum_of_prototypes_inside_the_box() {
        // Prototypes of 8 x 8 cells of 4 px: the first is 1 on the left half, the second 1 everywhere.
        let left: Vec<f32> = (0..64).map(|i| if i % 8 < 4 { 1.0 } else { 0.0 }).collect();
        let prototypes = [left, vec![1.0; 64]].concat();
        let fit = Letterbox::fit([32, 32], [32, 32], Anchor::Middle);
        let outline = PixelBox { min: [8.0, 4.0], max: [28.0, 12.0] };
        let mask = Mask::of_prototypes(&[2.0, -1.0], &prototypes, [8, 8], 4.0, &outline, &fit, [32, 32]);
        // 2 left - 1 is above zero left of the middle between cells 3 and 4, at 16 px; the box begins at 8.
        assert_eq!((mask.corner, mask.size, mask.area()), ([8, 4], [20, 8], 8 * 8));
        assert!(mask.holds(15, 5) && !mask.holds(16, 5) && !mask.holds(7, 5) && !mask.holds(10, 13));
    }
}
