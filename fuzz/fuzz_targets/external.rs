//! Any words on where a model's constant lies, and any bytes there: an error, or the constant's own bytes, never a panic.
#![no_main]

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use paid_onnx::OnnxFile;
use paid_onnx::proto::{EXTERNAL, GraphProto, ModelProto, StringStringEntry, TensorProto};
use prost::Message;

/// A folder of this process.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("paid-fuzz-external-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        folder
    })
}

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    // Three words up to a byte 0 each: location (the file `w`, if it is empty), offset and length; the rest is that file.
    let mut parts = input.splitn(4, |byte| *byte == 0);
    let mut word = || String::from_utf8_lossy(parts.next().unwrap_or_default()).into_owned();
    let [location, offset, length] = [word(), word(), word()];
    let rest = parts.next().unwrap_or_default();
    let location = if location.is_empty() { "w".to_owned() } else { location };
    let entries = [("location", location), ("offset", offset), ("length", length)];
    let entry =
        |(key, value): (&str, String)| StringStringEntry { key: Some(key.to_owned()), value: Some(value) };
    let constant = TensorProto {
        raw_data: None,
        external_data: entries.into_iter().filter(|(_, value)| !value.is_empty()).map(entry).collect(),
        data_location: Some(EXTERNAL),
        ..TensorProto::float("w", &[2], &[])
    };
    let graph = GraphProto { initializer: vec![constant], ..GraphProto::default() };
    let model = ModelProto { graph: Some(graph), ..ModelProto::default() }.encode_to_vec();
    let path = folder().join("a.onnx");
    std::fs::write(folder().join("w"), rest).expect("written");
    std::fs::write(&path, model).expect("written");
    let _ = OnnxFile::read(&path);
    // Any bytes as the model beside that file.
    std::fs::write(&path, input).expect("written");
    let _ = OnnxFile::read(&path);
});
