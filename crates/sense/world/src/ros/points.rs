//! `sensor_msgs/PointCloud2` of a LiDAR whose points have times.

use super::{SECOND_NS, Stamped, header, named};
use crate::cdr::{CdrReader, CdrWriter, Wrong};
use crate::{ScanMessage, SightError};

/// Points are measured within this of the header's stamp `[ns]`: a scan lasts a tenth of it.
const SPAN_NS: f64 = 1e9;
/// A scan whose points all have one time lasts this long for those who ask `[ns]`; it must last.
const SHORTEST_NS: u64 = 1;
/// Most fields of a point.
const MOST_FIELDS: usize = 64;
/// The message's numbers for kinds of fields.
const UINT8: u8 = 2;
const UINT32: u8 = 6;
const FLOAT32: u8 = 7;
const FLOAT64: u8 = 8;
/// Bits of a Livox tag with which the sensor doubts a point (rain, dust, edges).
const DOUBT: u8 = 0b0010_1010;
/// Bytes of a point as the usual driver of a Mid-360 lays it out.
const LIVOX_STEP: u32 = 26;

/// A field of a point.
#[derive(Clone, Debug)]
struct Field {
    name: String,
    offset: usize,
    kind: u8,
    count: u32,
}

impl Field {
    /// The kind's name and its bytes.
    fn kind(&self) -> (&'static str, usize) {
        match self.kind {
            1 => ("INT8", 1),
            UINT8 => ("UINT8", 1),
            3 => ("INT16", 2),
            4 => ("UINT16", 2),
            5 => ("INT32", 4),
            UINT32 => ("UINT32", 4),
            FLOAT32 => ("FLOAT32", 4),
            FLOAT64 => ("FLOAT64", 8),
            _ => ("an unknown kind", 0),
        }
    }
}

/// Where a point has its time.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Time {
    /// `timestamp`, FLOAT64: nanoseconds of the sensor's clock, or seconds.
    Absolute(usize),
    /// `offset_time`, UINT32: nanoseconds since the header's stamp.
    Since(usize),
}

/// What is read of a point.
struct Layout {
    place: [usize; 3],
    time: Time,
    tag: Option<usize>,
}

impl Layout {
    fn of(fields: &[Field], step: usize) -> Result<Self, Wrong> {
        let have = || {
            let one = |f: &Field| format!("{} {} at {}", f.name, f.kind().0, f.offset);
            fields.iter().map(one).collect::<Vec<_>>().join(", ")
        };
        for field in fields {
            let size = field.kind().1.saturating_mul(field.count.max(1) as usize);
            if size == 0 || field.offset.saturating_add(size) > step {
                return Err((format!("fields within the {step} bytes of a point"), have()));
            }
        }
        let at = |name: &str, kind: u8| {
            fields.iter().find(|f| f.name == name && f.kind == kind && f.count <= 1).map(|f| f.offset)
        };
        let missing = |expected: &str| (expected.to_owned(), have());
        let [Some(x), Some(y), Some(z)] = ["x", "y", "z"].map(|name| at(name, FLOAT32)) else {
            return Err(missing("fields x, y, z as FLOAT32"));
        };
        let time = at("timestamp", FLOAT64)
            .map(Time::Absolute)
            .or_else(|| at("offset_time", UINT32).map(Time::Since))
            .ok_or_else(|| missing("a time of each point: timestamp as FLOAT64 or offset_time as UINT32"))?;
        Ok(Self { place: [x, y, z], time, tag: at("tag", UINT8) })
    }
}

/// Bytes at a place of a point; the layout was checked to fit.
fn bytes<const N: usize>(point: &[u8], at: usize) -> [u8; N] {
    let mut out = [0; N];
    if let Some(found) = point.get(at..at + N) {
        out.copy_from_slice(found);
    }
    out
}

/// A LiDAR's scan (`sensor_msgs/PointCloud2`) whose points have `x`, `y`, `z` (FLOAT32, meters) and a time: `timestamp` (FLOAT64, nanoseconds
/// or seconds of the clock that stamps the header) or `offset_time` (UINT32, nanoseconds since the header's stamp). Fields are found by name,
/// wherever they are in a point.
///
/// Points at the origin, where nothing came back, are left out, and so are those that are not finite and those that a Livox `tag` doubts.
/// The scan begins with its first point's time and ends with its last one's, also of those left out.
///
/// # Errors
/// If the bytes are no such message, a field is missing or of another kind, or times are farther than a second from the stamp.
pub fn read_points(bytes: &[u8]) -> Result<Stamped<ScanMessage>, SightError> {
    named("LiDAR points", points(bytes))
}

fn points(message: &[u8]) -> Result<Stamped<ScanMessage>, Wrong> {
    let mut cdr = CdrReader::new(message)?;
    let (stamp_ns, frame) = header(&mut cdr)?;
    let (height, width) = (cdr.u32()? as usize, cdr.u32()? as usize);
    let count = cdr.length(13)?;
    if count > MOST_FIELDS {
        return Err((format!("at most {MOST_FIELDS} fields"), count.to_string()));
    }
    let mut fields = Vec::with_capacity(count);
    for _ in 0..count {
        let name = cdr.string()?;
        fields.push(Field { name, offset: cdr.u32()? as usize, kind: cdr.u8()?, count: cdr.u32()? });
    }
    let (big, step, row) = (cdr.u8()?, cdr.u32()? as usize, cdr.u32()? as usize);
    if big != 0 {
        return Err(("little-endian points".to_owned(), "big-endian ones".to_owned()));
    }
    let layout = Layout::of(&fields, step)?;
    let data = cdr.bytes()?;
    // Clouds in one row need not state its length.
    let row = if height == 1 && row == 0 { data.len() } else { row };
    let fits = step.checked_mul(width).is_some_and(|least| least <= row);
    if !fits || row.checked_mul(height) != Some(data.len()) {
        let expected = format!("{height} rows of {width} points of {step} bytes");
        return Err((expected, format!("{} bytes in rows of {row}", data.len())));
    }
    // Without data there are no points, in however many rows.
    let height = if data.is_empty() { 0 } else { height };

    let of_row = |row: usize, k: usize| &data[row..][k * step..(k + 1) * step];
    let each = (0..height).flat_map(|r| (0..width).map(move |k| of_row(r * row, k)));
    let mut scan = ScanMessage { start_ns: stamp_ns, end_ns: stamp_ns, points: Vec::new() };
    // Times from the stamp `[ns]`, of all points.
    let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
    for point in each {
        let after = match layout.time {
            Time::Since(at) => f64::from(u32::from_le_bytes(bytes(point, at))),
            Time::Absolute(at) => {
                let time = f64::from_le_bytes(bytes(point, at));
                let (ns, s) = (time - stamp_ns as f64, 1e9 * (time - stamp_ns as f64 * 1e-9));
                if ns.abs() <= s.abs() { ns } else { s }
            }
        };
        if after.is_nan() || after.abs() > SPAN_NS {
            let expected = "times of points within a second of the header's stamp, in ns or s of its clock";
            return Err((expected.to_owned(), format!("one {:.3} s from it", after * 1e-9)));
        }
        (first, last) = (first.min(after), last.max(after));
        let place = layout.place.map(|at| f64::from(f32::from_le_bytes(bytes(point, at))));
        let doubted = layout.tag.is_some_and(|at| bytes::<1>(point, at)[0] & DOUBT != 0);
        if !doubted && place.iter().all(|x| x.is_finite()) && place != [0.0; 3] {
            let [x, y, z] = place;
            scan.points.push([x, y, z, after]);
        }
    }
    if first <= last {
        let at = |after: f64| (i128::from(stamp_ns) + after.round() as i128).max(0) as u64;
        (scan.start_ns, scan.end_ns) = (at(first), at(last));
        scan.points.iter_mut().for_each(|point| point[3] = (point[3] - first) / SECOND_NS as f64);
    }
    scan.end_ns = scan.end_ns.max(scan.start_ns + SHORTEST_NS);
    Ok(Stamped { stamp_ns, frame, value: scan })
}

/// A scan as a message, laid out as the usual driver of a Mid-360 does: `x`, `y`, `z`, `intensity` (FLOAT32), `tag`, `line` (UINT8),
/// `timestamp` (FLOAT64, nanoseconds).
pub fn write_points(scan: &ScanMessage, frame: &str) -> Vec<u8> {
    const FIELDS: [(&str, u32, u8); 7] = [
        ("x", 0, FLOAT32),
        ("y", 4, FLOAT32),
        ("z", 8, FLOAT32),
        ("intensity", 12, FLOAT32),
        ("tag", 16, UINT8),
        ("line", 17, UINT8),
        ("timestamp", 18, FLOAT64),
    ];
    let mut data = CdrWriter::new();
    data.header(scan.start_ns, frame);
    data.u32(1);
    data.length(scan.points.len());
    data.length(FIELDS.len());
    for (name, offset, kind) in FIELDS {
        data.string(name);
        data.u32(offset);
        data.u8(kind);
        data.u32(1);
    }
    data.bool(false);
    data.u32(LIVOX_STEP);
    data.length(LIVOX_STEP as usize * scan.points.len());
    let mut points = Vec::with_capacity(LIVOX_STEP as usize * scan.points.len());
    for [x, y, z, offset_s] in &scan.points {
        for value in [*x, *y, *z, 0.0] {
            points.extend((value as f32).to_le_bytes());
        }
        points.extend([0, 0]);
        points.extend((scan.start_ns as f64 + 1e9 * offset_s).to_le_bytes());
    }
    data.bytes(&points);
    data.bool(true);
    data.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    type Fields<'a> = &'a [(&'a str, u32, u8)];

    /// A message by hand: stamp 5 s, frame "l", one row, these fields, points of `step` bytes.
    fn by_hand(fields: Fields<'_>, step: u32, data: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        let word = |out: &mut Vec<u8>, word: u32| {
            while !out.len().is_multiple_of(4) {
                out.push(0);
            }
            out.extend(word.to_le_bytes());
        };
        for w in [5, 0, 2] {
            word(&mut out, w);
        }
        out.extend(b"l\0");
        for w in [1, data.len() as u32 / step.max(1), fields.len() as u32] {
            word(&mut out, w);
        }
        for (name, offset, kind) in fields {
            word(&mut out, name.len() as u32 + 1);
            out.extend(name.as_bytes());
            out.push(0);
            word(&mut out, *offset);
            out.push(*kind);
            word(&mut out, 1);
        }
        out.push(0);
        for w in [step, data.len() as u32, data.len() as u32] {
            word(&mut out, w);
        }
        out.extend(data);
        out.push(1);
        [vec![0, 1, 0, 0], out].concat()
    }

    fn place([x, y, z]: [f32; 3]) -> Vec<u8> {
        [x, y, z].iter().flat_map(|x| x.to_le_bytes()).collect()
    }

    const XYZ: [(&str, u32, u8); 3] = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7)];

    #[test]
    fn nanoseconds_since_the_stamp_are_read() {
        let fields = [XYZ.as_slice(), &[("offset_time", 12, 6)]].concat();
        let mut data = Vec::new();
        for (at, offset) in [([1.0, 2.0, 3.0], 2_000_000_u32), ([-1.0, 0.5, 0.25], 52_000_000)] {
            data.extend(place(at));
            data.extend(offset.to_le_bytes());
        }
        let read = read_points(&by_hand(&fields, 16, &data)).expect("points");
        assert_eq!((read.stamp_ns, read.frame.as_str()), (5_000_000_000, "l"));
        let scan = read.value;
        assert_eq!((scan.start_ns, scan.end_ns), (5_002_000_000, 5_052_000_000));
        assert_eq!(scan.points, [[1.0, 2.0, 3.0, 0.0], [-1.0, 0.5, 0.25, 0.05]]);
    }

    #[test]
    fn absolute_times_are_read_in_nanoseconds_and_in_seconds() {
        // The time stands before the place, with a gap between.
        let fields: Fields<'_> = &[("timestamp", 0, 8), ("z", 20, 7), ("y", 16, 7), ("x", 12, 7)];
        for unit in [1.0_f64, 1e-9] {
            let mut data = Vec::new();
            for (at, time) in [([1.0, 0.0, 0.0], 5.01e9), ([2.0, 0.0, 0.0], 5.11e9_f64)] {
                data.extend((time * unit).to_le_bytes());
                data.extend([9; 4]);
                data.extend(place(at));
            }
            let scan = read_points(&by_hand(fields, 24, &data)).expect("points").value;
            assert!(scan.start_ns.abs_diff(5_010_000_000) < 10 && scan.end_ns.abs_diff(5_110_000_000) < 10);
            assert_eq!((scan.points[0][0], scan.points[1][0]), (1.0, 2.0));
            assert!((scan.points[1][3] - 0.1).abs() < 1e-8, "{:?}", scan.points);
        }
    }

    #[test]
    fn what_did_not_come_back_and_what_is_doubted_is_left_out_but_lasts() {
        let fields = [XYZ.as_slice(), &[("tag", 12, 2), ("offset_time", 13, 6)]].concat();
        let mut data = Vec::new();
        let all = [([0.0; 3], 0), ([1.0, 0.0, 0.0], 0), ([f32::NAN, 0.0, 0.0], 0), ([2.0, 0.0, 0.0], 0b10)];
        for (k, (at, tag)) in all.into_iter().enumerate() {
            data.extend(place(at));
            data.push(tag);
            data.extend((k as u32 * 1_000_000).to_le_bytes());
        }
        let scan = read_points(&by_hand(&fields, 17, &data)).expect("points").value;
        assert_eq!((scan.start_ns, scan.end_ns), (5_000_000_000, 5_003_000_000));
        assert_eq!(scan.points, [[1.0, 0.0, 0.0, 0.001]]);
        // A covered sensor sends an empty cloud, which is a scan.
        let none = read_points(&by_hand(&fields, 17, &[])).expect("no points").value;
        assert_eq!((none.points.len(), none.end_ns - none.start_ns), (0, 1));
    }

    #[test]
    fn an_empty_cloud_of_four_thousand_million_rows_is_read_at_once() {
        let timed = [XYZ.as_slice(), &[("offset_time", 12, 6)]].concat();
        let mut message = by_hand(&timed, 16, &[]);
        let height = 4 + 8 + 4 + 4;
        message[height..height + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        // The rows are not read one by one.
        let scan = read_points(&message).expect("no points").value;
        assert_eq!((scan.start_ns, scan.end_ns, scan.points.len()), (5_000_000_000, 5_000_000_001, 0));
    }

    #[test]
    fn the_drivers_layout_comes_back() {
        let scan = ScanMessage {
            start_ns: 7_000_000_000,
            end_ns: 7_100_000_000,
            points: vec![[1.5, -2.0, 0.25, 0.0], [3.0, 0.5, -1.0, 0.1]],
        };
        let read = read_points(&write_points(&scan, "livox_frame")).expect("points");
        assert_eq!((read.frame.as_str(), &read.value), ("livox_frame", &scan));
    }

    #[test]
    fn each_wrong_layout_is_refused_with_what_was_expected_and_found() {
        let timed = [XYZ.as_slice(), &[("offset_time", 12, 6)]].concat();
        let mut far = place([1.0; 3]);
        far.extend(1_500_000_000_u32.to_le_bytes());
        let mut cut = by_hand(&timed, 16, &[0; 32]);
        let width = 4 + 8 + 4 + 4 + 4;
        cut[width..width + 4].copy_from_slice(&3_u32.to_le_bytes());
        let mut big = by_hand(&timed, 16, &[0; 16]);
        let at = big.windows(4).rposition(|w| w == 16_u32.to_le_bytes()).expect("a length");
        // Two lengths and the step stand behind the flag, which has three bytes of padding.
        big[at - 12] = 1;
        let cases: [(Vec<u8>, &str); 7] = [
            (
                by_hand(&XYZ, 12, &[0; 12]),
                "LiDAR points: expected a time of each point: timestamp as FLOAT64 or offset_time as UINT32, found x FLOAT32 at 0, \
                 y FLOAT32 at 4, z FLOAT32 at 8",
            ),
            (by_hand(&timed[1..], 16, &[0; 16]), "expected fields x, y, z as FLOAT32, found y FLOAT32 at 4"),
            (
                by_hand(&[("x", 0, 8), ("y", 8, 8), ("z", 16, 8)], 24, &[0; 24]),
                "expected fields x, y, z as FLOAT32, found x FLOAT64 at 0",
            ),
            (by_hand(&timed, 12, &[0; 12]), "expected fields within the 12 bytes of a point"),
            (
                by_hand(&timed, 16, &far),
                "within a second of the header's stamp, in ns or s of its clock, found one 1.500 s",
            ),
            (cut, "expected 1 rows of 3 points of 16 bytes, found 32 bytes in rows of 32"),
            (big, "expected little-endian points"),
        ];
        for (bytes, expected) in cases {
            let error = read_points(&bytes).expect_err(expected).to_string();
            assert!(error.contains(expected), "{error}\n{expected}");
        }
    }
}
