//! Numbers out of a pickle.

use super::Machine;
use super::value::{Id, Value};

/// How many more numbers than bytes a file may stand for, by rows that occur again: twelve minutes of a humanoid at 50 Hz.
const REPEATED: usize = 1 << 20;

impl Machine<'_> {
    /// The numbers of an array or of nested lists in row-major order, if their shape `fits`.
    ///
    /// # Errors
    /// What is there instead.
    pub fn numbers(&self, id: Id, fits: impl Fn(&[usize]) -> bool) -> Result<Vec<f64>, String> {
        let other = || self.get(id).name().to_owned();
        let shape = self.dimensions(id).ok_or_else(other)?;
        if !fits(&shape) {
            return Err(format!("shape {shape:?}"));
        }
        // A row that occurs again costs two bytes of the file: without a bound a small file could ask for all memory.
        let count = shape.iter().try_fold(1usize, |n, s| n.checked_mul(*s));
        if count.is_none_or(|n| n > self.bytes.len().saturating_add(REPEATED)) {
            return Err(format!("shape {shape:?} in a file of {} bytes", self.bytes.len()));
        }
        self.values(id).ok_or_else(other)
    }

    /// The shape of an array or of nested lists, of which no number is read; `None` if it is neither.
    fn dimensions(&self, id: Id) -> Option<Vec<usize>> {
        match self.get(id) {
            Value::Int(_) | Value::Float(_) => Some(Vec::new()),
            Value::Array(shape, Some(_)) => Some(shape.clone()),
            // Lists of numbers or of such lists, no deeper.
            Value::List(items) | Value::Tuple(items) => {
                let width = items.first().map_or(Some(0), |item| self.width(*item))?;
                let same = items.iter().all(|item| self.width(*item) == Some(width));
                same.then(|| vec![items.len(), width])
            }
            _ => None,
        }
    }

    /// How many items a row has.
    fn width(&self, id: Id) -> Option<usize> {
        match self.get(id) {
            Value::Array(shape, Some(_)) if shape.len() == 1 => shape.first().copied(),
            Value::List(items) | Value::Tuple(items) => Some(items.len()),
            _ => None,
        }
    }

    fn values(&self, id: Id) -> Option<Vec<f64>> {
        match self.get(id) {
            Value::Int(n) => Some(vec![*n as f64]),
            Value::Float(x) => Some(vec![*x]),
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
                        Some((0..count).map(at).collect())
                    }
                    (true, [_, _, _, ..]) => None,
                    _ => Some(values),
                }
            }
            Value::List(items) | Value::Tuple(items) => {
                let mut values = Vec::new();
                for item in items {
                    values.extend(self.row(*item)?);
                }
                Some(values)
            }
            _ => None,
        }
    }

    fn row(&self, id: Id) -> Option<Vec<f64>> {
        match self.get(id) {
            Value::Array(shape, _) if shape.len() == 1 => self.values(id),
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
