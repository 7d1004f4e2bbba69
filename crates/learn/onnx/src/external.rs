//! Weights in a second file: an exporter may write constants next to the model (`a.onnx` and `a.onnx.data`). They are put into the model's
//! bytes where they belong, so that later code sees one file.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::path::{Component, Path};

use prost::bytes::Buf;
use prost::encoding::{
    DecodeContext, WireType, bytes, decode_key, decode_varint, encode_key, encode_varint, skip_field,
};
use prost::{DecodeError, Message};

use crate::error::OnnxError;
use crate::proto::{EXTERNAL, TensorProto};
use crate::raw::pointer;

/// Most bytes of a model with its weights: no protobuf message may be longer.
const MOST_BYTES: u64 = i32::MAX as u64;
/// Deepest nesting of graphs in graphs, in messages.
const MOST_DEPTH: usize = 100;
/// Tags of `TensorProto`.
const RAW_DATA: u32 = 9;
const EXTERNAL_DATA: u32 = 13;
const DATA_LOCATION: u32 = 14;

/// The model's bytes with the constants of other files in `folder` in them; `None` if it names no other file. `path` names it in errors.
///
/// # Errors
/// If a file of weights is missing, shorter than the model says or outside `folder`, or there is no folder.
pub(crate) fn inlined(
    model: &[u8],
    path: &Path,
    folder: Option<&Path>,
) -> Result<Option<Vec<u8>>, OnnxError> {
    Inliner { path, folder, files: HashMap::new(), total: 0 }.message(Kind::Model, model, 0)
}

/// The messages that can hold a constant.
#[derive(Clone, Copy)]
enum Kind {
    Model,
    Graph,
    Node,
    Attribute,
    Tensor,
}

impl Kind {
    /// The message in a field, if it can hold a constant (field numbers of onnx.proto).
    fn field(self, tag: u32) -> Option<Self> {
        match (self, tag) {
            (Self::Model, 7) | (Self::Attribute, 6 | 11) => Some(Self::Graph),
            (Self::Graph, 1) => Some(Self::Node),
            (Self::Node, 5) => Some(Self::Attribute),
            (Self::Graph, 5) | (Self::Attribute, 5 | 10) => Some(Self::Tensor),
            _ => None,
        }
    }
}

struct Field {
    tag: u32,
    wire: WireType,
    whole: Range<usize>,
    body: Range<usize>,
}

/// The fields of a message.
fn fields(message: &[u8]) -> Result<Vec<Field>, DecodeError> {
    let mut rest = message;
    let mut all = Vec::new();
    while rest.has_remaining() {
        let start = message.len() - rest.len();
        let (tag, wire) = decode_key(&mut rest)?;
        let mut body = message.len() - rest.len();
        if wire == WireType::LengthDelimited {
            let mut after = rest;
            decode_varint(&mut after)?;
            body = message.len() - after.len();
        }
        skip_field(wire, tag, &mut rest, DecodeContext::default())?;
        let end = message.len() - rest.len();
        all.push(Field { tag, wire, whole: start..end, body: body..end });
    }
    Ok(all)
}

struct Inliner<'a> {
    path: &'a Path,
    folder: Option<&'a Path>,
    /// The files that were read, by the name in the model.
    files: HashMap<String, Vec<u8>>,
    total: u64,
}

impl Inliner<'_> {
    /// A message with its constants in it; `None` if they are already.
    fn message(&mut self, kind: Kind, message: &[u8], depth: usize) -> Result<Option<Vec<u8>>, OnnxError> {
        let wrong = |reason: String| OnnxError::Decode { path: self.path.to_owned(), reason };
        if depth > MOST_DEPTH {
            return Err(wrong(format!("expected at most {MOST_DEPTH} nested messages, found more")));
        }
        let fields = fields(message).map_err(|e| wrong(e.to_string()))?;
        if matches!(kind, Kind::Tensor) {
            return self.tensor(message, &fields);
        }
        let mut out = Vec::new();
        let mut copied = 0;
        for field in fields.iter().filter(|field| field.wire == WireType::LengthDelimited) {
            let Some(inner) = kind.field(field.tag) else { continue };
            if let Some(whole) = self.message(inner, &message[field.body.clone()], depth + 1)? {
                out.extend_from_slice(&message[copied..field.whole.start]);
                encode_key(field.tag, WireType::LengthDelimited, &mut out);
                encode_varint(whole.len() as u64, &mut out);
                out.extend(whole);
                copied = field.whole.end;
            }
        }
        if copied == 0 {
            return Ok(None);
        }
        out.extend_from_slice(&message[copied..]);
        Ok(Some(out))
    }

    fn tensor(&mut self, message: &[u8], fields: &[Field]) -> Result<Option<Vec<u8>>, OnnxError> {
        // Constants are large: decoded only if their numbers are elsewhere.
        if !fields.iter().any(|field| field.tag == DATA_LOCATION) {
            return Ok(None);
        }
        let tensor = TensorProto::decode(message)
            .map_err(|e| OnnxError::Decode { path: self.path.to_owned(), reason: e.to_string() })?;
        if tensor.data_location != Some(EXTERNAL) {
            return Ok(None);
        }
        let mut out = Vec::new();
        for field in fields {
            if ![RAW_DATA, EXTERNAL_DATA, DATA_LOCATION].contains(&field.tag) {
                out.extend_from_slice(&message[field.whole.clone()]);
            }
        }
        bytes::encode(RAW_DATA, &self.elements(&tensor)?, &mut out);
        Ok(Some(out))
    }

    /// The bytes of a constant from its file.
    fn elements(&mut self, tensor: &TensorProto) -> Result<Vec<u8>, OnnxError> {
        let wrong = |expected: String, found: String| OnnxError::External {
            path: self.path.to_owned(),
            tensor: tensor.name.clone().unwrap_or_default(),
            expected,
            found,
        };
        let entry = |key: &str| {
            let entry = tensor.external_data.iter().find(|e| e.key.as_deref() == Some(key));
            entry.map(|e| e.value.clone().unwrap_or_default())
        };
        let number = |key: &str| match entry(key) {
            None => Ok(None),
            Some(text) => {
                let number = text.trim().parse::<usize>();
                number
                    .map(Some)
                    .map_err(|_| wrong(format!("a number of bytes as its {key}"), format!("{text:?}")))
            }
        };
        let location = entry("location").unwrap_or_default();
        let name = Path::new(&location);
        let inside = !location.is_empty()
            && name.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !inside {
            let expected = "a file in the model's folder, without a path from the root and without '..'";
            return Err(wrong(expected.to_owned(), format!("{location:?}")));
        }
        let Some(folder) = self.folder else {
            return Err(wrong(format!("the file {location:?}"), "a model without a folder".to_owned()));
        };
        let (offset, length) = (number("offset")?.unwrap_or(0), number("length")?);
        let file = match self.files.entry(location.clone()) {
            Entry::Occupied(read) => read.into_mut(),
            Entry::Vacant(place) => {
                let file = folder.join(name);
                let expected = || format!("{}", file.display());
                let metadata = std::fs::metadata(&file).map_err(|e| wrong(expected(), e.to_string()))?;
                if !metadata.is_file() || metadata.len() > MOST_BYTES {
                    let found = format!("{} bytes, or no file", metadata.len());
                    return Err(wrong(
                        format!("{}, a file of at most {MOST_BYTES} bytes", expected()),
                        found,
                    ));
                }
                let bytes = std::fs::read(&file).map_err(|e| wrong(expected(), e.to_string()))?;
                if let Some(words) = pointer(&bytes) {
                    return Err(wrong(expected(), words));
                }
                place.insert(bytes)
            }
        };
        let end = length.map_or(Some(file.len()), |length| offset.checked_add(length));
        let part = end.and_then(|end| file.get(offset..end)).ok_or_else(|| {
            let bytes = length.map_or_else(String::new, |length| format!("{length} bytes "));
            wrong(
                format!("{bytes}from byte {offset} of {location:?}"),
                format!("{} bytes in all", file.len()),
            )
        })?;
        self.total += part.len() as u64;
        if self.total > MOST_BYTES {
            return Err(wrong(format!("at most {MOST_BYTES} bytes in all"), "more".to_owned()));
        }
        Ok(part.to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::proto::{GraphProto, ModelProto, StringStringEntry};
    use crate::raw::OnnxFile;

    /// A model with one constant in another file.
    fn model(entries: &[(&str, &str)]) -> Vec<u8> {
        let entry = |(key, value): &(&str, &str)| StringStringEntry {
            key: Some((*key).to_owned()),
            value: Some((*value).to_owned()),
        };
        let elsewhere = TensorProto {
            raw_data: None,
            external_data: entries.iter().map(entry).collect(),
            data_location: Some(EXTERNAL),
            ..TensorProto::float("w", &[2], &[])
        };
        let here = TensorProto::float("b", &[1], &[7.0]);
        let graph = GraphProto { initializer: vec![here, elsewhere], ..GraphProto::default() };
        let mut bytes = ModelProto { graph: Some(graph), ..ModelProto::default() }.encode_to_vec();
        // A field that this program does not declare: a description (tag 6).
        bytes::encode(6, &b"kept".to_vec(), &mut bytes);
        bytes
    }

    fn read(entries: &[(&str, &str)]) -> Result<OnnxFile, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let numbers: Vec<u8> = [1.0_f32, 2.0, 3.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        std::fs::write(folder.path().join("a.onnx.data"), numbers).expect("writes");
        std::fs::write(folder.path().join("a.onnx"), model(entries)).expect("writes");
        OnnxFile::read(&folder.path().join("a.onnx")).map_err(|error| error.to_string())
    }

    #[test]
    fn a_constant_in_a_second_file_is_read_as_if_it_were_in_the_model() {
        for entries in [
            &[("location", "a.onnx.data"), ("offset", "4"), ("length", "8")][..],
            &[("location", "./a.onnx.data"), ("offset", "4")],
            &[("location", "a.onnx.data"), ("offset", "4"), ("length", "8"), ("checksum", "0")],
        ] {
            let file = read(entries).expect("reads");
            let graph = file.proto.graph.as_ref().expect("a graph");
            let expected =
                [TensorProto::float("b", &[1], &[7.0]), TensorProto::float("w", &[2], &[2.0, 3.0])];
            assert_eq!(graph.initializer, expected);
        }
        let whole = [("location", "a.onnx.data")];
        let file = read(&whole).expect("reads");
        let constant = &file.proto.graph.as_ref().expect("a graph").initializer[1];
        assert_eq!(constant.raw_data.as_ref().map(Vec::len), Some(12));
    }

    #[test]
    fn fields_that_are_not_declared_here_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("w"), [0; 8]).expect("writes");
        let bytes = inlined(&model(&[("location", "w")]), Path::new("a.onnx"), Some(folder.path()));
        let bytes = bytes.expect("reads").expect("has a constant elsewhere");
        assert!(bytes.ends_with(b"kept"));
        assert_eq!(inlined(&bytes, Path::new("a.onnx"), None).expect("reads"), None);
    }

    #[test]
    fn weights_outside_the_folder_missing_or_too_short_are_refused() {
        for (entries, parts) in [
            (&[("location", "../secret")][..], ["'w'", "a file in the model's folder", "\"../secret\""]),
            (&[("location", "b/../../secret")], ["'w'", "without '..'", "\"b/../../secret\""]),
            (&[("location", "/etc/passwd")], ["'w'", "without a path from the root", "\"/etc/passwd\""]),
            (&[], ["'w'", "a file in the model's folder", "found \"\""]),
            (&[("location", "other.data")], ["'w'", "other.data", "external_data=False"]),
            (&[("location", ".")], ["'w'", "a file of at most 2147483647 bytes", "or no file"]),
            (
                &[("location", "a.onnx.data"), ("offset", "8"), ("length", "8")],
                ["'w'", "8 bytes from byte 8 of \"a.onnx.data\"", "found 12 bytes in all"],
            ),
            (
                &[("location", "a.onnx.data"), ("length", "18446744073709551615"), ("offset", "8")],
                ["'w'", "from byte 8", "found 12 bytes in all"],
            ),
            (
                &[("location", "a.onnx.data"), ("offset", "-4")],
                ["'w'", "a number of bytes as its offset", "\"-4\""],
            ),
        ] {
            let error = read(entries).expect_err("refused");
            for part in ["a.onnx: "].iter().chain(&parts) {
                assert!(error.contains(part), "{part}: {error}");
            }
        }
        let folder = tempfile::tempdir().expect("a folder");
        let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n";
        std::fs::write(folder.path().join("w"), pointer).expect("writes");
        std::fs::write(folder.path().join("a.onnx"), model(&[("location", "w")])).expect("writes");
        let error = OnnxFile::read(&folder.path().join("a.onnx")).expect_err("a pointer").to_string();
        assert!(error.contains("git lfs pull"), "{error}");
        let error = OnnxFile::read(&folder.path().join("w")).expect_err("a pointer").to_string();
        assert!(error.contains("not a complete ONNX model: a Git LFS pointer"), "{error}");
        let bytes = model(&[("location", "a.onnx.data")]);
        let error = OnnxFile::from_bytes(bytes, Path::new("a.onnx")).expect_err("no folder").to_string();
        assert!(error.contains("\"a.onnx.data\"") && error.contains("without a folder"), "{error}");
    }
}
