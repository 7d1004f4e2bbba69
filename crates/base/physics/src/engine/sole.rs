//! One point of a sole on the ground.

use paid_lanes::{Mat3, Real, Vec3};

use super::block::Block;
use super::foot::packed;
use super::spatial::Motion;

/// One sole point. Vectors in the contact frame are (t1, t2, n).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sole<V> {
    /// Contact point relative to the base's origin.
    pub point: Vec3<V>,
    /// Contact frame: columns t1, t2, n in world axes. Not read on the plane.
    pub frame: Mat3<V>,
    /// Foot velocity per impulse at the point: component by frame axis.
    pub response: [[V; 3]; 6],
    pub block: Block<V>,
    pub target: V,
    /// Sliding velocity that a soft contact leaves, along t1 and t2; read where some lane is soft.
    pub slide: [V; 2],
    pub on: V,
    pub impulse: [V; 3],
}

impl<V: Real> Sole<V> {
    pub fn new() -> Self {
        let z = V::zero();
        Self {
            point: Vec3::zero(),
            frame: Mat3::identity(),
            response: [[z; 3]; 6],
            block: Block::zero(),
            target: z,
            slide: [z; 2],
            on: z,
            impulse: [z; 3],
        }
    }

    /// Builds the response at `point` from the foot's inverse inertia.
    #[inline(always)]
    pub fn build_response<const PLANE: bool>(&mut self, inverse: &[V; 21]) {
        let p = self.point.0;
        for r in 0..6 {
            let moment = Vec3([inverse[packed(r, 0)], inverse[packed(r, 1)], inverse[packed(r, 2)]]);
            let force = Vec3([inverse[packed(r, 3)], inverse[packed(r, 4)], inverse[packed(r, 5)]]);
            // Row times (p x d, d) for the world axes d.
            let row = moment.cross_add(Vec3(p), force);
            self.response[r] = if PLANE { row.0 } else { self.frame.tr_mul_vec(row).0 };
        }
        let mut k = [[V::zero(); 3]; 3];
        for c in 0..3 {
            let g = &self.response;
            let column = Motion::from_array([g[0][c], g[1][c], g[2][c], g[3][c], g[4][c], g[5][c]]);
            k[c] = self.in_frame::<PLANE>(column.at(self.point));
        }
        self.block = Block::new([k[0][0], k[1][1], k[2][2], k[1][0], k[2][0], k[2][1]]);
    }

    #[inline(always)]
    pub fn in_frame<const PLANE: bool>(&self, v: Vec3<V>) -> [V; 3] {
        if PLANE { v.0 } else { self.frame.tr_mul_vec(v).0 }
    }

    /// The impulse in world axes.
    #[inline(always)]
    pub fn world_impulse<const PLANE: bool>(&self) -> Vec3<V> {
        if PLANE { Vec3(self.impulse) } else { self.frame.mul_vec(Vec3(self.impulse)) }
    }
}
