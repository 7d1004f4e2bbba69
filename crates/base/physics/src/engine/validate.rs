//! Accelerations without contact, for comparisons with other engines; mass matrix and bias derived from them.

use paid_lanes::{Kernel, Real};

use super::Engine;
use super::inward::{Drive, dynamics};
use super::spatial::{Force, Motion, dot6};
use super::step::Constants;

struct AccelerationKernel<'a, V: Real> {
    engine: &'a mut Engine<V>,
    group: usize,
    base_wrench: [V; 6],
    torques: &'a [V],
}

impl<V: Real> Kernel for AccelerationKernel<'_, V> {
    type Output = Vec<V>;

    #[inline(always)]
    fn run(self) -> Vec<V> {
        let Engine { scene, layout, ground, groups, work: w, .. } = self.engine;
        let g = &groups[self.group];
        let constants = Constants::new(scene, ground);
        dynamics(layout, &constants, g, w, Drive::Torques(self.torques));
        let [fx, fy, fz, mx, my, mz] = self.base_wrench;
        let bias = w.base_art.bias;
        let mut x = Force::from_array([mx, my, mz, fx, fy, fz]).plus(bias, V::c(-1.0)).array();
        w.factor.half_solve(&mut x);
        w.factor.finish(&mut x);
        let base = Motion::from_array(x);
        let linear = base.lin + g.omega.cross(g.vel);
        let mut out = Vec::with_capacity(6 + layout.links.len());
        out.extend_from_slice(&linear.0);
        out.extend_from_slice(&base.ang.0);
        for c in 0..layout.chains.len() {
            let chain = layout.chains[c];
            let mut a = chain.parent.map_or(base, |p| w.change[p]);
            for j in chain.first..chain.end {
                let joint = &w.joints[j];
                let qdd = joint.torque * joint.inv - dot6(&joint.gain, &a.array());
                a = a.plus(joint.axis, qdd);
                out.push(qdd);
            }
            w.change[c] = a;
        }
        out
    }
}

/// See [`Engine::accelerations_under`].
pub(crate) fn accelerations<V: Real>(
    engine: &mut Engine<V>,
    group: usize,
    base_wrench: [V; 6],
    torques: &[V],
) -> Vec<V> {
    V::run(AccelerationKernel { engine, group, base_wrench, torques })
}

impl<V: Real> Engine<V> {
    /// Accelerations of a group under joint torques `[N m]` (model order) alone: with gravity and armature, without contacts,
    /// controllers, joint stops, damping and friction loss. The state stays as it is.
    ///
    /// Layout: acceleration of the base's origin (world axes, 3) `[m/s^2]`, angular acceleration of the base (world axes, 3)
    /// `[rad/s^2]`, joints in model order `[rad/s^2]`.
    pub fn accelerations(&mut self, group: usize, torques: &[V]) -> Vec<V> {
        self.accelerations_under(group, [V::zero(); 6], torques)
    }

    /// [`Engine::accelerations`] with a force at the base's origin (3) `[N]` and a moment on the base (3) `[N m]`, world axes.
    pub fn accelerations_under(&mut self, group: usize, base_wrench: [V; 6], torques: &[V]) -> Vec<V> {
        assert_eq!(torques.len(), self.layout.links.len(), "one torque per joint");
        (self.kernels.accelerations)(self, group, base_wrench, torques)
    }

    /// Column `column` of the inverse mass matrix, in the layout of [`Engine::accelerations`]: the accelerations that one unit
    /// of generalized force adds.
    pub fn inverse_mass_column(&mut self, group: usize, column: usize) -> Vec<V> {
        let n = self.layout.links.len();
        let mut wrench = [V::zero(); 6];
        let mut torques = vec![V::zero(); n];
        let still = self.accelerations(group, &torques);
        if column < 6 {
            wrench[column] = V::one();
        } else {
            torques[column - 6] = V::one();
        }
        let mut out = self.accelerations_under(group, wrench, &torques);
        for (x, s) in out.iter_mut().zip(still) {
            *x -= s;
        }
        out
    }

    /// Mass matrix of one lane (armature included), rows and columns in the layout of [`Engine::accelerations`]; the inverse of
    /// [`Engine::inverse_mass_column`]'s matrix, inverted in `f64`.
    pub fn mass_matrix(&mut self, group: usize, lane: usize) -> Vec<Vec<f64>> {
        let n = self.layout.links.len() + 6;
        let inverse: Vec<Vec<f64>> = (0..n)
            .map(|c| self.inverse_mass_column(group, c).iter().map(|x| x.lane(lane)).collect())
            .collect();
        invert(inverse)
    }

    /// Generalized force that keeps all accelerations at zero (gravity, centrifugal and Coriolis terms) of one lane.
    pub fn bias(&mut self, group: usize, lane: usize) -> Vec<f64> {
        let zeros = vec![V::zero(); self.layout.links.len()];
        let still: Vec<f64> = self.accelerations(group, &zeros).iter().map(|x| x.lane(lane)).collect();
        let mass = self.mass_matrix(group, lane);
        mass.iter().map(|row| -row.iter().zip(&still).map(|(m, a)| m * a).sum::<f64>()).collect()
    }
}

/// Inverse by Gauss-Jordan elimination with row pivoting.
fn invert(mut a: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = a.len();
    for (i, row) in a.iter_mut().enumerate() {
        row.extend((0..n).map(|j| f64::from(u8::from(i == j))));
    }
    for c in 0..n {
        let pivot = (c..n).max_by(|&i, &j| a[i][c].abs().total_cmp(&a[j][c].abs())).unwrap_or(c);
        a.swap(c, pivot);
        let scale = 1.0 / a[c][c];
        for x in &mut a[c] {
            *x *= scale;
        }
        let row = a[c].clone();
        for (r, other) in a.iter_mut().enumerate() {
            if r != c {
                let k = other[c];
                for (x, y) in other.iter_mut().zip(&row) {
                    *x -= k * y;
                }
            }
        }
    }
    a.iter().map(|row| row[n..].to_vec()).collect()
}
