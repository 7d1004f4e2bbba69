//! Where a term's numbers go.

use paid_lanes::{Mat3, Real, Vec3};

/// Takes the numbers of an observation in order.
pub trait Sink<V: Real> {
    /// The next number.
    fn push(&mut self, value: V);

    /// A number for each element.
    #[inline(always)]
    fn push_all(&mut self, values: &[V]) {
        for value in values {
            self.push(*value);
        }
    }

    /// x, y, z.
    #[inline(always)]
    fn push_vec(&mut self, v: Vec3<V>) {
        for k in 0..3 {
            self.push(v.0[k]);
        }
    }

    /// The first two columns of a rotation, row by row.
    #[inline(always)]
    fn push_rotation(&mut self, m: &Mat3<V>) {
        for row in 0..3 {
            self.push(m.0[row][0]);
            self.push(m.0[row][1]);
        }
    }
}

impl<V: Real> Sink<V> for Vec<V> {
    #[inline(always)]
    fn push(&mut self, value: V) {
        Vec::push(self, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_is_its_first_two_columns_row_by_row() {
        let mut out = Vec::new();
        out.push_rotation(&Mat3([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]));
        assert_eq!(out, [1.0, 2.0, 4.0, 5.0, 7.0, 8.0]);
    }
}
