//! A reference motion inside a policy file, read out by frame number.

/// One clip's arrays, frame by frame at the control rate, in the contract's joint and body orders.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Name of the clip.
    pub name: String,
    /// Number of frames `T`.
    pub frames: usize,
    /// Joint angles `[T, joints]` `[rad]`.
    pub joint_pos: Vec<f32>,
    /// Joint velocities `[T, joints]` `[rad/s]`.
    pub joint_vel: Vec<f32>,
    /// Body origins in the world `[T, bodies, 3]` `[m]`.
    pub body_pos_w: Vec<f32>,
    /// Body orientations `[T, bodies, 4]`, w, x, y, z.
    pub body_quat_w: Vec<f32>,
    /// Body linear velocities in the world `[T, bodies, 3]` `[m/s]`.
    pub body_lin_vel_w: Vec<f32>,
    /// Body angular velocities in the world `[T, bodies, 3]` `[rad/s]`.
    pub body_ang_vel_w: Vec<f32>,
}

impl Reference {
    /// Output name and shape of one frame of every array, in the released order.
    pub(crate) fn shapes(joints: usize, bodies: usize) -> [(&'static str, Vec<usize>); 6] {
        [
            ("joint_pos", vec![joints]),
            ("joint_vel", vec![joints]),
            ("body_pos_w", vec![bodies, 3]),
            ("body_quat_w", vec![bodies, 4]),
            ("body_lin_vel_w", vec![bodies, 3]),
            ("body_ang_vel_w", vec![bodies, 3]),
        ]
    }

    /// Every array with its name and the shape of one frame.
    pub(crate) fn arrays(
        &self,
        joints: usize,
        bodies: usize,
    ) -> impl Iterator<Item = (&'static str, Vec<usize>, &[f32])> {
        let data: [&[f32]; 6] = [
            &self.joint_pos,
            &self.joint_vel,
            &self.body_pos_w,
            &self.body_quat_w,
            &self.body_lin_vel_w,
            &self.body_ang_vel_w,
        ];
        Self::shapes(joints, bodies).into_iter().zip(data).map(|((name, shape), data)| (name, shape, data))
    }

    /// Checks sizes and finiteness.
    ///
    /// # Errors
    /// A sentence that names the array, the expected and the found size.
    pub(crate) fn check(&self, joints: usize, bodies: usize) -> Result<(), String> {
        if self.frames == 0 {
            return Err(format!("reference '{}' has no frames", self.name));
        }
        for (name, shape, data) in self.arrays(joints, bodies) {
            let expected = self.frames * shape.iter().product::<usize>();
            if data.len() != expected {
                return Err(format!(
                    "reference '{}' {name}: expected {expected} numbers, found {}",
                    self.name,
                    data.len()
                ));
            }
            if let Some(i) = data.iter().position(|v| !v.is_finite()) {
                return Err(format!("reference '{}' {name}[{i}] is not finite", self.name));
            }
        }
        Ok(())
    }
}
