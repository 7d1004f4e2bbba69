//! The last hand before the robot: sends the runtime's command, or damping if the runtime gives none.

use crate::limits::Limits;
use crate::pause::Silence;
use crate::wire::LowCmd;

/// Passes commands on and watches their age.
#[derive(Clone, Debug)]
pub struct Writer {
    latest: Option<(LowCmd, u64)>,
    silence: Silence,
    limit_us: u64,
    kd: f32,
    joints: usize,
    stopped: bool,
}

impl Writer {
    /// A writer that has got nothing.
    pub fn new(limits: &Limits, joints: usize) -> Self {
        Self {
            latest: None,
            silence: Silence::new(limits),
            limit_us: (limits.command_age_s * 1e6) as u64,
            kd: limits.passive_kd,
            joints,
            stopped: false,
        }
    }

    /// Takes the runtime's command, given at `now_us` `[us]`; none while the runtime listens and another program may command the robot.
    pub fn give(&mut self, command: Option<LowCmd>, now_us: u64) {
        self.latest = command.map(|command| (command, now_us));
        self.silence.heard();
    }

    /// From now on it only damps.
    pub fn stop(&mut self) {
        self.stopped = true;
    }

    /// True once the runtime was silent for too long, or it was stopped. After that it only damps.
    pub fn stopped(&self) -> bool {
        self.stopped
    }

    /// Age of the runtime's last command at `now_us` `[us]`; none while there is none.
    pub fn age_us(&self, now_us: u64) -> Option<u64> {
        self.latest.as_ref().map(|(_, given_us)| now_us.saturating_sub(*given_us))
    }

    /// What to send at `now_us` `[us]`; nothing while the runtime wants nothing sent.
    pub fn write(&mut self, now_us: u64) -> Option<LowCmd> {
        self.silence.step(now_us);
        let (command, given_us) = self.latest.as_ref()?;
        self.stopped |= self.silence.since_us(*given_us, now_us) >= self.limit_us;
        Some(if self.stopped {
            LowCmd::damping(command.mode_machine, self.joints, self.kd)
        } else {
            command.clone()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_silent_runtime_is_replaced_by_damping_for_good() {
        let mut writer = Writer::new(&Limits::default(), 29);
        assert_eq!(writer.write(0), None);
        let mut command = LowCmd { mode_machine: 5, ..LowCmd::default() };
        command.motors[3].kp = 40.0;
        let command = command.sealed();
        writer.give(Some(command.clone()), 1000);
        for ms in 1..11 {
            assert_eq!(writer.write(2000 * ms), Some(command.clone()));
        }
        assert_eq!(writer.write(20_999), Some(command.clone()));
        assert_eq!(writer.write(21_000), Some(LowCmd::damping(5, 29, 3.0)));
        writer.give(Some(command), 22_000);
        assert_eq!(writer.write(22_000), Some(LowCmd::damping(5, 29, 3.0)), "a runtime that comes back");
    }

    #[test]
    fn a_computer_that_paused_gives_the_runtime_its_chance() {
        let mut writer = Writer::new(&Limits::default(), 29);
        let command = LowCmd { mode_machine: 5, ..LowCmd::default() }.sealed();
        writer.give(Some(command.clone()), 1000);
        assert_eq!(writer.write(2_000), Some(command.clone()));
        assert_eq!(writer.write(27_000), Some(command.clone()), "not run for 25 ms");
        for ms in [29, 31, 33, 35, 37, 39, 41, 43] {
            assert_eq!(writer.write(1000 * ms), Some(command.clone()), "{ms} ms");
        }
        assert_eq!(writer.write(45_000), Some(LowCmd::damping(5, 29, 3.0)), "and the runtime stays silent");

        let mut writer = Writer::new(&Limits::default(), 29);
        writer.give(Some(command), 1000);
        writer.write(2_000);
        assert_eq!(writer.write(60_000), Some(LowCmd::damping(5, 29, 3.0)), "too long a pause");
    }
}
