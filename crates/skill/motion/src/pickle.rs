//! Python's pickle format, read without Python: numbers, texts, lists, dictionaries and numpy arrays. Nothing in a file is ever run: the
//! few functions that numpy's arrays are made with are built in, and any other name is an error.
//!
//! Opcodes as documented in Python's `pickletools`, protocols 0 to 5; the reductions are those of numpy's `ndarray`, `dtype` and scalars.

mod arrays;
mod calls;
mod value;

use std::cell::Cell;
use std::collections::HashMap;

use value::function;
pub(crate) use value::{Id, Value};

/// What went wrong, and at which byte.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PickleError {
    pub offset: usize,
    pub expected: String,
    pub found: String,
}

/// Runs the opcodes; objects are kept in one list, so that one that is shared or changed later stays one object.
pub(crate) struct Machine<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Start of the current opcode.
    opcode: usize,
    objects: Vec<Value>,
    stack: Vec<Id>,
    marks: Vec<usize>,
    memo: HashMap<usize, Id>,
    /// Bytes of texts that were encoded.
    encoded: Cell<usize>,
}

type Result<T> = std::result::Result<T, PickleError>;

impl<'a> Machine<'a> {
    /// The machine after the whole file has been read, and the object that it describes.
    pub fn load(bytes: &'a [u8]) -> Result<(Self, Id)> {
        let mut machine = Self {
            bytes,
            at: 0,
            opcode: 0,
            objects: Vec::new(),
            stack: Vec::new(),
            marks: Vec::new(),
            memo: HashMap::new(),
            encoded: Cell::new(0),
        };
        while !machine.step()? {}
        let top = machine.pop()?;
        Ok((machine, top))
    }

    pub fn get(&self, id: Id) -> &Value {
        &self.objects[id]
    }

    /// An error at the current opcode (after loading: the end).
    pub fn error(&self, expected: impl Into<String>, found: impl Into<String>) -> PickleError {
        PickleError { offset: self.opcode, expected: expected.into(), found: found.into() }
    }

    fn take(&mut self, n: usize) -> Result<&'a [u8]> {
        match self.at.checked_add(n).and_then(|end| self.bytes.get(self.at..end)) {
            Some(slice) => {
                self.at += n;
                Ok(slice)
            }
            None => Err(self.error(format!("{n} more bytes"), "the end of the file")),
        }
    }

    fn uint(&mut self, n: usize) -> Result<usize> {
        let bytes = self.take(n)?;
        let value = bytes.iter().rev().fold(0u64, |v, b| v << 8 | u64::from(*b));
        usize::try_from(value).map_err(|_| self.error("a length", value.to_string()))
    }

    /// The rest of the line.
    fn line(&mut self) -> Result<&'a str> {
        let rest = &self.bytes[self.at..];
        let Some(length) = rest.iter().position(|b| *b == b'\n') else {
            return Err(self.error("a line", "the end of the file"));
        };
        self.at += length + 1;
        std::str::from_utf8(&rest[..length]).map_err(|_| self.error("a text", "bytes that are none"))
    }

    fn text(&mut self, length: usize) -> Result<Value> {
        let bytes = self.take(length)?;
        match std::str::from_utf8(bytes) {
            Ok(text) => Ok(Value::Text(text.to_owned())),
            Err(_) => Err(self.error("a text", "bytes that are none")),
        }
    }

    fn parse<T: std::str::FromStr>(&mut self, what: &str) -> Result<T> {
        let line = self.line()?;
        let number = line.strip_suffix('L').unwrap_or(line);
        number.trim().parse().map_err(|_| self.error(what, shown(line)))
    }

    fn push(&mut self, value: Value) {
        self.objects.push(value);
        self.stack.push(self.objects.len() - 1);
    }

    fn pop(&mut self) -> Result<Id> {
        let floor = self.marks.last().copied().unwrap_or(0);
        if self.stack.len() > floor
            && let Some(id) = self.stack.pop()
        {
            return Ok(id);
        }
        Err(self.error("an object on the stack", "none"))
    }

    fn since_mark(&mut self) -> Result<Vec<Id>> {
        match self.marks.pop() {
            Some(mark) => Ok(self.stack.split_off(mark)),
            None => Err(self.error("a mark on the stack", "none")),
        }
    }

    fn top(&self) -> Result<Id> {
        self.stack.last().copied().ok_or_else(|| self.error("an object on the stack", "none"))
    }

    fn tuple(&mut self, n: usize) -> Result<()> {
        let mut items = (0..n).map(|_| self.pop()).collect::<Result<Vec<_>>>()?;
        items.reverse();
        self.push(Value::Tuple(items));
        Ok(())
    }

    fn append(&mut self, items: Vec<Id>) -> Result<()> {
        let list = self.top()?;
        match &mut self.objects[list] {
            Value::List(all) => {
                all.extend(items);
                Ok(())
            }
            other => {
                let found = other.name();
                Err(self.error("a list", found))
            }
        }
    }

    fn set_items(&mut self, items: &[Id]) -> Result<()> {
        let dict = self.top()?;
        if items.len() % 2 == 1 {
            return Err(self.error("a value for every key", "a key alone"));
        }
        match &mut self.objects[dict] {
            Value::Dict(all) => {
                all.extend(items.chunks_exact(2).map(|pair| (pair[0], pair[1])));
                Ok(())
            }
            other => {
                let found = other.name();
                Err(self.error("a dictionary", found))
            }
        }
    }

    fn global(&mut self, module: &str, name: &str) -> Result<()> {
        match function(module, name) {
            Some(function) => {
                self.push(Value::Function(function));
                Ok(())
            }
            None => {
                let found =
                    format!("the name '{}' (nothing in a file is run)", shown(&format!("{module}.{name}")));
                Err(self.error("numbers, texts and numpy arrays", found))
            }
        }
    }

    fn remember(&mut self, key: usize) -> Result<()> {
        let top = self.top()?;
        self.memo.insert(key, top);
        Ok(())
    }

    fn recall(&mut self, key: usize) -> Result<()> {
        match self.memo.get(&key) {
            Some(&id) => {
                self.stack.push(id);
                Ok(())
            }
            None => Err(self.error("an object seen before", format!("number {key}"))),
        }
    }

    /// One opcode; true at the end.
    fn step(&mut self) -> Result<bool> {
        self.opcode = self.at;
        match self.take(1)?[0] {
            b'.' => return Ok(true),
            0x80 => {
                let protocol = self.uint(1)?;
                if protocol > 5 {
                    return Err(self.error("protocol 0 to 5", protocol.to_string()));
                }
            }
            0x95 => {
                self.take(8)?;
            }
            b'(' => self.marks.push(self.stack.len()),
            b'0' => {
                self.pop()?;
            }
            b'1' => {
                self.since_mark()?;
            }
            b'N' => self.push(Value::None),
            0x88 => self.push(Value::Int(1)),
            0x89 => self.push(Value::Int(0)),
            b'I' | b'L' => {
                let value = self.parse("a whole number")?;
                self.push(Value::Int(value));
            }
            b'J' => {
                let value = self.uint(4)? as u32 as i32;
                self.push(Value::Int(i64::from(value)));
            }
            b'K' => {
                let value = self.uint(1)? as i64;
                self.push(Value::Int(value));
            }
            b'M' => {
                let value = self.uint(2)? as i64;
                self.push(Value::Int(value));
            }
            0x8a => self.long()?,
            b'F' => {
                let value = self.parse("a number")?;
                self.push(Value::Float(value));
            }
            b'G' => {
                let bits = self.take(8)?.iter().fold(0u64, |v, b| v << 8 | u64::from(*b));
                self.push(Value::Float(f64::from_bits(bits)));
            }
            b'V' | b'S' => {
                let line = self.line()?.trim_matches('\'').to_owned();
                self.push(Value::Text(line));
            }
            op @ (0x8c | b'X' | 0x8d | b'U' | b'T') => {
                let width = [1, 4, 8][usize::from(matches!(op, b'X' | b'T')) + 2 * usize::from(op == 0x8d)];
                let length = self.uint(width)?;
                let value = self.text(length)?;
                self.push(value);
            }
            op @ (b'C' | b'B' | 0x8e | 0x96) => {
                let width = [1, 4, 8][usize::from(op == b'B') + 2 * usize::from(op >= 0x8e)];
                let length = self.uint(width)?;
                let bytes = self.take(length)?.to_vec();
                self.push(Value::Bytes(bytes));
            }
            b']' => self.push(Value::List(Vec::new())),
            b'}' => self.push(Value::Dict(Vec::new())),
            b')' => self.push(Value::Tuple(Vec::new())),
            b'l' => {
                let items = self.since_mark()?;
                self.push(Value::List(items));
            }
            b't' => {
                let items = self.since_mark()?;
                self.push(Value::Tuple(items));
            }
            b'd' => {
                let items = self.since_mark()?;
                self.push(Value::Dict(Vec::new()));
                self.set_items(&items)?;
            }
            op @ 0x85..=0x87 => self.tuple(usize::from(op - 0x84))?,
            b'a' => {
                let item = self.pop()?;
                self.append(vec![item])?;
            }
            b'e' => {
                let items = self.since_mark()?;
                self.append(items)?;
            }
            b's' => {
                let (value, key) = (self.pop()?, self.pop()?);
                self.set_items(&[key, value])?;
            }
            b'u' => {
                let items = self.since_mark()?;
                self.set_items(&items)?;
            }
            b'c' => {
                let (module, name) = (self.line()?, self.line()?);
                self.global(module, name)?;
            }
            0x93 => {
                let (name, module) = (self.pop()?, self.pop()?);
                let (Value::Text(module), Value::Text(name)) =
                    (self.get(module).clone(), self.get(name).clone())
                else {
                    return Err(self.error("a name", "other objects"));
                };
                self.global(&module, &name)?;
            }
            b'R' => self.reduce()?,
            b'b' => self.build()?,
            0x94 => self.remember(self.memo.len())?,
            b'p' => {
                let key = self.parse("a number")?;
                self.remember(key)?;
            }
            b'g' => {
                let key = self.parse("a number")?;
                self.recall(key)?;
            }
            op @ (b'q' | b'r') => {
                let key = self.uint(if op == b'q' { 1 } else { 4 })?;
                self.remember(key)?;
            }
            op @ (b'h' | b'j') => {
                let key = self.uint(if op == b'h' { 1 } else { 4 })?;
                self.recall(key)?;
            }
            other => {
                return Err(self.error(
                    "an instruction for numbers, texts, lists and arrays",
                    format!("byte 0x{other:02x}"),
                ));
            }
        }
        Ok(false)
    }

    fn long(&mut self) -> Result<()> {
        let length = self.uint(1)?;
        let bytes = self.take(length)?;
        if length > 8 {
            return Err(self.error("a number of at most 8 bytes", format!("{length} bytes")));
        }
        let sign = bytes.last().is_some_and(|b| b & 0x80 != 0);
        let mut all = [if sign { 0xff } else { 0 }; 8];
        all[..length].copy_from_slice(bytes);
        self.push(Value::Int(i64::from_le_bytes(all)));
        Ok(())
    }
}

fn shown(text: &str) -> String {
    text.chars().take(60).collect()
}
