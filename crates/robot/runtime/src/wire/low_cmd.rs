//! The command to the robot: `unitree_hg::msg::dds_::LowCmd_`.

use super::MOTORS;
use super::walk::{Message, Walk, forms};

/// A motor's command. The motor applies `kp (q - angle) + kd (dq - speed) + tau`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorCmd {
    /// 1: enabled.
    pub mode: u8,
    /// Angle `[rad]`.
    pub q: f32,
    /// Speed `[rad/s]`.
    pub dq: f32,
    /// Torque in addition to the controller's `[N m]`.
    pub tau: f32,
    /// Stiffness `[N m/rad]`.
    pub kp: f32,
    /// Damping `[N m s/rad]`.
    pub kd: f32,
    /// Not used.
    pub reserve: u32,
}

impl MotorCmd {
    /// Nothing but damping `kd` `[N m s/rad]`.
    pub fn damping(kd: f32) -> Self {
        Self { mode: 1, kd, ..Self::default() }
    }
}

/// A command for all motors.
#[derive(Clone, Debug, PartialEq)]
pub struct LowCmd {
    /// 0: ankles and waist by pitch and roll.
    pub mode_pr: u8,
    /// The robot's own number, from its last [`super::LowState`].
    pub mode_machine: u8,
    /// Motors in the vendor's order.
    pub motors: [MotorCmd; MOTORS],
    /// Not used.
    pub reserve: [u32; 4],
    /// Checksum of everything before it, see [`LowCmd::sealed`].
    pub crc: u32,
}

impl Default for LowCmd {
    fn default() -> Self {
        Self { mode_pr: 0, mode_machine: 0, motors: [MotorCmd::default(); MOTORS], reserve: [0; 4], crc: 0 }
    }
}

impl Message for LowCmd {
    const NAME: &'static str = "LowCmd";
    fn walk(&mut self, w: &mut impl Walk) {
        w.u8(&mut self.mode_pr);
        w.u8(&mut self.mode_machine);
        for motor in &mut self.motors {
            w.group();
            w.u8(&mut motor.mode);
            for value in [&mut motor.q, &mut motor.dq, &mut motor.tau, &mut motor.kp, &mut motor.kd] {
                w.f32(value);
            }
            w.u32(&mut motor.reserve);
        }
        w.u32s(&mut self.reserve);
        w.u32(&mut self.crc);
    }
}

impl LowCmd {
    /// Bytes of the C struct.
    pub const C_SIZE: usize = 1004;
    /// Bytes in CDR, without the header.
    pub const CDR_SIZE: usize = 1000;

    /// Damping `kd` `[N m s/rad]` on the first `joints` motors.
    pub fn damping(mode_machine: u8, joints: usize, kd: f32) -> Self {
        let mut command = Self { mode_machine, ..Self::default() };
        for motor in command.motors.iter_mut().take(joints) {
            *motor = MotorCmd::damping(kd);
        }
        command.sealed()
    }
}

forms!(LowCmd);

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_zero_command_has_the_vendors_size_and_checksum() {
        let zero = LowCmd::default();
        assert_eq!(zero.to_c().len(), 1004);
        assert_eq!(zero.to_cdr().len(), 1000);
        assert_eq!(zero.sealed().crc, 0xFE17_2F9F);
    }

    #[test]
    fn fields_lie_where_the_c_compiler_puts_them() {
        let mut command = LowCmd { mode_pr: 1, mode_machine: 5, crc: 0xAABB_CCDD, ..LowCmd::default() };
        command.motors[1] = MotorCmd { mode: 1, q: 1.5, kd: 2.0, ..MotorCmd::default() };
        let c = command.to_c();
        assert_eq!(c[..4], [1, 5, 0, 0]);
        // The second motor begins after 4 + 28 bytes; its angle 4 later, its damping 16 after that.
        assert_eq!((c[32], &c[33..36]), (1, &[0, 0, 0][..]));
        assert_eq!(c[36..40], 1.5_f32.to_le_bytes());
        assert_eq!(c[52..56], 2.0_f32.to_le_bytes());
        assert_eq!(c[1000..], [0xDD, 0xCC, 0xBB, 0xAA]);
        // On the network the first motor's mode follows the two bytes at once, its angle is aligned.
        let cdr = command.to_cdr();
        assert_eq!((cdr[28], &cdr[32..36]), (1, &1.5_f32.to_le_bytes()[..]));
    }

    proptest! {
        #[test]
        fn any_bytes_of_the_right_length_survive_a_round_trip(
            bytes in proptest::collection::vec(any::<u8>(), LowCmd::C_SIZE),
        ) {
            let command = LowCmd::from_c(&bytes).expect("length");
            let again = LowCmd::from_cdr(&command.to_cdr()).expect("length");
            prop_assert_eq!(again.to_c(), command.to_c());
        }

        #[test]
        fn other_lengths_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..2300)) {
            let fits = (LowCmd::CDR_SIZE..=LowCmd::CDR_SIZE + 3).contains(&bytes.len());
            prop_assert_eq!(LowCmd::from_cdr(&bytes).is_ok(), fits);
            prop_assert_eq!(LowCmd::from_c(&bytes).is_ok(), bytes.len() == LowCmd::C_SIZE);
        }
    }
}
