//! The robot's state message: `unitree_hg::msg::dds_::LowState_`.

use super::MOTORS;
use super::walk::{Message, Walk, forms};

/// The pelvis's inertial sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuState {
    /// Orientation of the sensor in the world: w, x, y, z. Its heading drifts.
    pub quaternion: [f32; 4],
    /// Angular velocity, sensor axes `[rad/s]`.
    pub gyroscope: [f32; 3],
    /// Acceleration without gravity's, sensor axes: +9.81 upward at rest `[m/s^2]`.
    pub accelerometer: [f32; 3],
    /// Roll, pitch, yaw `[rad]`.
    pub rpy: [f32; 3],
    /// Temperature in degrees Celsius.
    pub temperature: i16,
}

/// A motor's state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorState {
    /// Mode in force.
    pub mode: u8,
    /// Angle `[rad]`.
    pub q: f32,
    /// Speed `[rad/s]`.
    pub dq: f32,
    /// Acceleration `[rad/s^2]`.
    pub ddq: f32,
    /// Estimated torque `[N m]`.
    pub tau_est: f32,
    /// Temperatures of casing and winding in degrees Celsius.
    pub temperature: [i16; 2],
    /// Voltage.
    pub vol: f32,
    /// The vendor's.
    pub sensor: [u32; 2],
    /// The vendor's error bits.
    pub motorstate: u32,
    /// Not used.
    pub reserve: [u32; 4],
}

/// The robot's state, 500 times a second.
#[derive(Clone, Debug, PartialEq)]
pub struct LowState {
    /// Firmware.
    pub version: [u32; 2],
    /// 0: ankles and waist by pitch and roll.
    pub mode_pr: u8,
    /// 5: 29 free joints; 6: the waist is locked.
    pub mode_machine: u8,
    /// Milliseconds since the robot was switched on.
    pub tick: u32,
    /// The pelvis's inertial sensor.
    pub imu: ImuState,
    /// Motors in the vendor's order.
    pub motors: [MotorState; MOTORS],
    /// The remote's bytes, see [`super::Remote`].
    pub wireless_remote: [u8; 40],
    /// Not used.
    pub reserve: [u32; 4],
    /// Checksum of everything before it.
    pub crc: u32,
}

impl Default for LowState {
    fn default() -> Self {
        Self {
            version: [0; 2],
            mode_pr: 0,
            mode_machine: 0,
            tick: 0,
            imu: ImuState::default(),
            motors: [MotorState::default(); MOTORS],
            wireless_remote: [0; 40],
            reserve: [0; 4],
            crc: 0,
        }
    }
}

impl Message for LowState {
    const NAME: &'static str = "LowState";
    fn walk(&mut self, w: &mut impl Walk) {
        w.u32s(&mut self.version);
        w.u8(&mut self.mode_pr);
        w.u8(&mut self.mode_machine);
        w.u32(&mut self.tick);
        let imu = &mut self.imu;
        w.group();
        w.f32s(&mut imu.quaternion);
        w.f32s(&mut imu.gyroscope);
        w.f32s(&mut imu.accelerometer);
        w.f32s(&mut imu.rpy);
        w.i16(&mut imu.temperature);
        for motor in &mut self.motors {
            w.group();
            w.u8(&mut motor.mode);
            for value in [&mut motor.q, &mut motor.dq, &mut motor.ddq, &mut motor.tau_est] {
                w.f32(value);
            }
            for value in &mut motor.temperature {
                w.i16(value);
            }
            w.f32(&mut motor.vol);
            w.u32s(&mut motor.sensor);
            w.u32(&mut motor.motorstate);
            w.u32s(&mut motor.reserve);
        }
        w.group();
        for byte in &mut self.wireless_remote {
            w.u8(byte);
        }
        w.u32s(&mut self.reserve);
        w.u32(&mut self.crc);
    }
}

impl LowState {
    /// Bytes of the C struct.
    pub const C_SIZE: usize = 2092;
    /// Bytes on the network.
    pub const CDR_SIZE: usize = 2088;
}

forms!(LowState);

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn fields_lie_where_the_c_compiler_puts_them() {
        let mut state = LowState { mode_machine: 5, tick: 7, ..LowState::default() };
        state.imu.temperature = 0x0102;
        state.motors[0].mode = 1;
        state.motors[1].q = -2.5;
        state.wireless_remote[2] = 0x20;
        let c = state.to_c();
        assert_eq!((c.len(), state.to_cdr().len()), (2092, LowState::CDR_SIZE));
        assert_eq!((c[9], &c[12..16]), (5, &[7, 0, 0, 0][..]));
        assert_eq!(c[68..72], [2, 1, 0, 0], "the sensor's temperature and two bytes of padding");
        assert_eq!(c[72], 1, "the first motor");
        assert_eq!(c[132..136], (-2.5_f32).to_le_bytes(), "the second motor's angle");
        assert_eq!(c[2034], 0x20, "the remote");
    }

    proptest! {
        #[test]
        fn any_bytes_of_the_right_length_survive_a_round_trip(
            bytes in proptest::collection::vec(any::<u8>(), LowState::C_SIZE),
        ) {
            let state = LowState::from_c(&bytes).expect("length");
            let again = LowState::from_cdr(&state.to_cdr()).expect("length");
            prop_assert_eq!(again.to_c(), state.to_c());
        }

        #[test]
        fn a_flipped_byte_is_found(at in 0_usize..2088, with in 1_u8..) {
            let mut bytes = LowState { tick: 9, ..LowState::default() }.sealed().to_c();
            bytes[at] ^= with;
            let state = LowState::from_c(&bytes).expect("length");
            // Padding is not part of the message.
            let padding = [10, 11, 70, 71].contains(&at) || (72..2032).contains(&at) && (1..4).contains(&((at - 72) % 56));
            prop_assert_eq!(state.crc == state.expected_crc(), padding);
        }
    }
}
