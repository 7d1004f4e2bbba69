//! The robot's body from its messages.

use paid_lanes::{Mat3, Quat, Vec3};

use crate::player::Player;
use crate::wire::LowState;

/// The robot's body, in the model's joint order.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    /// Joint angles `[rad]`.
    pub joint_pos: Vec<f64>,
    /// Joint speeds `[rad/s]`.
    pub joint_vel: Vec<f64>,
    /// Estimated torques `[N m]`.
    pub torque: Vec<f64>,
    /// Pelvis in the inertial sensor's world, whose heading drifts.
    pub base_rot: Mat3<f64>,
    /// Angular velocity of the pelvis in its own frame `[rad/s]`.
    pub base_ang_vel: Vec3<f64>,
    /// Highest temperatures of winding and casing, each with its joint.
    pub hottest: [(i16, usize); 2],
    /// Temperatures of each joint's winding and casing.
    pub temperature: Vec<[i16; 2]>,
}

impl Body {
    /// Nothing known.
    pub fn new(joints: usize) -> Self {
        let zeros = vec![0.0; joints];
        Self {
            joint_pos: zeros.clone(),
            joint_vel: zeros.clone(),
            torque: zeros,
            base_rot: Mat3::identity(),
            base_ang_vel: Vec3::zero(),
            hottest: [(0, 0); 2],
            temperature: vec![[0; 2]; joints],
        }
    }

    /// Takes in a state. False if a number of it is not finite, or the quaternion is none: then nothing changes.
    pub fn take(&mut self, state: &LowState, player: &Player) -> bool {
        let imu = &state.imu;
        let norm2: f32 = imu.quaternion.iter().map(|x| x * x).sum();
        let motors = || player.motors.iter().map(|&m| &state.motors[m]);
        let finite = (0.9..1.1).contains(&norm2)
            && imu.gyroscope.iter().all(|x| x.is_finite())
            && motors().all(|m| m.q.is_finite() && m.dq.is_finite() && m.tau_est.is_finite());
        if !finite {
            return false;
        }
        self.base_rot = Quat(imu.quaternion.map(f64::from)).normalize().to_mat();
        self.base_ang_vel = Vec3(imu.gyroscope.map(f64::from));
        self.hottest = [(i16::MIN, 0); 2];
        for (j, motor) in motors().enumerate() {
            self.joint_pos[j] = f64::from(motor.q);
            self.joint_vel[j] = f64::from(motor.dq);
            self.torque[j] = f64::from(motor.tau_est);
            let [casing, winding] = motor.temperature;
            self.temperature[j] = [winding, casing];
            for (hottest, found) in self.hottest.iter_mut().zip([winding, casing]) {
                if found > hottest.0 {
                    *hottest = (found, j);
                }
            }
        }
        true
    }

    /// Angle of the pelvis from upright `[rad]`.
    pub fn tilt(&self) -> f64 {
        self.base_rot.0[2][2].clamp(-1.0, 1.0).acos()
    }

    /// Root mean square of the joints' speeds `[rad/s]`.
    pub fn speed(&self) -> f64 {
        let sum: f64 = self.joint_vel.iter().map(|v| v * v).sum();
        (sum / self.joint_vel.len().max(1) as f64).sqrt()
    }
}
