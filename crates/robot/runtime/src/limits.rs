//! Every limit of the runtime, with its reason. A TOML file changes them; unknown keys are refused.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::DeployError;
use crate::player::Player;

/// Limits of the robot's motion. Beyond one of them the runtime damps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Envelope {
    /// Angle of the pelvis from upright `[rad]`.
    pub tilt_rad: f64,
    /// Length of the pelvis's angular velocity `[rad/s]`.
    pub gyro_rad_s: f64,
    /// Speed of a joint as a share of its own limit.
    pub speed_share: f64,
}

/// Limits, times and gains of the runtime.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Outside of kicks, also while the policy holds a robot that is ready. Default: the vendor's own terminations, tilt 1 rad and gyro 6 rad/s; joints up to half of their speed limits,
    /// about the vendor's 10 rad/s.
    pub standing: Envelope,
    /// During a kick, and until the robot has settled after it. Default: the highest values of some 300 kicks in simulation that ended on both feet, 0.74 rad, 10.1
    /// rad/s and 1.48 of a joint's limit (an earlier policy, matches of 11), with a margin of a third, a half and a quarter.
    pub kicking: Envelope,
    /// A joint may be this far beyond its range `[rad]`. Default 0.3: in simulated kicks ankles go 0.1 to 0.2 beyond their stops.
    pub range_margin_rad: f64,
    /// Estimated torque as a share of the joint's limit. Default 1.3: estimates are noisy; a share of 1 is everyday use.
    pub torque_share: f64,
    /// Temperature of a winding in degrees Celsius. Default 120: the vendor's limit.
    pub winding_c: i16,
    /// Temperature of a casing. Default 85: the vendor's limit.
    pub casing_c: i16,
    /// Charge to start with in percent. Default 20: the vendor's limit.
    pub battery_percent: f64,
    /// Damps if no new state has come for this long `[s]`. Default 0.02: ten states.
    pub state_gap_s: f64,
    /// Wrong checksums in a row that damp. Default 3: one may be a broken packet.
    pub crc_errors: u32,
    /// False: states need no checksum, for the vendor's simulator, which sets none. Weakens nothing else.
    pub check_crc: bool,
    /// A policy step that comes this late counts as missed `[s]`. Default 0.01: half a control period.
    pub late_s: f64,
    /// Missed policy steps in a row that damp. Default 2.
    pub late_steps: u32,
    /// The writer damps if the runtime has given no command for this long `[s]`. Default 0.02: it then hangs or is dead.
    pub command_age_s: f64,
    /// While the computer does not run the writer or the thinking thread for a moment, that thread receives nothing. Up to this long such a
    /// pause is not taken for silence of the other thread or of the robot `[s]`; 0: it is. Default 0.05: the robot holds its last targets
    /// meanwhile, and with such a pause every 1.3 s no match of 50 kicks in lockstep is stopped (`paid robot sim --pause-ms 50`; with 100
    /// ms all are).
    pub forgiven_pause_s: f64,
    /// Damps if the writer has sent nothing for this long while the joints are under control `[s]`: it hangs or is dead. Default 0.05: a
    /// command was 26 ms late once in an hour without real-time priority.
    pub writer_age_s: f64,
    /// Damps if the remote is silent for this long `[s]`. Default 0.5.
    pub remote_s: f64,
    /// False: runs without a remote, stopped by Ctrl-C only. For simulations.
    pub remote_required: bool,
    /// With odometry older than this no kick begins, and one that has begun continues without looking `[s]`. Default 0.1: ten poses.
    pub odometry_age_s: f64,
    /// The same for the last image with the ball `[s]`. Default 1: in most of a run-up the ball is below the image.
    pub ball_age_s: f64,
    /// The ball must have been seen this recently for a kick to begin `[s]`. Default 0.2: three images.
    pub ball_fresh_s: f64,
    /// This many images in a row must have shown the ball in one place for a kick to begin. Default 20: what kicks of training and of
    /// matches in the evaluation begin with (`eyes.first_look`). With fewer, noise passes for a rolling ball, and a ball that was just put
    /// down for the last one.
    pub ball_looks: u32,
    /// Standard deviation of the ball's speed on each axis with which a kick may begin `[m/s]`. Default 0.05: half a hand in a second.
    pub ball_speed_known_m_s: f64,
    /// Where the ball must be at the strike, ahead of the torso `[m]`. Default 0.4 to 2.1: the paper's effective workspace, and a little.
    pub reach_ahead_m: [f64; 2],
    /// The same to the left `[m]`. Default -1.1 to 1.1.
    pub reach_left_m: [f64; 2],
    /// The goal may be this far off straight ahead `[rad]`. Default 0.6.
    pub goal_bearing_rad: f64,
    /// An action beyond this damps. Default 30: trained policies stay below 10.
    pub action: f64,
    /// A target of the policy may lie this far beyond the joint's soft range, as a share of the angle at which the motor gives all its
    /// torque (effort over stiffness); what is farther out is brought back. Default 2: training clamps nothing, its joints are soft, and a
    /// policy presses the ground with targets far outside of an ankle's range, where torque and the stop limit what comes of it. In 8
    /// matches of 11 in lockstep (`policies/demo` seeds 0 to 4, an earlier policy 0 to 2) targets lay 1.46 beyond at most (ankles; up to
    /// 2.6 rad), 1.71 in a kick that failed.
    pub target_beyond: f64,
    /// A target of the policy may move this much from one policy step to the next, in the same unit. Default 2.5: in these matches they
    /// moved by 1.82 at most; 2 is from all the torque one way to all of it the other way.
    pub target_step: f64,
    /// After a change of state targets move from the measured pose at most so fast `[rad/s]` ... Default 12: a step of 0.2 rad takes a
    /// policy step.
    pub switch_rad_s: f64,
    /// The same from the begin of a kick that follows a kick, from the last target, whose distance from the pose is what holds the robot.
    /// Default 60: motion and memory change at once, and first targets jumped by up to 0.85 rad a policy step. At 60 rad/s, 1.2 rad a policy
    /// step, `policies/demo` plays matches of 50 as it did without; at 30 and 12 it fell more often (seeds 0 to 5 and 0 to 7).
    pub kick_rad_s: f64,
    /// Both for this long `[s]`. Default 0.1.
    pub switch_s: f64,
    /// Damping of the passive and the damped robot `[N m s/rad]`. Default 3: the vendor's.
    pub passive_kd: f32,
    /// Time of the ramp to the standing pose `[s]`. Default 3: the vendor's.
    pub stand_up_s: f64,
    /// Stiffness of the standing robot's joints relative to the policy's ... Default 10: in simulation it falls within two seconds at 5,
    /// since the ankles give way.
    pub stand_stiffness: f64,
    /// ... but no more than this `[N m/rad]`. Default 300.
    pub stand_stiffness_most: f64,
    /// The same for damping, relative to the policy's. Default 4.
    pub stand_damping: f64,
    /// The robot stands still whose joints' speeds have a root mean square below this `[rad/s]` ... Default 0.5, as in matches of the evaluation.
    pub still_joint_rad_s: f64,
    /// ... for this long `[s]`. Default 0.5.
    pub still_s: f64,
    /// After the clip's end the robot is ready after this long at the latest `[s]`. Default 3.
    pub settle_s: f64,
    /// True: after a kick the policy keeps holding the clip's last pose until the next one. False: the robot is brought to the standing
    /// pose by a ramp.
    pub policy_holds: bool,
    /// For this long it sends nothing and only listens for another program's commands `[s]`. Default 1: the vendor's controllers send 500
    /// times a second.
    pub listen_s: f64,
    /// Refuses to stand up when tilted by more `[rad]`. Default 0.35.
    pub start_tilt_rad: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            standing: Envelope { tilt_rad: 1.0, gyro_rad_s: 6.0, speed_share: 0.5 },
            kicking: Envelope { tilt_rad: 1.0, gyro_rad_s: 15.0, speed_share: 1.85 },
            range_margin_rad: 0.3,
            torque_share: 1.3,
            winding_c: 120,
            casing_c: 85,
            battery_percent: 20.0,
            state_gap_s: 0.02,
            crc_errors: 3,
            check_crc: true,
            late_s: 0.01,
            late_steps: 2,
            command_age_s: 0.02,
            forgiven_pause_s: 0.05,
            writer_age_s: 0.05,
            remote_s: 0.5,
            remote_required: true,
            odometry_age_s: 0.1,
            ball_age_s: 1.0,
            ball_fresh_s: 0.2,
            ball_looks: 20,
            ball_speed_known_m_s: 0.05,
            reach_ahead_m: [0.4, 2.1],
            reach_left_m: [-1.1, 1.1],
            goal_bearing_rad: 0.6,
            action: 30.0,
            target_beyond: 2.0,
            target_step: 2.5,
            switch_rad_s: 12.0,
            kick_rad_s: 60.0,
            switch_s: 0.1,
            passive_kd: 3.0,
            stand_up_s: 3.0,
            stand_stiffness: 10.0,
            stand_stiffness_most: 300.0,
            stand_damping: 4.0,
            still_joint_rad_s: 0.5,
            still_s: 0.5,
            settle_s: 3.0,
            policy_holds: true,
            listen_s: 1.0,
            start_tilt_rad: 0.35,
        }
    }
}

impl Limits {
    /// Reads a TOML file; keys that it leaves out keep their defaults.
    ///
    /// # Errors
    /// If the file is missing, is no TOML, has an unknown key or a value out of range.
    pub fn read(path: &Path) -> Result<Self, DeployError> {
        let fail = |message: String| DeployError::Limits { file: path.to_owned(), message };
        let text = std::fs::read_to_string(path).map_err(|e| fail(e.to_string()))?;
        let limits: Self = toml::from_str(&text).map_err(|e| fail(e.to_string().trim_end().to_owned()))?;
        limits.check().map_err(fail)?;
        Ok(limits)
    }

    /// A policy's target of joint `j` (model order) within its limits, after the target `before` `[rad]`.
    pub(crate) fn target(&self, player: &Player, j: usize, before: f64, target: f64) -> f64 {
        let control = &player.control;
        let whole = player.model.joints[j].effort_limit / control.stiffness[j];
        let [lo, hi] = control.soft_range[j];
        let (beyond, step) = (self.target_beyond * whole, self.target_step * whole);
        target.clamp(before - step, before + step).clamp(lo - beyond, hi + beyond)
    }

    /// Checks that every limit limits.
    ///
    /// # Errors
    /// A sentence that names the key.
    pub fn check(&self) -> Result<(), String> {
        let positive = [
            ("standing.tilt_rad", self.standing.tilt_rad, 2.0),
            ("standing.gyro_rad_s", self.standing.gyro_rad_s, 30.0),
            ("standing.speed_share", self.standing.speed_share, 2.0),
            ("kicking.tilt_rad", self.kicking.tilt_rad, 2.0),
            ("kicking.gyro_rad_s", self.kicking.gyro_rad_s, 30.0),
            ("kicking.speed_share", self.kicking.speed_share, 2.0),
            ("torque_share", self.torque_share, 2.0),
            ("state_gap_s", self.state_gap_s, 0.1),
            ("late_s", self.late_s, 0.1),
            ("command_age_s", self.command_age_s, 0.1),
            ("writer_age_s", self.writer_age_s, 0.5),
            ("remote_s", self.remote_s, 5.0),
            ("odometry_age_s", self.odometry_age_s, 1.0),
            ("ball_age_s", self.ball_age_s, 5.0),
            ("ball_fresh_s", self.ball_fresh_s, 2.0),
            ("ball_speed_known_m_s", self.ball_speed_known_m_s, 1.0),
            ("goal_bearing_rad", self.goal_bearing_rad, 3.2),
            ("action", self.action, 100.0),
            ("target_step", self.target_step, 10.0),
            ("switch_rad_s", self.switch_rad_s, 100.0),
            ("kick_rad_s", self.kick_rad_s, 100.0),
            ("passive_kd", f64::from(self.passive_kd), 10.0),
            ("stand_up_s", self.stand_up_s, 30.0),
            ("stand_stiffness", self.stand_stiffness, 20.0),
            ("stand_stiffness_most", self.stand_stiffness_most, 500.0),
            ("stand_damping", self.stand_damping, 10.0),
            ("still_joint_rad_s", self.still_joint_rad_s, 10.0),
            ("still_s", self.still_s, 10.0),
            ("settle_s", self.settle_s, 60.0),
            ("start_tilt_rad", self.start_tilt_rad, 1.0),
        ];
        for (key, value, most) in positive {
            if !(value > 0.0 && value <= most) {
                return Err(format!("'{key}': expected a number above 0 and up to {most}, found {value}"));
            }
        }
        let from_zero = [
            ("range_margin_rad", self.range_margin_rad, 0.5),
            ("forgiven_pause_s", self.forgiven_pause_s, 0.1),
            ("switch_s", self.switch_s, 5.0),
            ("listen_s", self.listen_s, 60.0),
            ("target_beyond", self.target_beyond, 10.0),
            ("battery_percent", self.battery_percent, 100.0),
        ];
        for (key, value, most) in from_zero {
            if !(0.0..=most).contains(&value) {
                return Err(format!("'{key}': expected 0 to {most}, found {value}"));
            }
        }
        for (key, [lo, hi]) in [("reach_ahead_m", self.reach_ahead_m), ("reach_left_m", self.reach_left_m)] {
            if !(lo < hi && lo >= -5.0 && hi <= 5.0) {
                return Err(format!("'{key}': expected [lo, hi] within 5 m, found [{lo}, {hi}]"));
            }
        }
        if self.ball_looks > 200 {
            return Err(format!("'ball_looks': expected up to 200, found {}", self.ball_looks));
        }
        if !(1..=10).contains(&self.crc_errors) || !(1..=10).contains(&self.late_steps) {
            return Err("'crc_errors', 'late_steps': expected 1 to 10".to_owned());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_changes_what_it_names_and_nothing_else() {
        let dir = tempfile::tempdir().expect("dir");
        let path = dir.path().join("limits.toml");
        std::fs::write(&path, "state_gap_s = 0.03\n").expect("write");
        let limits = Limits::read(&path).expect("limits");
        assert_eq!(limits, Limits { state_gap_s: 0.03, ..Limits::default() });
    }

    #[test]
    fn an_unknown_key_and_a_limit_without_effect_are_refused() {
        let dir = tempfile::tempdir().expect("dir");
        let path = dir.path().join("limits.toml");
        for (text, expected) in [
            ("state_gab_s = 0.03\n", "state_gab_s"),
            ("state_gap_s = 10.0\n", "'state_gap_s': expected a number above 0 and up to 0.1, found 10"),
            ("[kicking]\ntilt_rad = nan\ngyro_rad_s = 1.0\nspeed_share = 1.0\n", "'kicking.tilt_rad'"),
        ] {
            std::fs::write(&path, text).expect("write");
            let error = Limits::read(&path).expect_err(text).to_string();
            assert!(error.contains(expected) && error.contains("limits.toml"), "{error}");
        }
    }
}
