//! Numbers out of a pickle.

use super::Machine;
use super::value::{Id, Value};

impl Machine<'_> {
    /// An array, or nested lists of numbers, as shape and numbers in row-major order; `None` if it is neither.
    pub fn numbers(&self, id: Id) -> Option<(Vec<usize>, Vec<f64>)> {
        match self.get(id) {
            Value::Int(n) => Some((Vec::new(), vec![*n as f64])),
            Value::Float(x) => Some((Vec::new(), vec![*x])),
            Value::Array(shape, Some((kind, fortran, bytes))) => {
                let Value::Bytes(bytes) = self.get(*bytes) else { return None };
                let count = shape.iter().try_fold(1usize, |n, s| n.checked_mul(*s))?;
                if count.checked_mul(kind.size)? != bytes.len() {
                    return None;
                }
                let values = kind.numbers(bytes);
                match (fortran, &shape[..]) {
                    (true, &[rows, columns]) => {
                        let at = |i: usize| values[i % columns * rows + i / columns];
                        Some((shape.clone(), (0..count).map(at).collect()))
                    }
                    (true, [_, _, _, ..]) => None,
                    _ => Some((shape.clone(), values)),
                }
            }
            // Lists of numbers or of such lists, no deeper.
            Value::List(items) | Value::Tuple(items) => {
                let rows: Option<Vec<Vec<f64>>> = items.iter().map(|item| self.row(*item)).collect();
                let rows = rows?;
                let width = rows.first().map_or(0, Vec::len);
                if rows.iter().any(|r| r.len() != width) {
                    return None;
                }
                Some((vec![rows.len(), width], rows.concat()))
            }
            _ => None,
        }
    }

    fn row(&self, id: Id) -> Option<Vec<f64>> {
        match self.get(id) {
            Value::Array(shape, _) if shape.len() == 1 => self.numbers(id).map(|(_, values)| values),
            Value::List(items) | Value::Tuple(items) => {
                let number = |item: &Id| match self.get(*item) {
                    Value::Int(n) => Some(*n as f64),
                    Value::Float(x) => Some(*x),
                    _ => None,
                };
                items.iter().map(number).collect()
            }
            _ => None,
        }
    }
}
