//! One NPZ motion file to a clip.

use std::fmt::Display;
use std::path::Path;

use paid_robot::{Permutation, RobotModel, RobotSpec};

use crate::npz::Npz;
use crate::{Clip, KickLeg, MotionError, ReadOptions};

/// How far a stored quaternion's norm may be from one (single precision with room).
const UNIT_TOLERANCE: f64 = 1e-3;
/// Frame rates outside of this are taken for a mistake `[Hz]`.
pub(crate) const RATES_HZ: std::ops::RangeInclusive<f64> = 1.0..=2000.0;

/// Values beyond this are no motion: meters, radians, or their rates. Single precision still tells millimeters a kilometer away.
pub(crate) const LARGEST_VALUE: f64 = 1e6;

/// The place of the first value that is no number of a motion.
pub(crate) fn first_bad(values: &[f64]) -> Option<usize> {
    values.iter().position(|v| v.is_nan() || v.abs() > LARGEST_VALUE)
}

/// The first velocity of a clip that is none of a motion: its frame and size. Where files state no velocities, a jump shows here.
pub(crate) fn first_bad_rate(clip: &Clip) -> Option<(usize, f64)> {
    let lists = [
        (&clip.joint_vel[..], clip.joints),
        (clip.body_lin_vel.as_flattened(), 3 * clip.bodies),
        (clip.body_ang_vel.as_flattened(), 3 * clip.bodies),
    ];
    let bad = |(values, width): (&[f64], usize)| first_bad(values).map(|i| (i / width, values[i]));
    lists.into_iter().filter_map(bad).min_by_key(|(frame, _)| *frame)
}

/// Reads and checks a motion file at its own frame rate.
///
/// Keys: `fps` (one number), `joint_pos`, `joint_vel` `[T, J]`, `body_pos_w`, `body_lin_vel_w`, `body_ang_vel_w`
/// `[T, B, 3]`, `body_quat_w` `[T, B, 4]` (w, x, y, z), `kick_leg` (`left` or `right`); optionally `joint_names`,
/// `body_names` (text lists; without them the orders of [`RobotSpec`] hold), `kick_frame` (one number: the frame in which
/// the foot meets the ball) and `license` (text).
///
/// # Errors
/// Names the file, the key, what was expected and what was found.
pub fn read_clip(path: &Path, model: &RobotModel, spec: &RobotSpec) -> Result<Clip, MotionError> {
    let mut npz = Npz::open(path)?;
    let kick_leg = label(&mut npz)?;
    read_arrays(npz, path, model, spec, kick_leg, None)
}

/// As [`read_clip`], from the bytes of a file; `path` names it.
///
/// # Errors
/// As [`read_clip`].
pub fn parse_npz(
    bytes: Vec<u8>,
    path: &Path,
    model: &RobotModel,
    spec: &RobotSpec,
) -> Result<Clip, MotionError> {
    let mut npz = Npz::from_bytes(path, bytes)?;
    let kick_leg = label(&mut npz)?;
    read_arrays(npz, path, model, spec, kick_leg, None)
}

/// As [`read_clip`], but the label may be missing: the clip is then labeled `right` and the second value is false. Another frame rate
/// in the options than the file's own is an error, and so is an order of joints.
pub(crate) fn read_npz(
    path: &Path,
    model: &RobotModel,
    spec: &RobotSpec,
    options: &ReadOptions,
) -> Result<(Clip, bool), MotionError> {
    let mut npz = Npz::open(path)?;
    if options.joint_order.is_some() {
        return Err(MotionError::JointOrder { path: path.to_owned() });
    }
    let labeled = npz.has("kick_leg");
    let kick_leg = if labeled { label(&mut npz)? } else { KickLeg::Right };
    Ok((read_arrays(npz, path, model, spec, kick_leg, options.fps)?, labeled))
}

fn read_arrays(
    mut npz: Npz,
    path: &Path,
    model: &RobotModel,
    spec: &RobotSpec,
    kick_leg: KickLeg,
    given: Option<f64>,
) -> Result<Clip, MotionError> {
    let fps = frame_rate(&mut npz)?;
    if let Some(other) = given.filter(|given| *given != fps) {
        return Err(npz.error("fps", no_other_rate(fps), format!("--fps {other}")));
    }
    let joints = order(&mut npz, path, "joint_names", &spec.policy_joint_order, &model.joint_names())?;
    let bodies = order(&mut npz, path, "body_names", &spec.motion_body_order, &model.body_names())?;

    let pos = npz.numbers("joint_pos")?;
    let frames = pos.shape.first().copied().unwrap_or(0);
    if frames < 2 {
        return Err(npz.error("joint_pos", "at least 2 frames", format!("shape {:?}", pos.shape)));
    }
    let mut reader = Reader { npz: &mut npz, frames };
    let joint_pos = reader.rows("joint_pos", &joints)?;
    let joint_vel = reader.rows("joint_vel", &joints)?;
    let body_pos = reader.vectors::<3>("body_pos_w", &bodies)?;
    let body_quat = reader.unit_quaternions("body_quat_w", &bodies)?;
    let body_lin_vel = reader.vectors::<3>("body_lin_vel_w", &bodies)?;
    let body_ang_vel = reader.vectors::<3>("body_ang_vel_w", &bodies)?;
    let kick_frame = kick_frame(&mut npz, frames)?;
    // Files of older versions spell the key the British way.
    let license = match ["license", "licence"].into_iter().find(|key| npz.has(key)) {
        Some(key) => npz.texts(key)?.into_iter().next(),
        None => None,
    };
    Ok(Clip {
        name: path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default(),
        path: path.to_owned(),
        fps,
        kick_leg,
        kick_frame,
        license,
        frames,
        joints: model.joints.len(),
        bodies: model.bodies.len(),
        joint_pos,
        joint_vel,
        body_pos,
        body_quat,
        body_lin_vel,
        body_ang_vel,
    })
}

/// What is expected of a file's frame rate.
pub(crate) fn a_rate() -> String {
    format!("{} to {} frames a second", RATES_HZ.start(), RATES_HZ.end())
}

/// What is expected of `--fps` for a file that states its rate; `stated` is that rate as it shall be shown.
pub fn no_other_rate(stated: impl Display) -> String {
    format!("no --fps other than the file's {stated} frames a second")
}

fn frame_rate(npz: &mut Npz) -> Result<f64, MotionError> {
    let fps = npz.numbers("fps")?;
    match fps.values[..] {
        [rate] if RATES_HZ.contains(&rate) => Ok(rate),
        [rate] => Err(npz.error("fps", a_rate(), rate.to_string())),
        _ => Err(npz.error("fps", "one number", format!("shape {:?}", fps.shape))),
    }
}

/// The optional key `kick_frame`.
fn kick_frame(npz: &mut Npz, frames: usize) -> Result<Option<usize>, MotionError> {
    if !npz.has("kick_frame") {
        return Ok(None);
    }
    let stored = npz.numbers("kick_frame")?;
    match stored.values[..] {
        [k] if k >= 0.0 && k.fract() == 0.0 && k < frames as f64 => Ok(Some(k as usize)),
        [k] => Err(npz.error("kick_frame", format!("a frame from 0 to {}", frames - 1), k.to_string())),
        _ => Err(npz.error("kick_frame", "one number", format!("shape {:?}", stored.shape))),
    }
}

fn label(npz: &mut Npz) -> Result<KickLeg, MotionError> {
    let texts = npz.texts("kick_leg")?;
    match &texts[..] {
        [text] => text.parse().map_err(|found: String| npz.error("kick_leg", "'left' or 'right'", found)),
        _ => Err(npz.error("kick_leg", "one text", format!("{} texts", texts.len()))),
    }
}

/// The permutation from the file's order (its own names, else the robot's convention) to the model's.
fn order(
    npz: &mut Npz,
    path: &Path,
    key: &'static str,
    convention: &[String],
    model: &[String],
) -> Result<Permutation, MotionError> {
    let own = if npz.has(key) { Some(npz.texts(key)?) } else { None };
    Permutation::between(own.as_deref().unwrap_or(convention), model).map_err(|source| MotionError::Order {
        path: path.to_owned(),
        list: key,
        source,
    })
}

struct Reader<'a> {
    npz: &'a mut Npz,
    frames: usize,
}

impl Reader<'_> {
    /// Numbers of shape `[T, items]` or `[T, items, width]`, all finite and none too large.
    fn checked(&mut self, key: &'static str, tail: &[usize]) -> Result<Vec<f64>, MotionError> {
        let array = self.npz.numbers(key)?;
        let mut expected = vec![self.frames];
        expected.extend(tail);
        if array.shape != expected {
            return Err(self.npz.error(key, format!("shape {expected:?}"), format!("{:?}", array.shape)));
        }
        let Some(i) = first_bad(&array.values) else { return Ok(array.values) };
        let (value, place) = (array.values[i], place(i, &expected));
        Err(if value.is_finite() {
            let expected = format!("numbers from -{LARGEST_VALUE:e} to {LARGEST_VALUE:e}");
            self.npz.error(key, expected, format!("{value:e} at {place:?}"))
        } else {
            self.npz.error(key, "finite numbers", format!("{value} at {place:?}"))
        })
    }

    /// `[T, J]` in model order.
    fn rows(&mut self, key: &'static str, order: &Permutation) -> Result<Vec<f64>, MotionError> {
        let n = order.indices().len();
        let values = self.checked(key, &[n])?;
        Ok(values.chunks_exact(n).flat_map(|row| order.apply(row)).collect())
    }

    /// `[T, B, N]` in model order.
    fn vectors<const N: usize>(
        &mut self,
        key: &'static str,
        order: &Permutation,
    ) -> Result<Vec<[f64; N]>, MotionError> {
        let n = order.indices().len();
        let values = self.checked(key, &[n, N])?;
        let (vectors, _) = values.as_chunks::<N>();
        Ok(vectors.chunks_exact(n).flat_map(|row| order.apply(row)).collect())
    }

    fn unit_quaternions(
        &mut self,
        key: &'static str,
        order: &Permutation,
    ) -> Result<Vec<[f64; 4]>, MotionError> {
        let mut quats = self.vectors::<4>(key, order)?;
        let bodies = order.indices().len();
        for (i, q) in quats.iter_mut().enumerate() {
            let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
            if (norm - 1.0).abs() > UNIT_TOLERANCE {
                let found = format!("norm {norm} at {:?}", [i / bodies, order.indices()[i % bodies]]);
                return Err(self.npz.error(key, "unit quaternions w, x, y, z", found));
            }
            *q = q.map(|c| c / norm);
        }
        Ok(quats)
    }
}

/// The index of flat element `i` of a row-major array.
fn place(mut i: usize, shape: &[usize]) -> Vec<usize> {
    let mut index: Vec<usize> = shape
        .iter()
        .rev()
        .map(|&n| {
            let k = i % n;
            i /= n;
            k
        })
        .collect();
    index.reverse();
    index
}
