//! Arrays of any type and shape in either order of rows and columns, in a whole archive: an error or points that are whole, never a panic.
#![no_main]

use std::io::{Cursor, Write as _};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

const TYPES: [&str; 8] = ["<f4", "<f8", "<i4", "<i8", ">f4", "<U1", "|b1", "<c8"];

/// An NPY file: its head says type, order and shape.
fn npy(kind: &str, columns_first: bool, shape: &[u8], data: &[u8]) -> Vec<u8> {
    let order = if columns_first { "True" } else { "False" };
    let shape: String = shape.iter().map(|side| format!("{side}, ")).collect();
    let mut head = format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': ({shape}), }}");
    while (10 + head.len() + 1) % 16 != 0 {
        head.push(' ');
    }
    head.push('\n');
    [&b"\x93NUMPY\x01\x00"[..], &(head.len() as u16).to_le_bytes(), head.as_bytes(), data].concat()
}

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let Some(([flags, a, b, c, d], data)) = input.split_first_chunk::<5>() else { return };
    let (kind, columns_first) = (TYPES[usize::from(flags & 7)], flags & 8 == 8);
    let shape = &[*a, *b, *c, *d][..usize::from(flags >> 4 & 7).min(4)];
    let names: Vec<u8> = (0..u32::from(*b)).flat_map(|k| (u32::from('a') + k).to_le_bytes()).collect();
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let entries = [
        ("positions.npy", npy(kind, columns_first, shape, data)),
        ("joint_names.npy", npy("<U1", columns_first, &[*b], &names)),
        ("fps.npy", npy("<f8", false, &[], &50.0_f64.to_le_bytes())),
    ];
    for (name, bytes) in entries {
        let written = archive.start_file(name, stored).map(|()| archive.write_all(&bytes));
        written.expect("an entry").expect("written");
    }
    let bytes = archive.finish().expect("an archive").into_inner();
    if let Ok(points) = paid_motion::parse_points(bytes, Path::new("fuzz.npz")) {
        assert_eq!(points.pos.len(), points.frames * points.names.len());
        assert!(points.pos.as_flattened().iter().all(|x| x.is_finite()));
    }
});
