//! Footage of an episode.

use std::sync::Arc;

use paid_lanes::Vec3;
use paid_play::ReferenceLibrary;
use paid_task::{EnvSample, KickEvent};

use super::film::pose_of;
use super::recording::{BodyPoses, Footage, Frame};
use crate::episodes::{Ending, EvalSetup, Observer};

/// Records an episode, the start first, then every control step.
pub struct Recorder {
    library: Arc<ReferenceLibrary>,
    frames: Vec<Frame>,
    kick: Option<KickEvent>,
    ending: Option<Ending>,
}

impl Recorder {
    /// For an episode in `setup`.
    pub fn new(setup: &EvalSetup) -> Self {
        Self { library: Arc::clone(&setup.library), frames: Vec::new(), kick: None, ending: None }
    }

    /// The footage.
    pub fn footage(self, setup: &EvalSetup, name: String, goal_half_width_m: f64) -> Footage {
        let mut events = Vec::new();
        if let Some(kick) = &self.kick {
            let side = ["left", "right"][kick.foot];
            let body = kick.body.map_or_else(String::new, |b| format!(" ({})", setup.robot.bodies[b].name));
            let label = if kick.correct { "the labeled foot" } else { "not the labeled foot" };
            let speed = Vec3(kick.foot_vel).norm();
            let text = format!("kick by the {side} foot{body}, {label}, foot {speed:.1} m/s");
            events.push((kick.step as usize, text));
            if let Some(vel) = kick.ball_vel_after {
                let text = format!("ball leaves at {:.1} m/s", Vec3(vel).norm());
                // Five control steps later, see `KickEvent`.
                events.push((kick.step as usize + 5, text));
            }
        }
        let last = self.frames.len().saturating_sub(1);
        events.push((
            last,
            match self.ending {
                Some(Ending::Failed) => "episode ended by a failure".to_owned(),
                Some(Ending::Over) | None => "episode over".to_owned(),
            },
        ));
        events.retain(|(t, _)| *t <= last);
        Footage {
            name,
            model: setup.robot.clone(),
            dt_s: setup.preset.control_dt_s(),
            frames: self.frames,
            ball_radius_m: setup.preset.scene.ball.then_some(setup.preset.ball_params.radius_m),
            goal_half_width_m,
            episode: true,
            trail_s: f64::INFINITY,
            human: None,
            events,
        }
    }
}

impl Observer for Recorder {
    fn observe(&mut self, sample: &EnvSample, ended: Option<Ending>) -> bool {
        let clip = &self.library.clips()[sample.motion];
        let (bodies, joints) = (sample.bodies.len(), sample.joint_pos.len());
        let rows = sample.frame * bodies..(sample.frame + 1) * bodies;
        self.kick.clone_from(&sample.kick);
        self.ending = ended;
        self.frames.push(Frame {
            pose: pose_of(sample),
            ghost: Some(BodyPoses::new(&clip.body_pos[rows.clone()], &clip.body_quat[rows])),
            mark: sample.ball_pos,
            mark_speed: Vec3(sample.ball_vel).norm(),
            contact_force: sample.contact_force.clone(),
            ball_force: sample.ball_force,
            joint_pos: sample.joint_pos.clone(),
            reference_pos: clip.joint_pos[sample.frame * joints..(sample.frame + 1) * joints].to_vec(),
            joint_vel: sample.joint_vel.clone(),
            joint_torque: sample.joint_torque.clone(),
            rewards: sample.rewards.clone(),
        });
        ended.is_some()
    }
}
