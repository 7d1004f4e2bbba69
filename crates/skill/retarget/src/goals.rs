//! A human motion as goals for the robot's bodies.

use paid_lanes::{Quat, Vec3};

use crate::{HumanMotion, Naming, RetargetError, Role, Table};

/// Height of the human that the tables were made for `[m]`.
const TABLE_HEIGHT_M: f64 = 1.8;

/// Where a body shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Place of the task's point in the first and the second stage, world `[m]`.
    pub pos: [[f64; 3]; 2],
    /// Orientation of the body, unit, w, x, y, z.
    pub quat: [f64; 4],
}

/// Goals of all frames `[T, tasks]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Goals {
    /// T.
    pub frames: usize,
    /// Frames a second.
    pub fps: f64,
    goals: Vec<Goal>,
}

impl Goals {
    /// Scales a human of `height_m` about the hips, turns bone axes into the robot's and shifts, as the table says.
    ///
    /// # Errors
    /// If the naming names bones that the motion lacks.
    pub fn new(
        motion: &HumanMotion,
        naming: &Naming,
        table: &Table,
        height_m: f64,
    ) -> Result<Self, RetargetError> {
        let ratio = height_m / TABLE_HEIGHT_M;
        let bone = |name: &str| {
            motion.skeleton.find(name).ok_or_else(|| RetargetError::Bones {
                path: motion.path.clone(),
                naming: naming.name,
                missing: name.to_owned(),
                found: motion
                    .skeleton
                    .bones
                    .iter()
                    .map(|b| b.name.escape_debug().to_string())
                    .collect::<Vec<_>>()
                    .join(", "),
            })
        };
        let mut parts = Vec::new();
        for task in &table.tasks {
            // Every naming lists every role.
            if let Some(source) = naming.sources.iter().find(|s| s.role == task.role) {
                let turn = Quat(source.turn).mul(Quat(task.turn));
                parts.push((task, bone(&source.position)?, bone(&source.orientation)?, turn));
            }
        }
        let root = parts.iter().find(|(task, ..)| task.role == Role::Hips).map(|&(task, at, ..)| (task, at));
        let mut goals = Vec::with_capacity(motion.frames * parts.len());
        for t in 0..motion.frames {
            let (pos, quat) = (motion.pos(t), motion.quat(t));
            let (hips, place) = root.map_or((Vec3::zero(), Vec3::zero()), |(task, at)| {
                (Vec3(pos[at]), Vec3(pos[at]).scale(task.scale * ratio))
            });
            for &(task, at, axes, turn) in &parts {
                let orientation = Quat(quat[axes]).mul(turn).normalize();
                let scaled = (Vec3(pos[at]) - hips).scale(task.scale * ratio) + place;
                let shifted = scaled + orientation.rotate(Vec3(task.shift));
                goals.push(Goal { pos: [shifted.0, scaled.0], quat: orientation.0 });
            }
        }
        Ok(Self { frames: motion.frames, fps: motion.fps, goals })
    }

    /// Goals of frame `t`, one a task.
    pub fn frame(&self, t: usize) -> &[Goal] {
        let n = self.goals.len() / self.frames;
        &self.goals[t * n..(t + 1) * n]
    }
}
