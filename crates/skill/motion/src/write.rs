//! A clip to an NPZ motion file.

use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

use npyz::{AutoSerialize, DType, Serialize, WriterBuilder};
use paid_robot::{Permutation, RobotModel, RobotSpec};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::{Clip, MotionError};

/// Writes a clip in the format that [`crate::read_clip`] reads, single precision, in the file orders of `spec`
/// (no name lists). The file appears under its name only when it is whole.
///
/// # Errors
/// If the names do not match or the file cannot be written.
pub fn write_npz(path: &Path, clip: &Clip, model: &RobotModel, spec: &RobotSpec) -> Result<(), MotionError> {
    let order = |list, from: Vec<String>, to: &[String]| {
        Permutation::between(&from, to).map_err(|source| MotionError::Order {
            path: path.to_owned(),
            list,
            source,
        })
    };
    let joints = order("joint_names", model.joint_names(), &spec.policy_joint_order)?;
    let bodies = order("body_names", model.body_names(), &spec.motion_body_order)?;
    paid_files::replace(path, |file| write_all(BufWriter::new(file), clip, &joints, &bodies))
        .map_err(|source| MotionError::Io { path: path.to_owned(), source })
}

fn write_all<W: Write + Seek>(
    file: W,
    clip: &Clip,
    joints: &Permutation,
    bodies: &Permutation,
) -> io::Result<()> {
    let mut zip = ZipWriter::new(file);
    let (t, j, b) = (clip.frames as u64, clip.joints as u64, clip.bodies as u64);
    numbers(&mut zip, "fps", &[1], &[clip.fps])?;
    for (key, values) in [("joint_pos", &clip.joint_pos), ("joint_vel", &clip.joint_vel)] {
        let rows: Vec<f32> =
            values.chunks_exact(clip.joints).flat_map(|row| joints.apply(row)).map(|x| x as f32).collect();
        numbers(&mut zip, key, &[t, j], &rows)?;
    }
    for (key, values) in [
        ("body_pos_w", &clip.body_pos),
        ("body_lin_vel_w", &clip.body_lin_vel),
        ("body_ang_vel_w", &clip.body_ang_vel),
    ] {
        numbers(&mut zip, key, &[t, b, 3], &single(values, bodies))?;
    }
    numbers(&mut zip, "body_quat_w", &[t, b, 4], &single(&clip.body_quat, bodies))?;
    text(&mut zip, "kick_leg", &clip.kick_leg.to_string())?;
    if let Some(frame) = clip.kick_frame {
        numbers(&mut zip, "kick_frame", &[1], &[frame as i64])?;
    }
    if let Some(license) = &clip.license {
        text(&mut zip, "license", license)?;
    }
    zip.finish().map_err(io::Error::other)?.flush()
}

fn single<const N: usize>(values: &[[f64; N]], order: &Permutation) -> Vec<f32> {
    let n = order.indices().len();
    values.chunks_exact(n).flat_map(|row| order.apply(row)).flatten().map(|x| x as f32).collect()
}

/// Adds a numeric array.
pub(crate) fn numbers<W: Write + Seek, T: AutoSerialize + Copy>(
    zip: &mut ZipWriter<W>,
    key: &str,
    shape: &[u64],
    values: &[T],
) -> io::Result<()> {
    array(zip, key, shape, T::default_dtype(), values)
}

/// Adds a 0-d text.
pub(crate) fn text<W: Write + Seek>(zip: &mut ZipWriter<W>, key: &str, value: &str) -> io::Result<()> {
    texts(zip, key, &[], &[value.to_owned()])
}

/// Adds a text array.
pub(crate) fn texts<W: Write + Seek>(
    zip: &mut ZipWriter<W>,
    key: &str,
    shape: &[u64],
    values: &[String],
) -> io::Result<()> {
    let width = values.iter().map(|v| v.chars().count()).max().unwrap_or(0).max(1);
    let dtype = format!("<U{width}").parse().map_err(io::Error::other)?;
    array(zip, key, shape, DType::Plain(dtype), values)
}

fn array<W: Write + Seek, T: Serialize>(
    zip: &mut ZipWriter<W>,
    key: &str,
    shape: &[u64],
    dtype: DType,
    values: &[T],
) -> io::Result<()> {
    zip.start_file(format!("{key}.npy"), SimpleFileOptions::default()).map_err(io::Error::other)?;
    let mut npy = npyz::WriteOptions::new().dtype(dtype).shape(shape).writer(zip).begin_nd()?;
    for value in values {
        npy.push(value)?;
    }
    npy.finish()
}
