//! A robot at rest with a ball, for the tests of single terms.

use std::sync::Arc;

use paid_physics::{BodyState, GroupState};
use paid_play::{ReferenceClip, ReferenceLibrary};
use paid_robot::{RobotModel, RobotSpec};

use crate::TaskPreset;
use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::references::tracking::TrackingErrors;
use crate::scene::kick::KickStep;
use crate::terms::TermInput;

/// What a term reads. A test sets what its term measures; all else is zero and upright.
pub(crate) struct Fixture {
    pub config: TaskConfig,
    pub state: GroupState<f64>,
    pub group: GroupTask<f64>,
    pub tracking: TrackingErrors<f64>,
    pub kick: KickStep<f64>,
}

impl Fixture {
    /// The built-in robot under the preset `paper_stage2`, with the release's kernels.
    pub(crate) fn new() -> Self {
        let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
        let sets = ["rewards.body_kernel=exp_of_mean", "rewards.ball_prox.from=anchor"].map(str::to_owned);
        let preset = TaskPreset::builtin_with("paper_stage2", &sets).expect("valid");
        let (joints, bodies) = (robot.joints.len(), robot.bodies.len());
        let clip = ReferenceClip {
            name: "rest".into(),
            fps: 50.0,
            kick_foot: 1,
            strike_frame: None,
            frames: 2,
            joint_pos: vec![0.0; 2 * joints],
            joint_vel: vec![0.0; 2 * joints],
            body_pos: vec![[0.0; 3]; 2 * bodies],
            body_quat: vec![[1.0, 0.0, 0.0, 0.0]; 2 * bodies],
            body_com_vel: vec![[0.0; 3]; 2 * bodies],
            body_ang_vel: vec![[0.0; 3]; 2 * bodies],
        };
        let library = Arc::new(ReferenceLibrary::new(vec![clip], &robot, &spec).expect("fits"));
        let control = spec.resolve(&robot).expect("fits");
        let config = TaskConfig::new(&robot, &spec, control, &library, &preset).expect("fits");
        let mut group = GroupTask::new(&config, library.layout());
        group.reference.gather(&library, &[0], &[0]);
        Self {
            state: GroupState::empty(joints, bodies),
            tracking: TrackingErrors::new(&config),
            kick: KickStep::none(),
            group,
            config,
        }
    }

    pub(crate) fn input(&self) -> TermInput<'_, f64> {
        TermInput {
            config: &self.config,
            state: &self.state,
            group: &self.group,
            tracking: &self.tracking,
            kick: self.kick,
        }
    }

    pub(crate) fn anchor(&mut self) -> &mut BodyState<f64> {
        &mut self.state.bodies[self.config.followed[self.config.anchor]]
    }

    /// The left (0) or right (1) foot.
    pub(crate) fn foot(&mut self, side: usize) -> &mut BodyState<f64> {
        &mut self.state.bodies[self.config.followed[self.config.feet[side]]]
    }
}

/// Equal but for rounding.
pub(crate) fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found}, expected {expected}");
}
