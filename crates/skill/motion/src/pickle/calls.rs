//! The few functions that numpy's arrays are made with.

use super::value::{Function, Id, Kind, Value};
use super::{Machine, Result, shown};

impl Machine<'_> {
    fn arguments(&self, id: Id) -> Result<&[Id]> {
        match self.get(id) {
            Value::Tuple(items) if items.len() <= 16 => Ok(items),
            other => Err(self.error("arguments", other.name())),
        }
    }

    /// Calls a built-in function.
    pub(super) fn reduce(&mut self) -> Result<()> {
        let (arguments, callee) = (self.pop()?, self.pop()?);
        let Value::Function(function) = *self.get(callee) else {
            return Err(self.error("a function", self.get(callee).name()));
        };
        let ids = self.arguments(arguments)?;
        let values: Vec<&Value> = ids.iter().map(|id| self.get(*id)).collect();
        let value = match (function, &values[..]) {
            (Function::Reconstruct, [Value::Function(Function::NdArray), ..]) => {
                Value::Array(Vec::new(), None)
            }
            (Function::DType, [Value::Text(name), ..]) => Value::Kind(self.kind(name)?),
            (Function::Encode, [Value::Text(text), ..]) => {
                // Calls cost a few bytes of the file: without a bound a small file could ask for all memory.
                self.encoded.set(self.encoded.get() + text.len());
                if self.encoded.get() > 2 * self.bytes.len() {
                    return Err(self.error("each text encoded once", "a text encoded again and again"));
                }
                match text.chars().map(|c| u8::try_from(c).ok()).collect() {
                    Some(bytes) => Value::Bytes(bytes),
                    None => return Err(self.error("a text of Latin letters", "others")),
                }
            }
            (Function::Scalar, [Value::Kind(kind), Value::Bytes(bytes)]) if bytes.len() == kind.size => {
                Value::Float(kind.numbers(bytes)[0])
            }
            (
                Function::FromBuffer,
                [Value::Bytes(_), Value::Kind(kind), Value::Tuple(shape), Value::Text(order)],
            ) => Value::Array(self.shape(shape)?, Some((*kind, order == "F", ids[0]))),
            _ => return Err(self.error("arguments as numpy gives them", format!("others for {function:?}"))),
        };
        self.push(value);
        Ok(())
    }

    fn kind(&self, name: &str) -> Result<Kind> {
        let (letter, size) = name.split_at_checked(1).unwrap_or(("", ""));
        match (letter.as_bytes(), size.parse()) {
            ([letter @ b'f'], Ok(size @ (4 | 8)))
            | ([letter @ (b'i' | b'u')], Ok(size @ (1 | 2 | 4 | 8)))
            | ([letter @ b'b'], Ok(size @ 1)) => Ok(Kind { letter: *letter, size, big_endian: false }),
            _ => Err(self.error("numbers of type f4, f8, i1 to i8 or b1", format!("type '{}'", shown(name)))),
        }
    }

    fn shape(&self, ids: &[Id]) -> Result<Vec<usize>> {
        if ids.len() > 8 {
            return Err(self.error("a shape of at most 8 sizes", ids.len().to_string()));
        }
        let size = |id: &Id| match self.get(*id) {
            Value::Int(n) => usize::try_from(*n).ok(),
            _ => None,
        };
        ids.iter().map(size).collect::<Option<Vec<_>>>().ok_or_else(|| self.error("a shape", "other objects"))
    }

    /// Gives an array or a type its state.
    pub(super) fn build(&mut self) -> Result<()> {
        let state = self.pop()?;
        let target = self.top()?;
        let ids = self.arguments(state)?;
        let values: Vec<&Value> = ids.iter().map(|id| self.get(*id)).collect();
        let built = match (self.get(target), &values[..]) {
            (Value::Kind(kind), [_, Value::Text(order), ..]) => {
                Value::Kind(Kind { big_endian: order == ">", ..*kind })
            }
            (
                Value::Array(..),
                [_, Value::Tuple(shape), Value::Kind(kind), Value::Int(fortran), Value::Bytes(_)],
            ) => Value::Array(self.shape(shape)?, Some((*kind, *fortran != 0, ids[4]))),
            (other, _) => return Err(self.error("a numpy array or type to build", other.name())),
        };
        self.objects[target] = built;
        Ok(())
    }
}
