//! Squares and their normal equations.

use super::super::rows::{Band, Row};

/// Adds squares up, and, if there is a band, their normal equations.
pub(super) struct Sum<'b> {
    pub cost: f64,
    pub band: Option<&'b mut Band>,
    pub row: Row,
}

impl Sum<'_> {
    /// A residual `r`, of which `width` counts one; `fill` writes its derivatives.
    pub fn square(&mut self, r: f64, width: f64, fill: impl FnOnce(&mut Row)) {
        let w2 = 1.0 / (width * width);
        self.cost += w2 * r * r;
        if let Some(band) = self.band.as_deref_mut() {
            self.row.clear();
            fill(&mut self.row);
            band.add(&mut self.row, r, w2);
        }
    }

    /// As [`Sum::square`] where `r` is negative; nothing where it is not.
    pub fn at_least_zero(&mut self, r: f64, width: f64, fill: impl FnOnce(&mut Row)) {
        if r < 0.0 {
            self.square(r, width, fill);
        }
    }
}
