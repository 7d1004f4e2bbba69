//! How one foot answers to impulses: its inverse operational-space inertia from half-solved unit impulses.

use paid_lanes::{Real, Vec3};

use super::articulated::BaseFactor;
use super::group::JointWork;
use super::spatial::{Force, Motion};

/// Index of element (r, c) in a packed lower triangle.
#[inline(always)]
pub(crate) fn packed(r: usize, c: usize) -> usize {
    if r >= c { r * (r + 1) / 2 + c } else { c * (c + 1) / 2 + r }
}

/// A foot's response to impulses.
#[derive(Clone, Debug)]
pub(crate) struct Foot<V> {
    /// Half-solved unit impulses: joint (base to tip) by wrench component.
    pub joints: Vec<[V; 6]>,
    /// The same at the base: row by wrench component.
    pub base: [[V; 6]; 6],
    /// Velocity per impulse, packed lower triangle.
    pub inverse: [V; 21],
    /// Velocity under way to the end of the step.
    pub vel: Motion<V>,
    /// Sum of the contact impulses.
    pub impulse: Force<V>,
    /// Coefficient of friction of the current sole: static or dynamic.
    pub friction: V,
}

impl<V: Real> Foot<V> {
    pub fn new(joints: usize) -> Self {
        let z = V::zero();
        Self {
            joints: vec![[z; 6]; joints],
            base: [[z; 6]; 6],
            inverse: [z; 21],
            vel: Motion::zero(),
            impulse: Force::zero(),
            friction: z,
        }
    }

    /// Half-solves three of the six unit impulses (moments for `first` 0, forces for 3); three at a time stay in registers.
    #[inline(always)]
    pub fn half_solve(&mut self, first: usize, work: &[JointWork<V>], factor: &BaseFactor<V>) {
        let mut p = [[V::zero(); 3]; 6];
        for c in 0..3 {
            p[first + c][c] = V::one();
        }
        for i in (0..work.len()).rev() {
            let axis = work[i].axis.array();
            let gain = &work[i].gain;
            let mut y = [V::zero(); 3];
            for c in 0..3 {
                let mut sum = axis[0] * p[0][c];
                for r in 1..6 {
                    sum = axis[r].mul_add(p[r][c], sum);
                }
                y[c] = sum;
                self.joints[i][first + c] = sum;
            }
            for r in 0..6 {
                for c in 0..3 {
                    p[r][c] = gain[r].neg_mul_add(y[c], p[r][c]);
                }
            }
        }
        for c in 0..3 {
            let mut column = [p[0][c], p[1][c], p[2][c], p[3][c], p[4][c], p[5][c]];
            factor.half_solve(&mut column);
            for r in 0..6 {
                self.base[r][first + c] = column[r];
            }
        }
    }

    /// Velocity per impulse from the half-solved columns.
    #[inline(always)]
    pub fn build_inverse(&mut self, work: &[JointWork<V>], factor: &BaseFactor<V>) {
        let mut sum = [V::zero(); 21];
        for i in 0..work.len() + 6 {
            let (y, d) = if i < work.len() {
                (&self.joints[i], work[i].inv)
            } else {
                (&self.base[i - work.len()], factor.inv[i - work.len()])
            };
            let mut n = 0;
            for r in 0..6 {
                let scaled = y[r] * d;
                for c in 0..=r {
                    sum[n] = scaled.mul_add(y[c], sum[n]);
                    n += 1;
                }
            }
        }
        self.inverse = sum;
    }

    /// Velocity at the end of the step without contacts.
    #[inline(always)]
    pub fn free_velocity(&mut self, now: Motion<V>, gyro: Vec3<V>, work: &[JointWork<V>], w: &FreeBase<V>) {
        let mut v = Motion { ang: now.ang, lin: now.lin + gyro }.array();
        for i in 0..work.len() {
            let x = work[i].torque * work[i].inv * w.dt;
            for c in 0..6 {
                v[c] = self.joints[i][c].mul_add(x, v[c]);
            }
        }
        for i in 0..6 {
            for c in 0..6 {
                v[c] = self.base[i][c].mul_add(w.scaled[i], v[c]);
            }
        }
        self.vel = Motion::from_array(v);
    }

    /// The foot's velocity changed by an impulse on it.
    #[inline(always)]
    pub fn push(&mut self, f: [V; 6]) {
        let mut v = self.vel.array();
        for r in 0..6 {
            for c in 0..6 {
                v[r] = self.inverse[packed(r, c)].mul_add(f[c], v[r]);
            }
        }
        self.vel = Motion::from_array(v);
    }
}

/// The base's half-solved free impulse, scaled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeBase<V> {
    pub scaled: [V; 6],
    pub dt: V,
}
