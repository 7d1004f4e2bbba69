//! Motions as GMR (General Motion Retargeting) writes them: a pickled dictionary.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use paid_robot::{Permutation, RobotModel, RobotSpec};

use crate::foreign::refuse_joblib;
use crate::pickle::{Id, Machine, PickleError, Value};
use crate::quat_order::stands_in_the_other_order;
use crate::read::{LARGEST_VALUE, RATES_HZ, a_rate, first_bad, first_bad_rate, no_other_rate};
use crate::{Clip, JointOrder, KickLeg, MotionError, QuatOrder, ReadOptions, fastest_kick};

const UNIT_TOLERANCE: f64 = 1e-2;
/// A larger file is no motion `[bytes]`.
const LARGEST: u64 = 1 << 30;

/// Whether a file begins as a pickle of protocol 2 to 5.
pub(crate) fn begins_as_pickle(head: &[u8]) -> bool {
    matches!(head, [0x80, 2..=5, ..])
}

/// Reads a GMR motion: a pickled dictionary with `fps` (a number), `root_pos` `[T, 3]` `[m]`, `root_rot` `[T, 4]` (x, y, z, w; [`ReadOptions::quat`]) and
/// `dof_pos` `[T, J]` `[rad]` in model order (depth-first), numpy arrays or lists. Other keys are ignored. No code of the file is run.
///
/// # Errors
/// Names file, byte or key, what was expected and what was found; a frame rate that neither the file nor the options state, or
/// that they state differently.
pub fn read_gmr(
    path: &Path,
    model: &RobotModel,
    spec: &RobotSpec,
    options: &ReadOptions,
) -> Result<Clip, MotionError> {
    let io = |source| MotionError::Io { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    File::open(path).and_then(|f| f.take(LARGEST + 1).read_to_end(&mut bytes)).map_err(io)?;
    if bytes.len() as u64 > LARGEST {
        return Err(io(std::io::Error::other(format!("more than {LARGEST} bytes"))));
    }
    parse_gmr(&bytes, path, model, spec, options)
}

/// As [`read_gmr`], from the bytes of a file; `path` names it.
///
/// # Errors
/// As [`read_gmr`].
pub fn parse_gmr(
    bytes: &[u8],
    path: &Path,
    model: &RobotModel,
    spec: &RobotSpec,
    options: &ReadOptions,
) -> Result<Clip, MotionError> {
    let broken = |e: PickleError| MotionError::Pickle {
        path: path.to_owned(),
        offset: e.offset,
        expected: e.expected,
        found: e.found,
    };
    refuse_joblib(path, bytes)?;
    let (machine, top) = Machine::load(bytes).map_err(broken)?;
    let Value::Dict(items) = machine.get(top) else {
        return Err(broken(machine.error("a dictionary", machine.get(top).name())));
    };
    let dict = Dictionary { path, machine: &machine, items };
    let joints = model.joints.len();
    let joint_pos = dict.rows("dof_pos", joints)?;
    let frames = joint_pos.len() / joints.max(1);
    let error = |key, expected: &str, found: String| MotionError::Key {
        path: path.to_owned(),
        key,
        expected: expected.to_owned(),
        found,
    };
    if frames < 2 {
        return Err(error("dof_pos", "at least 2 frames", format!("{frames}")));
    }
    let fps = match (dict.find("fps"), options.fps) {
        (Err(_), Some(given)) => given,
        _ => dict.number("fps")?,
    };
    if !RATES_HZ.contains(&fps) {
        return Err(error("fps", &a_rate(), fps.to_string()));
    }
    if let Some(given) = options.fps.filter(|given| *given != fps) {
        return Err(error("fps", &no_other_rate(fps), format!("--fps {given}")));
    }
    let (pos, rot) = (dict.rows("root_pos", 3)?, dict.rows("root_rot", 4)?);
    for (key, rows) in [("root_pos", pos.len() / 3), ("root_rot", rot.len() / 4)] {
        if rows != frames {
            return Err(error(key, &format!("{frames} frames as in 'dof_pos'"), rows.to_string()));
        }
    }
    let order = options.quat.unwrap_or(QuatOrder::Xyzw);
    let mut base = Vec::with_capacity(frames);
    for (t, (p, q)) in pos.chunks_exact(3).zip(rot.chunks_exact(4)).enumerate() {
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (norm - 1.0).abs() > UNIT_TOLERANCE {
            return Err(error("root_rot", "unit quaternions", format!("norm {norm} in frame {t}")));
        }
        base.push(([p[0], p[1], p[2]], order.quat([q[0], q[1], q[2], q[3]]).map(|x| x / norm)));
    }
    let joint_pos = if options.joint_order == Some(JointOrder::Policy) {
        let order =
            Permutation::between(&spec.policy_joint_order, &model.joint_names()).map_err(|source| {
                MotionError::Order { path: path.to_owned(), list: "policy_joint_order", source }
            })?;
        joint_pos.chunks_exact(joints).flat_map(|row| order.apply(row)).collect()
    } else {
        joint_pos
    };
    let mut clip = Clip {
        name: path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default(),
        path: path.to_owned(),
        ..Clip::from_poses(model, fps, &base, &joint_pos)
    };
    if let Some((frame, rate)) = first_bad_rate(&clip) {
        let expected = format!("speeds up to {LARGEST_VALUE:e} m/s or rad/s");
        return Err(error("root_pos and dof_pos", &expected, format!("{rate:e} in frame {frame}")));
    }
    if options.quat.is_none() && stands_in_the_other_order(&clip, model, spec) {
        return Err(MotionError::QuatOrder { path: path.to_owned() });
    }
    let fastest = || fastest_kick(&clip, model, spec).map(|kick| kick.leg);
    clip.kick_leg = options.kick_leg.or_else(fastest).unwrap_or(KickLeg::Right);
    Ok(clip)
}

struct Dictionary<'a> {
    path: &'a Path,
    machine: &'a Machine<'a>,
    items: &'a [(Id, Id)],
}

impl Dictionary<'_> {
    fn find(&self, key: &'static str) -> Result<Id, MotionError> {
        let text = |id: &Id| match self.machine.get(*id) {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        };
        // Of keys that occur twice the last holds, as in Python.
        if let Some((_, value)) = self.items.iter().rev().find(|(k, _)| text(k) == Some(key)) {
            return Ok(*value);
        }
        let mut keys: Vec<&str> = self.items.iter().filter_map(|(k, _)| text(k)).take(40).collect();
        keys.sort_unstable();
        let found = if keys.is_empty() { "no key".to_owned() } else { keys.join(", ") };
        Err(MotionError::MissingKey { path: self.path.to_owned(), key, found })
    }

    fn error(&self, key: &'static str, expected: String, found: String) -> MotionError {
        MotionError::Key { path: self.path.to_owned(), key, expected, found }
    }

    fn number(&self, key: &'static str) -> Result<f64, MotionError> {
        let id = self.find(key)?;
        let one = self.machine.numbers(id, |shape| shape.iter().all(|n| *n == 1));
        match one.as_deref() {
            Ok([value]) => Ok(*value),
            _ => Err(self.error(key, "one number".to_owned(), self.machine.get(id).name().to_owned())),
        }
    }

    /// Rows of `width` finite numbers.
    fn rows(&self, key: &'static str, width: usize) -> Result<Vec<f64>, MotionError> {
        let id = self.find(key)?;
        let expected = || format!("finite numbers of shape [frames, {width}]");
        let fits = |shape: &[usize]| matches!(shape, [_, found] if *found == width);
        let values = self.machine.numbers(id, fits).map_err(|found| self.error(key, expected(), found))?;
        let Some(i) = first_bad(&values) else { return Ok(values) };
        let (value, frame) = (values[i], i / width.max(1));
        Err(if value.is_finite() {
            let expected = format!("numbers from -{LARGEST_VALUE:e} to {LARGEST_VALUE:e}");
            self.error(key, expected, format!("{value:e} in frame {frame}"))
        } else {
            self.error(key, expected(), format!("{value} in frame {frame}"))
        })
    }
}
