//! A human motion: where every bone is in every frame.

use std::path::{Path, PathBuf};

use paid_lanes::{Quat, Vec3};
use paid_motion::slerp;

use crate::Skeleton;
use crate::skeleton::about;

/// A human motion, world meters, z up. Row `t` of a `[T, N]` array is at `t * N ..`.
#[derive(Clone, Debug, PartialEq)]
pub struct HumanMotion {
    /// File name without extension.
    pub name: String,
    /// Where it was read from.
    pub path: PathBuf,
    /// Frames a second.
    pub fps: f64,
    /// T, at least one.
    pub frames: usize,
    /// The bones (N); lengths in the file's unit.
    pub skeleton: Skeleton,
    /// Points of the bones `[T, N]` `[m]`.
    pub pos: Vec<[f64; 3]>,
    /// Orientations of the bones `[T, N]`, unit, w, x, y, z.
    pub quat: Vec<[f64; 4]>,
    /// What the reader concluded because nothing states it: one plain sentence each.
    pub notes: Vec<String>,
}

impl HumanMotion {
    /// Forward kinematics of all frames; from the files' axes (y up) to ours (z up): x, y, z become x, -z, y.
    ///
    /// `values` is `[T, channels]`, angles in rad, lengths in units of `unit_m` meters.
    pub(crate) fn from_channels(
        path: &Path,
        skeleton: Skeleton,
        fps: f64,
        unit_m: f64,
        values: &[f64],
    ) -> Self {
        let up = about(0, std::f64::consts::FRAC_PI_2);
        let frames = values.len() / skeleton.channels.max(1);
        let mut motion = Self {
            name: path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default(),
            path: path.to_owned(),
            fps,
            frames,
            pos: Vec::with_capacity(frames * skeleton.bones.len()),
            quat: Vec::with_capacity(frames * skeleton.bones.len()),
            skeleton: Skeleton::default(),
            notes: Vec::new(),
        };
        for t in 0..frames {
            for pose in skeleton.forward(&values[t * skeleton.channels..(t + 1) * skeleton.channels]) {
                motion.pos.push(up.rotate(Vec3(pose.pos)).scale(unit_m).0);
                motion.quat.push(up.mul(Quat(pose.quat)).normalize().0);
            }
        }
        motion.skeleton = skeleton;
        motion
    }

    /// Points of frame `t` `[m]`.
    pub fn pos(&self, t: usize) -> &[[f64; 3]] {
        let n = self.skeleton.bones.len();
        &self.pos[t * n..(t + 1) * n]
    }

    /// Orientations of frame `t`, w, x, y, z.
    pub fn quat(&self, t: usize) -> &[[f64; 4]] {
        let n = self.skeleton.bones.len();
        &self.quat[t * n..(t + 1) * n]
    }

    /// Time from the first to the last frame `[s]`.
    pub fn duration_s(&self) -> f64 {
        (self.frames - 1) as f64 / self.fps
    }

    /// The frames from second `from` to second `to` of the file, both cut to the motion; at least one frame.
    pub fn cut(&self, from_s: f64, to_s: f64) -> Self {
        let n = self.skeleton.bones.len();
        let frame = |s: f64| ((s * self.fps).round().max(0.0) as usize).min(self.frames - 1);
        let (a, b) = (frame(from_s), frame(to_s).max(frame(from_s)) + 1);
        Self {
            frames: b - a,
            pos: self.pos[a * n..b * n].to_vec(),
            quat: self.quat[a * n..b * n].to_vec(),
            ..self.clone()
        }
    }

    /// The motion sampled at `fps` frames a second while its own time runs `1 / scale` times as fast: `scale` 2 is half speed.
    /// Positions are interpolated linearly, orientations along the shorter arc.
    pub fn resample(&self, fps: f64, scale: f64) -> Self {
        let last = self.frames - 1;
        let step = self.fps / (fps * scale);
        let frames = (last as f64 / step + 1e-9).floor() as usize + 1;
        let n = self.skeleton.bones.len();
        let mut out = Self {
            fps,
            frames,
            pos: Vec::with_capacity(frames * n),
            quat: Vec::with_capacity(frames * n),
            skeleton: self.skeleton.clone(),
            name: self.name.clone(),
            path: self.path.clone(),
            notes: self.notes.clone(),
        };
        for t in 0..frames {
            let time = (t as f64 * step).min(last as f64);
            let a = (time.floor() as usize).min(last);
            let b = (a + 1).min(last);
            let s = time - a as f64;
            for i in 0..n {
                let (p, q) = (Vec3(self.pos(a)[i]), Vec3(self.pos(b)[i]));
                out.pos.push((p + (q - p).scale(s)).0);
                out.quat.push(slerp(self.quat(a)[i], self.quat(b)[i], s));
            }
        }
        out
    }
}
