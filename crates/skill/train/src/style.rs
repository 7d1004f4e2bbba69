//! A style reward in a run: adversarial motion priors with the clips of the run's motions.

use std::sync::Arc;

use paid_amp::{AmpConfig, AmpError, Clips, StyleReward};
use paid_learn::RewardRole;
use paid_policy::env::STYLE_GROUP;
use paid_task::layers::KeyError;
use paid_task::preset::ReferenceSource;
use paid_task::{EpisodeRules, InitialState, ShardSetup, TaskSetup, TrainShard, build_shard};
use serde::{Deserialize, Serialize};

use crate::setup::clips_of;
use crate::{RunPreset, Scene, TrainError, Trainer};

/// How a style reward takes part in a run. The discriminator sees `task.observations.style`; the clips are those of `run.motions`, also
/// where the task follows none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AmpPreset {
    /// Factor on the task's reward.
    pub task: f64,
    /// Style reward for a frame that the discriminator takes for a clip's, per second.
    pub style: f64,
    /// True: the style reward has a critic of its own, shaped as `learn.critic`, and both advantages are added.
    pub own_critic: bool,
    /// The discriminator and its training.
    pub discriminator: AmpConfig,
}

impl Default for AmpPreset {
    fn default() -> Self {
        Self { task: 1.0, style: 10.0, own_critic: false, discriminator: AmpConfig::default() }
    }
}

impl RunPreset {
    /// A discriminator needs something to see, and what it would see needs a discriminator.
    pub(crate) fn check_style(&self) -> Result<(), KeyError> {
        let wrong = |key: &str, message: String| Err(KeyError { key: key.to_owned(), message });
        let sees = !self.task.observations.style.is_empty();
        let Some(amp) = &self.amp else {
            if sees {
                return wrong(
                    "task.observations.style",
                    "expected none without [amp], found some".to_owned(),
                );
            }
            return Ok(());
        };
        if !sees {
            return wrong("task.observations.style", "expected terms for [amp], found none".to_owned());
        }
        for (key, value) in [("amp.task", amp.task), ("amp.style", amp.style)] {
            if !(value >= 0.0 && value.is_finite()) {
                return wrong(key, format!("expected zero or more, found {value}"));
            }
        }
        match amp.discriminator.check() {
            Err(AmpError::Config { key, expected, found }) => {
                wrong(&format!("amp.discriminator.{key}"), format!("expected {expected}, found {found}"))
            }
            _ => Ok(()),
        }
    }

    /// The role of the style reward in the learner.
    pub(crate) fn style_role(&self, amp: &AmpPreset) -> RewardRole {
        let (task, learned) = (amp.task as f32, (amp.style * self.task.control_dt_s()) as f32);
        if amp.own_critic {
            RewardRole::OwnCritic { task, learned, critic: self.learn.critic.clone() }
        } else {
            RewardRole::Mixed { task, learned }
        }
    }
}

impl Scene {
    /// The style reward of a run; `None` without one.
    ///
    /// # Errors
    /// If the motions cannot be read or do not fit the robot.
    pub fn style(&self, preset: &RunPreset) -> Result<Option<StyleReward>, TrainError> {
        let Some(amp) = &preset.amp else { return Ok(None) };
        let setup = |error: AmpError| TrainError::Setup(error.to_string());
        let (features, frames) = self.style_frames(preset)?;
        let clips = Arc::new(Clips::new(features, &frames).map_err(setup)?);
        StyleReward::new(clips, &amp.discriminator, preset.run.seed).map(Some).map_err(setup)
    }

    /// The trainer with the style reward and the teacher of its run, if it has them.
    ///
    /// # Errors
    /// As [`Scene::style`], or if the teacher does not fit.
    pub(crate) fn equip<E: TrainShard + ?Sized>(
        &self,
        preset: &RunPreset,
        trainer: Trainer<E>,
    ) -> Result<Trainer<E>, TrainError> {
        let trainer = match self.style(preset)? {
            Some(style) => trainer.with_style(style)?,
            None => trainer,
        };
        match self.teacher(preset)? {
            Some(teacher) => trainer.with_teacher(teacher),
            None => Ok(trainer),
        }
    }

    /// The frames of the run's motions as the discriminator sees frames: the robot is put into each of them. Numbers of a frame, then per
    /// clip `[frame, feature]`.
    fn style_frames(&self, preset: &RunPreset) -> Result<(usize, Vec<Vec<f32>>), TrainError> {
        let setup = |error: &dyn core::fmt::Display| TrainError::Setup(error.to_string());
        let mut task = preset.task.clone();
        task.reference = ReferenceSource::Motions;
        (task.randomization.robot, task.randomization.ball) = (false, false);
        let library = if preset.task.reference == ReferenceSource::Motions {
            Arc::clone(&self.library)
        } else {
            Arc::new(clips_of(preset, &self.model, &self.spec)?)
        };
        let isa = preset.isa().map_err(TrainError::Setup)?;
        let lanes = isa.lanes();
        let (robot, spec, seed) = (&self.model, &self.spec, preset.run.seed);
        let task = TaskSetup { robot, spec, library: &library, preset: &task, first_env: 0, seed };
        let mut shard = build_shard(&ShardSetup { task, isa, num_envs: lanes }).map_err(|e| setup(&e))?;
        shard.eval().set_rules(EpisodeRules::evaluation());
        let groups = shard.observation_groups();
        let mut rows: Vec<Vec<f32>> = groups.iter().map(|group| vec![0.0; group.size * lanes]).collect();
        let style = groups.iter().position(|group| group.name == STYLE_GROUP);
        let style =
            style.ok_or_else(|| TrainError::Setup("expected a group 'style', found none".to_owned()))?;
        let features = groups[style].size;
        let mut clips = Vec::new();
        for (motion, facts) in library.facts().iter().enumerate() {
            // An episode cannot begin in a motion's last frame.
            let frames: Vec<usize> = (0..facts.frames - 1).collect();
            let mut clip = Vec::with_capacity(frames.len() * features);
            for block in frames.chunks(lanes) {
                for (env, &frame) in block.iter().enumerate() {
                    let start = InitialState { frame, ..InitialState::nominal(motion) };
                    shard.eval().force_start(env, &start).map_err(|e| setup(&e))?;
                }
                let mut out: Vec<&mut [f32]> = rows.iter_mut().map(Vec::as_mut_slice).collect();
                shard.observe(&mut out);
                for env in 0..block.len() {
                    clip.extend((0..features).map(|i| rows[style][i * lanes + env]));
                }
            }
            clips.push(clip);
        }
        Ok((features, clips))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use paid_motion::MotionLibrary;

    use super::*;

    #[test]
    fn a_clips_frames_have_its_joints_and_the_torsos_view_of_its_bodies() {
        let terms =
            r#"task.observations.style=["projected_gravity", "joint_pos_rel", "body_pos"]"#.to_owned();
        let preset = RunPreset::resolve("amp", &[terms]).expect("resolves");
        let scene = Scene::load(&preset).expect("loads");
        let (features, frames) = scene.style_frames(&preset).expect("frames");
        let (joints, bodies) = (scene.model.joints.len(), scene.spec.tracked_bodies.len());
        assert_eq!(features, 3 + joints + 3 * bodies);

        let motions = MotionLibrary::open(Path::new(""), &scene.model, &scene.spec, 50.0).expect("built in");
        assert_eq!(frames.len(), motions.clips.len());
        let (clip, seen) = (&motions.clips[4], &frames[4]);
        assert_eq!(seen.len(), (clip.frames - 1) * features);
        let spec = scene.spec.resolve(&scene.model).expect("resolves");
        let names = scene.model.joint_names();
        for t in [0, clip.frames / 2] {
            let frame = &seen[t * features..(t + 1) * features];
            for (k, name) in scene.spec.policy_joint_order.iter().enumerate() {
                let j = names.iter().position(|n| n == name).expect("a joint");
                let expected = clip.joint_pos[t * joints + j] - spec.default_pos[j];
                assert!((f64::from(frame[3 + k]) - expected).abs() < 1e-5, "frame {t}, {name}");
            }
            // Gravity is a unit vector that points down in an upright robot.
            let [x, y, z] = [frame[0], frame[1], frame[2]];
            assert!(z < -0.8 && (x * x + y * y + z * z - 1.0).abs() < 1e-5, "frame {t}: {x} {y} {z}");
            // The torso is at its own origin; distances from it do not depend on the frame of axes.
            let body = |name: &str| scene.model.body_index(name).expect("a body");
            let at = |name: &str| clip.body_pos[t * scene.model.bodies.len() + body(name)];
            let anchor = at(&scene.spec.anchor_body);
            for (k, name) in scene.spec.tracked_bodies.iter().enumerate() {
                let place = &frame[3 + joints + 3 * k..][..3];
                let found = place.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
                let there = at(name);
                let expected = (0..3).map(|i| (there[i] - anchor[i]).powi(2)).sum::<f64>().sqrt();
                assert!((found - expected).abs() < 1e-4, "frame {t}, {name}: {found} {expected}");
            }
        }
    }

    /// A quarter turn.
    const QUARTER: f64 = core::f64::consts::FRAC_PI_2;

    /// A motion file of twelve frames at 50 a second: the base drifts by `drift` and stands at `attitude` (x, y, z, w) of the angle; the joints
    /// named have their angle and their rate, all others are at zero. Angles are those of frame 2.
    fn moving(
        drift: [f64; 3],
        attitude: impl Fn(f64) -> [f64; 4],
        rate: f64,
        joints: &[(&str, f64, f64)],
    ) -> String {
        let names = paid_robot::RobotModel::g1().joint_names().join(",");
        let mut text = format!("# fps: 50\n# kick_leg: right\n# kick_frame: 6\nx,y,z,qx,qy,qz,qw,{names}\n");
        for t in 0..12 {
            let time = 0.02 * (f64::from(t) - 2.0);
            let place = [3.0 + drift[0] * time, -2.0 + drift[1] * time, 1.0 + drift[2] * time];
            let angles = names.split(',').map(|name| {
                let found = joints.iter().find(|(joint, ..)| *joint == name);
                found.map_or(0.0, |(_, angle, rate)| angle + rate * time)
            });
            let row: Vec<String> =
                place.into_iter().chain(attitude(rate * time)).chain(angles).map(|x| x.to_string()).collect();
            text.push_str(&row.join(","));
            text.push('\n');
        }
        text
    }

    #[test]
    fn velocities_axes_and_signs_of_a_clips_frame_are_those_of_a_calculation_by_hand() {
        let half = |x: f64| (0.5 * x).sin_cos();
        // Turned left by 90 degrees, turning on at 0.4 rad/s, pitched forward by 30 degrees; the waist is turned left by 90 degrees more.
        let pitched = |angle: f64| {
            let ((sz, cz), (sy, cy)) = (half(QUARTER + angle), half(QUARTER / 3.0));
            [-sz * sy, cz * sy, sz * cy, cz * cy]
        };
        // Rolled to the right by 30 degrees, rolling on at 0.4 rad/s.
        let rolled = |angle: f64| {
            let (s, c) = half(QUARTER / 3.0 + angle);
            [s, 0.0, 0.0, c]
        };
        let joints = [
            ("waist_yaw_joint", QUARTER, 0.0),
            ("right_knee_joint", 0.7, -1.0),
            ("left_shoulder_pitch_joint", 0.3, 0.5),
        ];
        let folder = tempfile::tempdir().expect("folder");
        let write =
            |name: &str, text: String| std::fs::write(folder.path().join(name), text).expect("writes");
        write("a.csv", moving([0.5, -0.2, 0.1], pitched, 0.4, &joints));
        write("b.csv", moving([0.0, 0.3, 0.0], rolled, 0.4, &[]));
        let motions = format!("run.motions={:?}", folder.path().display().to_string());
        let preset = RunPreset::resolve("amp", &[motions]).expect("resolves");
        let scene = Scene::load(&preset).expect("loads");
        let (features, clips) = scene.style_frames(&preset).expect("frames");
        // Gravity, velocity, angular velocity, 29 joints twice, 14 bodies.
        assert_eq!((features, clips.len()), (3 + 3 + 3 + 29 + 29 + 3 * 14, 2));
        let near = |found: &[f32], expected: &[f64], what: &str| {
            let far = found.iter().zip(expected).any(|(f, e)| (f64::from(*f) - e).abs() > 2e-4);
            assert!(!far && found.len() == expected.len(), "{what}: expected {expected:?}, found {found:?}");
        };
        let frame = |clip: usize| &clips[clip][2 * features..3 * features];
        let (s, c) = (0.5, 0.75_f64.sqrt());

        let a = frame(0);
        // Down is ahead of a robot that leans forward: (sin 30, 0, -cos 30).
        near(&a[..3], &[s, 0.0, -c], "gravity");
        // Turned back by 90 degrees the drift is (-0.2, -0.5, 0.1); pitched back, x is cos x - sin z and z is sin x + cos z.
        near(&a[3..6], &[-0.2 * c - 0.1 * s, -0.5, -0.2 * s + 0.1 * c], "velocity");
        // 0.4 rad/s about the world's vertical, which leans back in the base.
        near(&a[6..9], &[-0.4 * s, 0.0, 0.4 * c], "angular velocity");
        // In the policy's order, less the default pose: hips -0.312, knees 0.669, ankles -0.363, shoulders 0.2, elbows 0.6.
        let (mut angles, mut rates) = ([0.0; 29], [0.0; 29]);
        (angles[0], angles[1], angles[2]) = (0.312, 0.312, QUARTER);
        (angles[9], angles[10], angles[11], angles[12]) = (-0.669, 0.7 - 0.669, 0.3 - 0.2, -0.2);
        (angles[13], angles[14], angles[15], angles[16]) = (0.363, 0.363, -0.2, 0.2);
        (angles[21], angles[22]) = (-0.6, -0.6);
        (rates[10], rates[11]) = (-1.0, 0.5);
        near(&a[9..38], &angles, "joint angles");
        near(&a[38..67], &rates, "joint velocities");
        // The torso lies (-0.0039635, 0, 0.044) m from the pelvis, turned with the waist: in the torso's axes the pelvis is the opposite.
        // The hips' roll bodies lie (0, +-0.116452, -0.133165) m from the pelvis; the pelvis' left is the turned torso's ahead.
        let body = |k: usize| &a[67 + 3 * k..70 + 3 * k];
        near(body(0), &[0.003_963_5, 0.0, -0.044], "pelvis");
        near(body(1), &[0.116_452 + 0.003_963_5, 0.0, -0.133_165 - 0.044], "left hip");
        near(body(4), &[-0.116_452 + 0.003_963_5, 0.0, -0.133_165 - 0.044], "right hip");
        near(body(7), &[0.0; 3], "torso");

        let b = frame(1);
        // A robot that leans to its right has down on its right: y points left.
        near(&b[..3], &[0.0, -s, -c], "gravity");
        near(&b[3..6], &[0.0, 0.3 * c, -0.3 * s], "velocity");
        near(&b[6..9], &[0.4, 0.0, 0.0], "angular velocity");
        let body = |k: usize| &b[67 + 3 * k..70 + 3 * k];
        near(body(0), &[0.003_963_5, 0.0, -0.044], "pelvis");
        // The waist is straight: left is left.
        near(body(1), &[0.003_963_5, 0.116_452, -0.133_165 - 0.044], "left hip");
    }
}
