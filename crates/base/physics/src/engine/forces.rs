//! Net contact forces on the bodies, of which few are touched in a step.

use paid_lanes::{Real, Vec3};

/// Net contact force on each body over a physics step `[N]`, world axes.
#[derive(Clone, Debug)]
pub(crate) struct BodyForces<V: Real> {
    force: Vec<Vec3<V>>,
    /// Some lane's body has been touched; all others have no force.
    touched: Vec<bool>,
}

impl<V: Real> BodyForces<V> {
    /// No force on any of `bodies` bodies.
    pub fn new(bodies: usize) -> Self {
        Self { force: vec![Vec3::zero(); bodies], touched: vec![false; bodies] }
    }

    /// Takes all forces away.
    #[inline(always)]
    pub fn clear(&mut self) {
        for b in 0..self.touched.len() {
            if core::mem::take(&mut self.touched[b]) {
                self.force[b] = Vec3::zero();
            }
        }
    }

    /// Adds `force * share` on body `b`.
    #[inline(always)]
    pub fn add(&mut self, b: usize, force: Vec3<V>, share: V) {
        self.touched[b] = true;
        self.force[b] = force.scale_add(share, self.force[b]);
    }

    /// The force on body `b` in the lanes in which it has been touched.
    #[inline(always)]
    pub fn on(&self, b: usize) -> Option<Vec3<V>> {
        self.touched[b].then(|| self.force[b])
    }
}
