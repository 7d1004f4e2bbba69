//! Faults, one after another, each several times: how soon the robot is damped, and whether it stays so.

use std::fmt::Write as _;
use std::sync::Arc;

use paid_lanes::stats::quantile;
use paid_runtime::wire::LowCmd;
use paid_runtime::{Limits, Player, State};

use crate::TwinError;
use crate::faults::Fault;
use crate::lockstep::{Lockstep, LockstepOptions};

/// What a drill of one fault found.
#[derive(Clone, Debug)]
pub struct DrillRow {
    /// The fault.
    pub fault: Fault,
    /// Time from the fault to the first damping command at the robot `[ms]`, or to the robot's own stop; a trial each. Infinite where
    /// nothing happened within a second.
    pub reactions_ms: Vec<f64>,
    /// What it has to be `[ms]`.
    pub limit_ms: f64,
    /// True if every command of the next second was damping, and the joints came to rest.
    pub held: bool,
    /// The runtime's message about the last one.
    pub said: String,
}

impl DrillRow {
    /// Median reaction `[ms]`.
    pub fn median_ms(&self) -> f64 {
        quantile(&mut self.reactions_ms.clone(), 0.5).unwrap_or(f64::NAN)
    }
    /// Worst reaction `[ms]`.
    pub fn worst_ms(&self) -> f64 {
        self.reactions_ms.iter().fold(0.0, |worst, x| worst.max(*x))
    }
    /// True if every trial was within the limit, and damping held.
    pub fn passed(&self) -> bool {
        self.held && self.worst_ms() <= self.limit_ms
    }
}

/// What a drill found.
#[derive(Clone, Debug)]
pub struct DrillReport {
    /// Fault by fault.
    pub rows: Vec<DrillRow>,
}

impl DrillReport {
    /// True if all passed.
    pub fn passed(&self) -> bool {
        self.rows.iter().all(DrillRow::passed)
    }

    /// The table.
    pub fn table(&self) -> String {
        let mut out = format!(
            "{:<34} {:>7} {:>9} {:>9} {:>9}  {:<6} said\n",
            "fault", "trials", "median ms", "worst ms", "limit ms", "held"
        );
        for row in &self.rows {
            let _ = writeln!(
                out,
                "{:<34} {:>7} {:>9.0} {:>9.0} {:>9.0}  {:<6} {}",
                row.fault.name(),
                row.reactions_ms.len(),
                row.median_ms(),
                row.worst_ms(),
                row.limit_ms,
                if row.held { "yes" } else { "NO" },
                row.said
            );
        }
        let passed = self.rows.iter().filter(|row| row.passed()).count();
        let _ = writeln!(out, "{passed} of {} passed", self.rows.len());
        out
    }
}

impl Fault {
    /// The longest reaction that is right `[ms]`: a state's period, two for the way there and back, and what the limits allow.
    fn limit_ms(self, limits: &Limits) -> f64 {
        let on_sight = 6.0;
        on_sight
            + 1e3
                * match self {
                    Self::Silence | Self::Frozen => limits.state_gap_s,
                    Self::Checksum => 0.002 * f64::from(limits.crc_errors),
                    Self::RemoteOff => limits.remote_s,
                    Self::Hang => limits.command_age_s,
                    Self::Late => 0.02 * f64::from(limits.late_steps + 1),
                    // The next policy step.
                    Self::ActionNotFinite | Self::ActionHuge => 0.02,
                    Self::NoOdometry => limits.odometry_age_s + 0.02,
                    Self::NoBall => limits.ball_age_s + 0.1,
                    Self::Kill => crate::VirtualG1::TIMEOUT_US as f64 * 1e-6,
                    _ => 0.0,
                }
    }

    /// True if the fault needs a kick that has begun.
    fn while_kicking(self) -> bool {
        matches!(
            self,
            Self::ActionNotFinite
                | Self::ActionHuge
                | Self::NoOdometry
                | Self::NoBall
                | Self::SpinInKick
                | Self::JointSpeedInKick
        )
    }

    /// True if the kick continues, without looking.
    fn goes_on(self) -> bool {
        matches!(self, Self::NoOdometry | Self::NoBall)
    }
}

/// Drills these faults on the gantry, each `trials` times at other moments, in simulated time.
///
/// # Errors
/// If MuJoCo is missing or the robot cannot be made ready.
pub fn drill(
    player: &Arc<Player>,
    limits: &Limits,
    faults: &[Fault],
    trials: usize,
    mut told: impl FnMut(&DrillRow),
) -> Result<DrillReport, TwinError> {
    // A short begin: the drill is not about standing up.
    let limits = Limits { stand_up_s: 0.3, listen_s: 0.0, ..limits.clone() };
    let mut rows = Vec::new();
    for &fault in faults {
        let mut row = DrillRow {
            fault,
            reactions_ms: Vec::new(),
            limit_ms: fault.limit_ms(&limits),
            held: true,
            said: String::new(),
        };
        for trial in 0..trials {
            let (reaction, held, said) = trial_of(player, &limits, fault, trial)?;
            row.reactions_ms.push(reaction);
            row.held &= held;
            row.said = said;
        }
        told(&row);
        rows.push(row);
    }
    Ok(DrillReport { rows })
}

/// A policy that gives the same number for every action.
fn spoiled(player: &Player, with: f32) -> Arc<Player> {
    let mut player = player.clone();
    if let Some(last) = player.policy.net.mlp.last() {
        let bias = last.bias.clone();
        Arc::make_mut(&mut player.policy).params[bias].fill(with);
    }
    Arc::new(player)
}

/// True if a command is nothing but damping.
fn is_damping(command: &LowCmd, joints: usize) -> bool {
    command.motors[..joints].iter().all(|m| m.mode == 1 && m.kp == 0.0 && m.tau == 0.0 && m.kd > 0.0)
}

fn trial_of(
    player: &Arc<Player>,
    limits: &Limits,
    fault: Fault,
    trial: usize,
) -> Result<(f64, bool, String), TwinError> {
    let joints = player.joints();
    let player = match fault {
        Fault::ActionNotFinite => &spoiled(player, f32::NAN),
        Fault::ActionHuge => &spoiled(player, 1e4),
        _ => player,
    };
    let options =
        LockstepOptions { limits: limits.clone(), seed: trial as u64, ..LockstepOptions::default() };
    let mut step = Lockstep::new(player, &options)?;
    step.make_ready(false)?;
    if fault.while_kicking() {
        step.robot.place_ball([1.2, 0.0], [0.0; 2]);
    }
    // Another moment of the control period in every trial.
    step.run_until(0.002 * ((trial * 7) % 10) as f64, |_| false)?;
    let kicks = |s: &Lockstep| s.runtime().kicks() > 0;
    if fault.while_kicking() && !kicks(&step) && !step.run_until(3.0, kicks)? {
        return Err(TwinError::refused(format!("the drill's kick: waits for {}", step.runtime().waiting())));
    }
    let mut from_us = step.robot.now_us();
    let told = step.events().len();
    if !matches!(fault, Fault::ActionNotFinite | Fault::ActionHuge) {
        step.inject(fault);
    }
    if fault.goes_on() {
        let blind = |s: &Lockstep| s.events().iter().any(|e| e.reason.starts_with("finishes without"));
        let seen = step.run_until(2.0, blind)?;
        let reaction = if seen { (step.robot.now_us() - from_us) as f64 * 1e-3 } else { f64::INFINITY };
        let said = step.events().last().map(|e| e.reason.clone()).unwrap_or_default();
        // It continues to the end of the motion.
        let ended = step.run_until(20.0, |s| s.runtime().state() != State::Kick)?;
        return Ok((reaction, ended && step.runtime().state() == State::Settle, said));
    }
    match fault {
        // The fault is there once the limit is passed, not when the gantry begins to move.
        Fault::Tilt => {
            let limit = limits.standing.tilt_rad;
            step.run_until(2.0, |s| s.truth().base.rot.0[2][2].acos() > limit)?;
            from_us = step.robot.now_us() - 2_000;
        }
        Fault::Spin => from_us = step.robot.now_us(),
        _ => {}
    }
    let damped = |s: &Lockstep| {
        if fault == Fault::Kill { s.robot.timed_out() } else { is_damping(s.robot.command(), joints) }
    };
    let seen = damped(&step) || step.run_until(1.0, damped)?;
    let reaction = if seen { (step.robot.now_us() - from_us) as f64 * 1e-3 } else { f64::INFINITY };
    step.robot.set_mount(crate::Mount::Gantry { pitch_rad_s: 0.0 });
    let mut held = seen;
    step.run_until(1.0, |s| {
        held &= damped(s);
        false
    })?;
    let speeds = &step.robot.truth().joint_vel;
    let rest = (speeds.iter().map(|v| v * v).sum::<f64>() / joints as f64).sqrt();
    let said = if fault == Fault::Kill {
        "the robot's own timeout".to_owned()
    } else if fault == Fault::Hang {
        "the writer's watchdog".to_owned()
    } else {
        step.events()[told.saturating_sub(1)..].last().map(|e| e.reason.clone()).unwrap_or_default()
    };
    Ok((reaction, held && rest < 1.0, said))
}
