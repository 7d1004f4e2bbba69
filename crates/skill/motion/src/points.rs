//! Positions of named points over time, as pipelines that find people in videos write them.

use std::path::Path;

use crate::MotionError;
use crate::foreign::refuse_smpl;
use crate::npz::Npz;
use crate::read::{RATES_HZ, a_rate};

/// More frames than this are no motion: three hours at 240 Hz.
const MOST_FRAMES: usize = 3 * 3600 * 240;

/// Points over time, in the file's axes and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    /// Names of the points (J), all different.
    pub names: Vec<String>,
    /// Frames a second, if the file states it.
    pub fps: Option<f64>,
    /// T.
    pub frames: usize,
    /// Positions `[T, J]`, finite.
    pub pos: Vec<[f64; 3]>,
}

impl Points {
    /// The points of frame `t`.
    pub fn frame(&self, t: usize) -> &[[f64; 3]] {
        let n = self.names.len();
        &self.pos[t * n..(t + 1) * n]
    }
}

/// True if a file is an NPZ archive with the key `positions`; false for a file of another name.
///
/// # Errors
/// An `.npz` that cannot be read, is no archive or is one of AMASS.
pub fn is_points_file(path: &Path) -> Result<bool, MotionError> {
    if !crate::format::has_extension(path, "npz") {
        return Ok(false);
    }
    let npz = Npz::open(path)?;
    refuse_smpl(path, |key| npz.has(key))?;
    Ok(npz.has("positions"))
}

/// Refuses a human's points where a motion of the robot is expected.
pub(crate) fn refuse_points(path: &Path) -> Result<(), MotionError> {
    if !crate::format::has_extension(path, "npz") {
        return Ok(());
    }
    let npz = Npz::open(path)?;
    refuse_smpl(path, |key| npz.has(key))?;
    if !npz.has("positions") || npz.has("joint_pos") {
        return Ok(());
    }
    Err(MotionError::Key {
        path: path.to_owned(),
        key: "positions",
        expected: "a motion of the robot".to_owned(),
        found: "a human's points; `paid motion retarget` makes a motion of the robot of them".to_owned(),
    })
}

/// Reads an NPZ archive with `positions` `[T, J, 3]`, `joint_names` `[J]` (text) and optionally `fps` (one number).
///
/// # Errors
/// The file, the key, what was expected and what was found, with the frame and the name of the point.
pub fn read_points(path: &Path) -> Result<Points, MotionError> {
    read(Npz::open(path)?)
}

/// As [`read_points`], from the bytes of a file; `path` names it.
///
/// # Errors
/// As [`read_points`].
pub fn parse_points(bytes: Vec<u8>, path: &Path) -> Result<Points, MotionError> {
    read(Npz::from_bytes(path, bytes)?)
}

fn read(mut npz: Npz) -> Result<Points, MotionError> {
    let names = npz.texts("joint_names")?;
    if let Some(twice) = names.iter().enumerate().find_map(|(i, n)| names[..i].contains(n).then_some(n)) {
        return Err(npz.error("joint_names", "names that differ", format!("'{twice}' twice")));
    }
    let array = npz.numbers("positions")?;
    let frames = array.shape.first().copied().unwrap_or(0);
    if array.shape != [frames, names.len(), 3] || names.is_empty() {
        let expected = format!("shape [frames, {}, 3] for {} joint_names", names.len(), names.len());
        return Err(npz.error("positions", expected, format!("{:?}", array.shape)));
    }
    if !(2..=MOST_FRAMES).contains(&frames) {
        let expected = format!("2 to {MOST_FRAMES} frames");
        return Err(npz.error("positions", expected, frames.to_string()));
    }
    if let Some(i) = array.values.iter().position(|v| !v.is_finite()) {
        let found = format!(
            "{} in frame {} at '{}'",
            array.values[i],
            i / 3 / names.len(),
            names[i / 3 % names.len()]
        );
        return Err(npz.error("positions", "finite numbers (fill gaps before)", found));
    }
    let fps = if npz.has("fps") {
        match npz.numbers("fps")?.values[..] {
            [rate] if RATES_HZ.contains(&rate) => Some(rate),
            ref other => return Err(npz.error("fps", a_rate(), format!("{other:?}"))),
        }
    } else {
        None
    };
    let (pos, _) = array.values.as_chunks::<3>();
    Ok(Points { names, fps, frames, pos: pos.to_vec() })
}

/// Writes points as [`read_points`] reads them, single precision.
///
/// # Errors
/// If the file cannot be written.
pub fn write_points(path: &Path, points: &Points) -> Result<(), MotionError> {
    paid_files::replace(path, |file| {
        use std::io::{BufWriter, Error, Write};
        let mut zip = zip::ZipWriter::new(BufWriter::new(file));
        let (t, j) = (points.frames as u64, points.names.len() as u64);
        let values: Vec<f32> = points.pos.as_flattened().iter().map(|x| *x as f32).collect();
        crate::write::numbers(&mut zip, "positions", &[t, j, 3], &values)?;
        crate::write::texts(&mut zip, "joint_names", &[j], &points.names)?;
        if let Some(fps) = points.fps {
            crate::write::numbers(&mut zip, "fps", &[1], &[fps])?;
        }
        zip.finish().map_err(Error::other)?.flush()
    })
    .map_err(|source| MotionError::Io { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Points {
        Points {
            names: vec!["a".into(), "b".into()],
            fps: Some(25.0),
            frames: 3,
            pos: (0..6).map(|i| [f64::from(i), 0.5, -2.0]).collect(),
        }
    }

    fn through_a_file(points: &Points) -> Result<Points, MotionError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("p.npz");
        write_points(&path, points).expect("writes");
        assert!(is_points_file(&path).expect("an archive"));
        read_points(&path)
    }

    #[test]
    fn points_come_back_from_a_file() {
        let back = through_a_file(&points()).expect("reads");
        assert_eq!(back, points());
        assert_eq!(back.frame(2)[1], [5.0, 0.5, -2.0]);
        let silent = Points { fps: None, ..points() };
        assert_eq!(through_a_file(&silent).expect("reads"), silent);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let mut hole = points();
        hole.pos[3][1] = f64::NAN;
        let mut few = points();
        few.pos.truncate(2);
        few.frames = 1;
        let twice = Points { names: vec!["a".into(), "a".into()], ..points() };
        let wrong =
            Points { names: vec!["a".into(), "b".into(), "c".into()], frames: 2, fps: Some(0.0), ..points() };
        for (bad, expected) in [
            (
                hole,
                "key 'positions': expected finite numbers (fill gaps before), found NaN in frame 1 at 'b'",
            ),
            (few, "key 'positions': expected 2 to 2592000 frames, found 1"),
            (twice, "key 'joint_names': expected names that differ, found 'a' twice"),
            (wrong, "key 'fps': expected 1 to 2000 frames a second, found [0.0]"),
        ] {
            let error = through_a_file(&bad).expect_err("refused").to_string();
            assert!(error.ends_with(expected), "{error}");
        }
        let error = parse_points(b"no zip".to_vec(), Path::new("x.npz")).expect_err("refused").to_string();
        assert!(error.starts_with("x.npz: expected an NPZ archive"), "{error}");
    }

    #[test]
    fn points_are_distinguished_from_a_robots_motion_and_from_no_archive() {
        let folder = tempfile::tempdir().expect("a folder");
        let [human, empty] = ["human.npz", "empty.npz"].map(|name| folder.path().join(name));
        write_points(&human, &points()).expect("writes");
        let error = refuse_points(&human).expect_err("refused").to_string();
        assert!(error.contains("human.npz: key 'positions': expected a motion of the robot"), "{error}");
        assert!(error.contains("`paid motion retarget`"), "{error}");
        std::fs::write(&empty, "").expect("writes");
        for error in [is_points_file(&empty).err(), refuse_points(&empty).err()] {
            let error = error.expect("refused").to_string();
            assert!(error.contains("empty.npz: expected an NPZ archive"), "{error}");
        }
        assert!(!is_points_file(Path::new("kick.csv")).expect("known by the name"));
    }
}
