//! The foot as the ball meets it: a capsule, a flat plate, or a shape between them.

use paid_lanes::{Mat3, Real, Scalar, Vec3};

use super::layout::scalars;
use super::shapes::Capsule;
use super::spatial::splat3;

/// How a foot's capsule becomes the plate of its sole, in the foot's internal frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plate<S> {
    /// Index of the capsule in the layout's list.
    pub capsule: usize,
    /// From the capsule's ends to the middles of the plate's rear and front edge.
    shift: [[S; 3]; 2],
    /// From the plate's middle to its left edge.
    left: [S; 3],
    half_width: S,
    /// The plate's rounding less the capsule's radius.
    rounding: S,
}

/// The shape of one foot in every lane, in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rounded<V> {
    /// Middles of the rear and front edges.
    pub ends: [Vec3<V>; 2],
    pub radius: V,
    /// Reciprocal squared distance of the ends.
    pub inv_length2: V,
    /// Unit vector to the left, and how far the edge is.
    left: Vec3<V>,
    half_width: V,
}

impl<S: Scalar> Plate<S> {
    /// The plate within `points` (centers and radii of a sole) for the longest capsule of a foot whose internal frame is
    /// `frame` in the body's (x ahead, y left). `None` if the foot has no capsule or less than two points.
    pub fn new(
        points: &[([S; 3], S)],
        capsules: &[Capsule<S>],
        range: [usize; 2],
        frame: &Mat3<f64>,
    ) -> Option<Self> {
        let outer = |v: [S; 3]| frame.mul_vec(Vec3(v.map(S::to_f64)));
        let length = |i: &usize| capsules[*i].length2.to_f64();
        let capsule = (range[0]..range[1]).max_by(|a, b| length(a).total_cmp(&length(b)))?;
        if capsules[capsule].sphere || points.len() < 2 {
            return None;
        }
        let centers: Vec<Vec3<f64>> = points.iter().map(|(c, _)| outer(*c)).collect();
        let n = centers.len() as f64;
        let mean = centers.iter().fold(Vec3([0.0; 3]), |sum, c| sum + *c).scale(1.0 / n);
        let extreme = |sign: f64| {
            let ahead = |c: &Vec3<f64>| sign * (c.0[0] - mean.0[0]);
            let within = centers.iter().map(ahead).filter(|x| *x > 0.0).fold(f64::INFINITY, f64::min);
            if within.is_finite() { mean.0[0] + sign * within } else { mean.0[0] }
        };
        let half_width = centers.iter().map(|c| (c.0[1] - mean.0[1]).abs()).fold(f64::INFINITY, f64::min);
        let radius = points.iter().map(|(_, r)| r.to_f64()).sum::<f64>() / n;
        let ends = capsules[capsule].ends.map(outer);
        let heel_first = if ends[0].0[0] < ends[1].0[0] { 1.0 } else { -1.0 };
        let shift = [(ends[0], -heel_first), (ends[1], heel_first)]
            .map(|(end, sign)| Vec3([extreme(sign), mean.0[1], mean.0[2]]) - end);
        let inside = |v: Vec3<f64>| scalars(frame.tr_mul_vec(v).0);
        Some(Self {
            capsule,
            shift: shift.map(inside),
            left: inside(Vec3([0.0, 1.0, 0.0])),
            half_width: S::from_f64(half_width),
            rounding: S::from_f64(radius - capsules[capsule].radius.to_f64()),
        })
    }

    /// The shape at `flatness` of the capsule with these ends in the world, for a foot that is turned by `rot`.
    #[inline(always)]
    pub fn at<V: Real<Scalar = S>>(
        &self,
        flatness: V,
        ends: [Vec3<V>; 2],
        radius: V,
        rot: &Mat3<V>,
    ) -> Rounded<V> {
        let [a, b] = [rot.mul_vec(splat3(&self.shift[0])), rot.mul_vec(splat3(&self.shift[1]))];
        let ends = [a.scale_add(flatness, ends[0]), b.scale_add(flatness, ends[1])];
        Rounded {
            ends,
            radius: V::splat(self.rounding).mul_add(flatness, radius),
            inv_length2: V::one() / (ends[1] - ends[0]).norm2(),
            left: rot.mul_vec(splat3(&self.left)),
            half_width: V::splat(self.half_width) * flatness,
        }
    }
}

impl<V: Real> Rounded<V> {
    /// The point nearest to `center` on the line or rectangle that the shape rounds.
    #[inline(always)]
    pub fn nearest(&self, center: Vec3<V>) -> Vec3<V> {
        let [a, b] = self.ends;
        let along = b - a;
        let t = ((center - a).dot(along) * self.inv_length2).clamp(V::zero(), V::one());
        let on_line = along.scale_add(t, a);
        let aside = (center - on_line).dot(self.left).clamp(-self.half_width, self.half_width);
        self.left.scale_add(aside, on_line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A foot with x ahead: a capsule of 3 cm from -0.03 to 0.10 m, and a sole 2 cm below it, wider at the toes.
    fn foot(frame: &Mat3<f64>, heel_first: bool) -> (Plate<f64>, [Vec3<f64>; 2]) {
        let inside = |v: [f64; 3]| frame.tr_mul_vec(Vec3(v)).0;
        let mut ends = [[-0.03, 0.0, 0.0], [0.1, 0.0, 0.0]];
        if !heel_first {
            ends.reverse();
        }
        let capsule = Capsule {
            body: 1,
            ends: ends.map(inside),
            radius: 0.03,
            sphere: false,
            length2: 0.0169,
            inv_length2: 1.0 / 0.0169,
        };
        let points = [[-0.05, 0.02], [-0.05, -0.02], [0.13, 0.03], [0.13, -0.03]]
            .map(|[x, y]| (inside([x, y, -0.02]), 0.01));
        (Plate::new(&points, &[capsule], [0, 1], frame).expect("a capsule and a sole"), ends.map(Vec3))
    }

    #[test]
    fn a_foot_goes_from_its_capsule_to_the_plate_within_its_sole() {
        let quarter_turn = Mat3([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        for frame in [Mat3::identity(), quarter_turn] {
            for heel_first in [true, false] {
                let (plate, ends) = foot(&frame, heel_first);
                for (flatness, center, nearest, radius) in [
                    (0.0, [0.2, 0.05, -0.02], [0.1, 0.0, 0.0], 0.03),
                    (1.0, [0.2, 0.05, -0.02], [0.13, 0.02, -0.02], 0.01),
                    (1.0, [-0.2, -0.01, 0.3], [-0.05, -0.01, -0.02], 0.01),
                    (1.0, [0.03, 0.005, 0.1], [0.03, 0.005, -0.02], 0.01),
                    (0.5, [0.2, -0.3, 0.0], [0.115, -0.01, -0.01], 0.02),
                ] {
                    let shape = plate.at(flatness, ends, 0.03, &frame);
                    let found = shape.nearest(Vec3(center));
                    assert!((found - Vec3(nearest)).norm() < 1e-12, "{flatness} {center:?}: {found:?}");
                    assert!((shape.radius - radius).abs() < 1e-12, "{flatness}: {}", shape.radius);
                }
            }
        }
    }

    #[test]
    fn a_foot_without_a_capsule_has_no_plate() {
        let points = [([0.1, 0.02, 0.0], 0.01), ([0.1, -0.02, 0.0], 0.01)];
        assert!(Plate::<f64>::new(&points, &[], [0, 0], &Mat3::identity()).is_none());
    }
}
