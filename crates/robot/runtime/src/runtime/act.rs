//! The policy's step, and from targets to a command.

use paid_lanes::Vec3;
use paid_play::motion_for;
use paid_policy::action::{joint_target, limit_action};
use paid_policy::observation::observe;
use paid_policy::{Pose, RobotView, SceneView, Views};

use super::{Controller, POLICY_US, Playing, Reason, Runtime, State};
use crate::wire::{COMMAND_US, LowCmd, MotorCmd};

impl Runtime {
    /// A control step: decides, and lets the policy act where it moves the robot. True if it has acted.
    pub(super) fn think(&mut self, now_us: u64) -> bool {
        match self.state {
            State::Ready => self.look_for_a_kick(now_us),
            State::Settle => self.settle(now_us),
            State::Passive | State::StandUp | State::Kick | State::Damping => {}
        }
        if self.controller != Controller::Policy || !self.moves() {
            return false;
        }
        self.act(now_us);
        true
    }

    /// Begins a kick if there is one to begin.
    fn look_for_a_kick(&mut self, now_us: u64) {
        self.waiting = match self.next_motion(now_us) {
            Ok(motion) => {
                self.begin_kick(now_us, motion);
                ""
            }
            Err(waiting) => waiting,
        };
    }

    /// The motion for the estimated ball, or what is missing.
    fn next_motion(&self, now_us: u64) -> Result<usize, &'static str> {
        let limits = &self.limits;
        if !self.enabled {
            return Err("keys R1 and X");
        }
        if let Some(missing) = self.missing_senses(now_us).first() {
            return Err(missing);
        }
        let belief = self.world.belief(f64::INFINITY);
        if !belief.known || belief.age_s > limits.ball_fresh_s {
            return Err("a ball");
        }
        if self.world.looks() < limits.ball_looks {
            return Err("a longer look at the ball");
        }
        if belief.ball.covariance[2].sqrt() > limits.ball_speed_known_m_s {
            return Err("a steady view of the ball");
        }
        let ball =
            self.world.ball_ahead(&belief).ok_or("odometry")?.as_chosen_by(self.player.play.predicts_ball());
        let facts = self.player.library.facts();
        let motion = motion_for(facts, &ball, POLICY_US as f64 * 1e-6);
        let at = ball.at_strike(&facts[motion], 0, POLICY_US as f64 * 1e-6);
        let within = |x: f64, [lo, hi]: [f64; 2]| lo <= x && x <= hi;
        if !within(at[0], limits.reach_ahead_m) || !within(at[1], limits.reach_left_m) {
            return Err("a ball within reach");
        }
        if self.world.goal_bearing().is_none_or(|angle| angle.abs() > limits.goal_bearing_rad) {
            return Err("the goal in front");
        }
        Ok(motion)
    }

    fn begin_kick(&mut self, now_us: u64, motion: usize) {
        if self.controller != Controller::Policy {
            self.done.fill(0.0);
        }
        self.memory.reset(0);
        self.world.begin_kick();
        self.playing = Some(Playing { motion, step: 0, shown: None, blind: false, unseen: false });
        if self.controller == Controller::Policy {
            // Memory and motion change from one step to the next.
            (self.switched_us, self.switch_rad_s) = (now_us, self.limits.kick_rad_s);
        }
        self.switch(now_us, Controller::Policy);
        self.kicks += 1;
        let name = &self.player.library.facts()[motion].name;
        let reason = format!("kick {}: a ball within reach, motion '{name}'", self.kicks);
        self.enter(now_us, State::Kick, reason);
    }

    /// After the motion: still for a while, or time is up.
    fn settle(&mut self, now_us: u64) {
        let limits = &self.limits;
        if self.body.speed() > limits.still_joint_rad_s {
            self.still_since_us = None;
        } else {
            self.still_since_us.get_or_insert(now_us);
        }
        let seconds = |since: u64| (now_us - since) as f64 * 1e-6;
        let still = self.still_since_us.is_some_and(|since| seconds(since) >= limits.still_s);
        if !still && seconds(self.entered_us) < limits.settle_s {
            return;
        }
        let reason = if still { "the robot stands still" } else { "the time to settle is over" };
        if limits.policy_holds {
            self.enter(now_us, State::Ready, reason);
        } else {
            self.begin_to_stand(now_us, reason);
        }
    }

    /// Observes, asks the policy, decodes its action.
    fn act(&mut self, now_us: u64) {
        let Some(scene) = self.scene(now_us) else { return };
        let Some(playing) = &self.playing else { return };
        let (motion, step) = (playing.motion, playing.step);
        let player = &self.player;
        let n = player.joints();
        let mut joints = std::mem::take(&mut self.joints);
        let reference = player.reference(motion, step + 1, &mut joints);
        let (mut rel, mut vel, mut last) = ([0.0; 64], [0.0; 64], [0.0; 64]);
        for (j, &m) in player.to_model.iter().enumerate() {
            rel[j] = self.body.joint_pos[m] - player.control.default_pos[m];
            vel[j] = self.body.joint_vel[m];
            last[j] = f64::from(self.done[j]);
        }
        let robot = RobotView {
            base_rot: self.body.base_rot,
            base_ang_vel: self.body.base_ang_vel,
            joint_pos_rel: &rel[..n],
            joint_vel: &vel[..n],
            last_action: &last[..n],
        };
        let views = Views { robot, privileged: None, reference: Some(reference), scene: Some(scene) };
        self.numbers.clear();
        observe(&player.play.observations.policy, &views, &mut self.numbers);
        self.joints = joints;
        self.trace.observation.clear();
        self.trace.observation.extend(self.numbers.iter().map(|x| *x as f32));
        let mirrors = player.mirrors(motion);
        if let Some(mirrors) = mirrors {
            mirrors.observation.apply_to_marked(&mut self.trace.observation, &[true], &mut self.image);
        }
        player.policy.act(&self.trace.observation, &mut self.memory, &mut self.trace.action);
        self.done.copy_from_slice(&self.trace.action);
        if let Some(mirrors) = mirrors {
            mirrors.action.apply_to_marked(&mut self.done, &[true], &mut self.image);
        }
        // A number that is none stays: neither side of the comparison holds for it.
        let larger = |worst: f32, a: &f32| if a.abs() <= worst { worst } else { a.abs() };
        let worst =
            self.done.iter().fold(0.0, |worst, a| if f32::is_nan(worst) { worst } else { larger(worst, a) });
        if worst.is_nan() || f64::from(worst) > self.limits.action {
            self.damp(now_us, Reason::Action(f64::from(worst)));
            return;
        }
        for (j, &m) in player.to_model.iter().enumerate() {
            let action = limit_action(f64::from(self.done[j]));
            let (scale, rest) = (player.control.action_scale[m], player.control.default_pos[m]);
            let target = joint_target(action, scale, rest);
            self.wanted[m] = self.limits.target(player, m, self.wanted[m], target);
        }
        let frames = player.library.facts()[motion].frames;
        if let Some(playing) = &mut self.playing {
            playing.step += 1;
            playing.shown = Some(scene);
        }
        if self.state == State::Kick && step + 2 >= frames {
            self.enter(now_us, State::Settle, "the motion is over");
        }
    }

    /// Ball and goal to show. A kick whose odometry fails before its strike continues with what was shown last; one that no longer sees the
    /// ball, with its estimated place in odometry's frame.
    fn scene(&mut self, now_us: u64) -> Option<SceneView<f64>> {
        let to_strike = self.to_strike();
        let playing = self.playing.as_ref()?;
        let facts = &self.player.library.facts()[playing.motion];
        let of_motion = facts.times_from(playing.step, POLICY_US as f64 * 1e-6);
        let (blind, unseen, shown) = (playing.blind, playing.unseen, playing.shown);
        if self.state == State::Kick && to_strike > 0.0 && !blind {
            let odometry = self.world.odometry_age(now_us);
            let ball = self.world.belief(to_strike).age_s;
            let without_odometry = odometry > self.limits.odometry_age_s;
            let lost = if without_odometry {
                Some(format!("odometry is {:.0} ms old", 1e3 * odometry))
            } else if ball > self.limits.ball_age_s && !unseen {
                Some(format!("the ball was seen {ball:.1} s ago"))
            } else {
                None
            };
            if let Some(lost) = lost {
                self.note(now_us, format!("finishes without looking: {lost}"));
                if let Some(playing) = &mut self.playing {
                    playing.blind = without_odometry;
                    playing.unseen = true;
                }
            }
        }
        let blind = self.playing.as_ref().is_some_and(|playing| playing.blind);
        match (blind, shown, self.world.base(now_us, &self.body)) {
            (true, Some(shown), _) => Some(shown),
            (_, _, Some(base)) => Some(self.world.scene(&base, of_motion, to_strike)),
            (_, shown, None) => Some(shown.unwrap_or_else(nothing)),
        }
    }

    /// Odometry has begun a new frame, in which neither goal nor ball have a place: a running motion continues with what was shown last,
    /// and so does a policy that holds its last pose.
    pub(super) fn lose_sight(&mut self, now_us: u64) {
        let before_strike = self.state == State::Kick && self.to_strike() > 0.0;
        let Some(playing) = &mut self.playing else { return };
        let looked = !std::mem::replace(&mut playing.blind, true);
        if looked && before_strike {
            self.note(now_us, "finishes without looking: odometry has begun a new frame");
        }
    }

    /// The command of this moment: targets limited in rate and torque, or damping.
    pub(super) fn command(&mut self, now_us: u64) -> LowCmd {
        let (player, limits) = (&self.player, &self.limits);
        let joints = player.joints();
        if self.controller == Controller::Damping {
            return LowCmd::damping(self.intake.mode_machine, joints, limits.passive_kd);
        }
        let limited = (now_us - self.switched_us) as f64 * 1e-6 < limits.switch_s;
        let reach = self.switch_rad_s * COMMAND_US as f64 * 1e-6;
        let mut command = LowCmd { mode_machine: self.intake.mode_machine, ..LowCmd::default() };
        for j in 0..joints {
            let wanted = self.wanted[j];
            let from = self.limited[j];
            self.limited[j] = if limited { wanted.clamp(from - reach, from + reach) } else { wanted };
            let (mut kp, mut kd) = (player.control.stiffness[j], player.control.damping[j]);
            if self.controller == Controller::Standing {
                kp = (limits.stand_stiffness * kp).min(limits.stand_stiffness_most);
                kd *= limits.stand_damping;
            }
            let joint = &player.model.joints[j];
            let (q, dq) = (self.body.joint_pos[j], self.body.joint_vel[j]);
            // The whole torque within the motor's: as training and evaluation do at every physics step.
            let effort = joint.effort_limit;
            let torque = (kp * (self.limited[j] - q) - kd * dq).clamp(-effort, effort);
            let target = q + (torque + kd * dq) / kp;
            command.motors[player.motors[j]] = MotorCmd {
                mode: 1,
                q: target as f32,
                dq: 0.0,
                tau: 0.0,
                kp: kp as f32,
                kd: kd as f32,
                reserve: 0,
            };
        }
        command.sealed()
    }
}

/// Ball and goal straight ahead, for a robot that has lost itself.
fn nothing() -> SceneView<f64> {
    let ball = Pose::identity().point_in_world(Vec3([1.0, 0.0, -0.65]));
    SceneView::new(ball, Vec3([5.0, 0.0, -0.65]))
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use crate::limits::Limits;
    use crate::message::{Packet, TorsoPose};
    use crate::player::{Player, PlayerSpec};
    use crate::wire::LowState;

    /// A state of an upright robot, and a pose of its torso in this frame of odometry.
    fn hear(runtime: &mut Runtime, now_us: u64, frame: u32) {
        let mut state = LowState { mode_machine: 5, tick: (now_us / 1000) as u32, ..LowState::default() };
        state.imu.quaternion = [1.0, 0.0, 0.0, 0.0];
        runtime.take(now_us, &Packet::LowState(state.sealed().to_cdr()));
        runtime.world.remember(now_us, &runtime.body, &runtime.player);
        let quaternion = [1.0, 0.0, 0.0, 0.0];
        let pose = TorsoPose { age_us: 0, frame, position: [0.0, 0.0, 0.9], quaternion };
        runtime.take(now_us, &Packet::Torso(pose));
    }

    #[test]
    fn from_a_new_frame_of_odometry_to_the_next_kick_the_policy_is_shown_what_it_was_shown_last() {
        let policy = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
        let player = Player::load(&PlayerSpec { policy, motions: None, sets: Vec::new() }).expect("policy");
        let mut runtime = Runtime::new(Arc::new(player), Limits::default());
        let last = SceneView::new(Vec3([1.0, 0.2, -0.6]), Vec3([4.0, 0.3, -0.6]));
        let playing = |step| Playing { motion: 0, step, shown: Some(last), blind: false, unseen: false };
        let shown = |runtime: &mut Runtime, now_us: u64| {
            let scene = runtime.scene(now_us).expect("a motion");
            [scene.ball.0, scene.goal.0]
        };
        let frozen = [last.ball.0, last.goal.0];
        // After the strike the policy holds the clip's last pose, and looks.
        (runtime.state, runtime.playing) = (State::Ready, Some(playing(500)));
        hear(&mut runtime, 2_000, 0);
        assert_ne!(shown(&mut runtime, 2_000), frozen);
        hear(&mut runtime, 4_000, 1);
        assert_eq!(shown(&mut runtime, 4_000), frozen);
        hear(&mut runtime, 6_000, 1);
        assert_eq!(shown(&mut runtime, 6_000), frozen, "the new frame continues");
        assert!(runtime.events.is_empty(), "{:?}", runtime.events);
        // The next kick looks again, and reports it if it no longer can.
        runtime.begin_kick(8_000, 0);
        hear(&mut runtime, 8_000, 1);
        assert_eq!(runtime.playing.as_ref().map(|playing| playing.blind), Some(false));
        runtime.playing = Some(playing(0));
        hear(&mut runtime, 10_000, 2);
        assert_eq!(shown(&mut runtime, 10_000), frozen);
        let said = runtime.events.last().map(|event| event.reason.as_str());
        assert_eq!(said, Some("finishes without looking: odometry has begun a new frame"));
    }
}
