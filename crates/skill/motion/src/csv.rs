//! CSV motions as BeyondMimic and Unitree exchange them: one line a frame, position x, y, z of the base `[m]`, its quaternion in the
//! order x, y, z, w, then the joint angles `[rad]` in model order (depth-first), separated by commas.
//!
//! Lines that begin with `#` are comments, which other readers skip. Ours state there what the numbers leave open, a key a line:
//! `# fps: 50`, `# kick_leg: right`, `# kick_frame: 141`, `# joint_order: model` (or `policy`),
//! `# quat: xyzw` (or `wxyz`), `# license: ...`. A first line of column names is understood (`crate::columns`), in any order.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use paid_robot::{Permutation, RobotModel, RobotSpec};

use crate::columns::columns;
use crate::quat_order::stands_in_the_other_order;
use crate::read::{LARGEST_VALUE, RATES_HZ, a_rate, first_bad_rate, no_other_rate};
use crate::{Clip, JointOrder, KickLeg, MotionError, QuatOrder, ReadOptions, fastest_kick};

/// Columns before the joints: three of position, four of orientation.
const BASE: usize = 7;
/// How far a quaternion's norm may be from one: files round to few digits.
const UNIT_TOLERANCE: f64 = 1e-2;
/// A larger file is no motion `[bytes]`.
const LARGEST: u64 = 1 << 30;

/// Reads a CSV motion. Body poses come from forward kinematics, velocities from central differences.
///
/// # Errors
/// Names file, line, field, what was expected and what was found; a frame rate that neither the file nor the options state, or that they
/// state differently.
pub fn read_csv(
    path: &Path,
    model: &RobotModel,
    spec: &RobotSpec,
    options: &ReadOptions,
) -> Result<Clip, MotionError> {
    let io = |source| MotionError::Io { path: path.to_owned(), source };
    if fs::metadata(path).map_err(io)?.len() > LARGEST {
        let source = std::io::Error::other(format!("more than {LARGEST} bytes"));
        return Err(io(source));
    }
    parse_csv(&fs::read_to_string(path).map_err(io)?, path, model, spec, options)
}

/// As [`read_csv`], from the text of a file; `path` names it.
///
/// # Errors
/// As [`read_csv`].
pub fn parse_csv(
    text: &str,
    path: &Path,
    model: &RobotModel,
    spec: &RobotSpec,
    options: &ReadOptions,
) -> Result<Clip, MotionError> {
    let reader = Reader { path, joints: model.joint_names() };
    let Text { stated, named, mut frames, lines } = reader.lines(text)?;
    if frames.len() < 2 {
        let found = format!("{} frames", frames.len());
        return Err(reader.error(text.lines().count(), 1, "at least 2 frames", found));
    }
    if !named && options.joint_order.or(stated.joint_order) == Some(JointOrder::Policy) {
        let names: Vec<&str> = spec.policy_joint_order.iter().map(String::as_str).collect();
        let order = reader.order(&names)?;
        frames.iter_mut().for_each(|row| reorder(row, &order));
    }
    let fps = reader.rate(&stated, options.fps)?;
    if let Some(frame) = stated.kick_frame.filter(|k| *k >= frames.len()) {
        let expected = format!("a kick frame from 0 to {}", frames.len() - 1);
        return Err(reader.error(stated.kick_line, 1, expected, frame.to_string()));
    }
    let order = options.quat.or(stated.quat).filter(|_| !named);
    let quat = |row: &[f64]| order.unwrap_or(QuatOrder::Xyzw).quat([row[3], row[4], row[5], row[6]]);
    let base: Vec<_> = frames.iter().map(|row| ([row[0], row[1], row[2]], quat(row))).collect();
    let angles: Vec<f64> = frames.iter().flat_map(|row| row[BASE..].iter().copied()).collect();
    let mut clip = Clip {
        name: path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default(),
        path: path.to_owned(),
        kick_frame: stated.kick_frame,
        license: stated.license,
        ..Clip::from_poses(model, fps, &base, &angles)
    };
    if let Some((frame, rate)) = first_bad_rate(&clip) {
        let expected = format!("speeds up to {LARGEST_VALUE:e} m/s or rad/s");
        return Err(reader.error(lines[frame], 1, expected, format!("{rate:e}")));
    }
    if order.is_none() && !named && stands_in_the_other_order(&clip, model, spec) {
        return Err(MotionError::QuatOrder { path: path.to_owned() });
    }
    let fastest = || fastest_kick(&clip, model, spec).map(|kick| kick.leg);
    clip.kick_leg = options.kick_leg.or(stated.kick_leg).or_else(fastest).unwrap_or(KickLeg::Right);
    Ok(clip)
}

/// What a line without commas between its numbers looks like.
fn separators(line: &str) -> &'static str {
    match line {
        _ if line.contains(';') => ": they look separated by semicolons",
        _ if line.contains('\t') => ": they look separated by tabs",
        _ if line.contains(' ') && !line.contains(',') => ": they look separated by blanks",
        _ => "",
    }
}

/// Brings the joints of a row into model order.
fn reorder(row: &mut Vec<f64>, order: &Permutation) {
    let joints = order.apply(&row[BASE..]);
    row.truncate(BASE);
    row.extend(joints);
}

/// What comments state.
#[derive(Default)]
struct Stated {
    fps: Option<f64>,
    fps_line: usize,
    kick_leg: Option<KickLeg>,
    kick_frame: Option<usize>,
    kick_line: usize,
    license: Option<String>,
    joint_order: Option<JointOrder>,
    quat: Option<QuatOrder>,
}

/// What a file holds.
struct Text {
    stated: Stated,
    /// Whether a line names the columns.
    named: bool,
    /// Position, unit quaternion (x, y, z, w if it is named), joints in model order if they are named.
    frames: Vec<Vec<f64>>,
    /// The line of each frame.
    lines: Vec<usize>,
}

struct Reader<'a> {
    path: &'a Path,
    joints: Vec<String>,
}

impl Reader<'_> {
    fn error(
        &self,
        line: usize,
        column: usize,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> MotionError {
        let path = self.path.to_owned();
        MotionError::Text { path, line: line.max(1), column, expected: expected.into(), found: found.into() }
    }

    /// The frame rate that the file states, or the one that is `given` for a file that states none.
    fn rate(&self, stated: &Stated, given: Option<f64>) -> Result<f64, MotionError> {
        let fps = stated.fps.or(given).ok_or_else(|| MotionError::Unstated {
            path: self.path.to_owned(),
            what: "the frame rate",
            remedy: "give it (--fps) or write '# fps: 50' into the first line",
        })?;
        if !RATES_HZ.contains(&fps) {
            return Err(self.error(stated.fps_line, 1, a_rate(), fps.to_string()));
        }
        match given {
            Some(other) if other != fps => {
                Err(self.error(stated.fps_line, 1, no_other_rate(fps), format!("--fps {other}")))
            }
            _ => Ok(fps),
        }
    }

    fn lines(&self, text: &str) -> Result<Text, MotionError> {
        let mut stated = Stated { fps_line: 1, ..Stated::default() };
        let mut order: Option<Vec<usize>> = None;
        let (mut frames, mut lines) = (Vec::new(), Vec::new());
        for (i, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            let (number, line) = (i + 1, line.trim());
            if let Some(comment) = line.strip_prefix('#') {
                self.comment(number, comment, &mut stated)?;
            } else if !line.is_empty() {
                let fields: Vec<&str> = line.split(',').map(str::trim).collect();
                let named = fields.len() > BASE && fields.iter().all(|f| f.parse::<f64>().is_err());
                if named && frames.is_empty() && order.is_none() {
                    let found = columns(&fields, &self.joints);
                    order = Some(found.map_err(|(expected, found)| self.error(number, 1, expected, found))?);
                    continue;
                }
                let width = BASE + self.joints.len();
                if fields.len() != width {
                    let expected = format!(
                        "{width} numbers with commas between them (x, y, z, quaternion, {} joints)",
                        width - BASE
                    );
                    let found = format!("{} fields{}", fields.len(), separators(line));
                    return Err(self.error(number, fields.len(), expected, found));
                }
                frames.push(self.row(number, &fields, order.as_deref())?);
                lines.push(number);
            }
        }
        Ok(Text { stated, named: order.is_some(), frames, lines })
    }

    fn order(&self, names: &[&str]) -> Result<Permutation, MotionError> {
        Permutation::between(names, &self.joints).map_err(|source| MotionError::Order {
            path: self.path.to_owned(),
            list: "column names",
            source,
        })
    }

    fn row(&self, line: usize, fields: &[&str], order: Option<&[usize]>) -> Result<Vec<f64>, MotionError> {
        let mut row = Vec::with_capacity(fields.len());
        for (i, field) in fields.iter().enumerate() {
            match field.parse::<f64>() {
                Ok(x) if x.abs() <= LARGEST_VALUE => row.push(x),
                Ok(x) if x.is_finite() => {
                    let expected = format!("a number from -{LARGEST_VALUE:e} to {LARGEST_VALUE:e}");
                    return Err(self.error(line, i + 1, expected, format!("{x:e}")));
                }
                _ => return Err(self.error(line, i + 1, "a finite number", format!("'{field}'"))),
            }
        }
        if let Some(order) = order {
            row = order.iter().map(|&column| row[column]).collect();
        }
        let norm = row[3..BASE].iter().map(|q| q * q).sum::<f64>().sqrt();
        if (norm - 1.0).abs() > UNIT_TOLERANCE {
            return Err(self.error(line, 4, "a unit quaternion", format!("norm {norm}")));
        }
        row[3..BASE].iter_mut().for_each(|q| *q /= norm);
        Ok(row)
    }

    /// A comment without a known key is just that.
    fn comment(&self, line: usize, comment: &str, stated: &mut Stated) -> Result<(), MotionError> {
        let Some((key, value)) = comment.split_once(':') else { return Ok(()) };
        let value = value.trim();
        let bad = |expected: &str| self.error(line, 1, expected, format!("'{value}'"));
        match key.trim() {
            "fps" => {
                stated.fps = Some(value.parse().map_err(|_| bad("a frame rate"))?);
                stated.fps_line = line;
            }
            "kick_leg" => stated.kick_leg = Some(value.parse().map_err(|_| bad("'left' or 'right'"))?),
            "kick_frame" => {
                stated.kick_frame = Some(value.parse().map_err(|_| bad("a frame"))?);
                stated.kick_line = line;
            }
            "joint_order" => {
                stated.joint_order = Some(value.parse().map_err(|_| bad("'model' or 'policy'"))?);
            }
            "quat" => stated.quat = Some(value.parse().map_err(|_| bad("'xyzw' or 'wxyz'"))?),
            "license" | "licence" => stated.license = Some(value.to_owned()),
            _ => {}
        }
        Ok(())
    }
}

/// Writes a clip in the format that [`read_csv`] reads, with comments for what the numbers leave open; numbers are written so that
/// they read back exactly. The file appears under its name only when it is whole.
///
/// # Errors
/// If the file cannot be written.
pub fn write_csv(path: &Path, clip: &Clip) -> Result<(), MotionError> {
    let mut text =
        format!("# fps: {}\n# kick_leg: {}\n# joint_order: model\n# quat: xyzw\n", clip.fps, clip.kick_leg);
    if let Some(frame) = clip.kick_frame {
        text += &format!("# kick_frame: {frame}\n");
    }
    if let Some(license) = &clip.license {
        // A license of several lines must not end the comment.
        text += &format!("# license: {}\n", license.split_whitespace().collect::<Vec<_>>().join(" "));
    }
    for t in 0..clip.frames {
        let ([x, y, z], [qw, qx, qy, qz]) = (clip.body_pos(t)[0], clip.body_quat(t)[0]);
        let mut separator = "";
        for value in [x, y, z, qx, qy, qz, qw].iter().chain(clip.joint_pos(t)) {
            // Writing to a string does not fail.
            let _ = write!(text, "{separator}{value}");
            separator = ",";
        }
        text.push('\n');
    }
    paid_files::write_atomically(path, text.as_bytes())
        .map_err(|source| MotionError::Io { path: path.to_owned(), source })
}
