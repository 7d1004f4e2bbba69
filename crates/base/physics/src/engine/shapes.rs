//! Contact shapes of the bodies as capsules, and which of them may meet.

use paid_lanes::{Mat3, Scalar, Vec3};
use paid_robot::{RobotModel, Shape};

use super::error::PhysicsError;
use super::layout::Chain;
use super::solver::SOLVER;

/// A capsule (or a sphere: both ends equal) in its body's internal frame.
#[derive(Clone, Debug)]
pub(crate) struct Capsule<S> {
    pub body: usize,
    pub ends: [[S; 3]; 2],
    pub radius: S,
    /// Both ends are one.
    pub sphere: bool,
    /// Squared length of the segment, and its reciprocal (zero for a sphere).
    pub length2: S,
    pub inv_length2: S,
}

/// Two capsules that are kept apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    pub capsules: [usize; 2],
    /// Square of twice the distance of their middles beyond which they are farther apart than contacts are looked for `[m^2]`.
    pub far: f64,
}

impl Pair {
    fn new<S: Scalar>(list: &[Capsule<S>], capsules: [usize; 2]) -> Self {
        // A millimeter for the rounding of the distances in the inner loop.
        let near = SOLVER.limb_horizon_m + 0.001;
        let extent = |c: usize| list[c].length2.to_f64().sqrt() + 2.0 * list[c].radius.to_f64();
        let doubled = 2.0 * near + extent(capsules[0]) + extent(capsules[1]);
        Self { capsules, far: doubled * doubled }
    }
}

/// Two chains whose shapes are kept apart, and the shape pairs that are checked.
#[derive(Clone, Debug)]
pub(crate) struct PairGroup {
    pub chains: [usize; 2],
    pub pairs: Vec<Pair>,
}

/// All capsules, and each body's range among them.
pub(crate) type CapsuleList<S> = (Vec<Capsule<S>>, Vec<[usize; 2]>);

/// The `collision` shapes of all bodies, body after body, and each body's range in that list.
pub(crate) fn capsules<S: Scalar>(
    model: &RobotModel,
    frame: &dyn Fn(usize) -> Mat3<f64>,
) -> Result<CapsuleList<S>, PhysicsError> {
    let mut out = Vec::new();
    let mut ranges = Vec::new();
    for (b, body) in model.bodies.iter().enumerate() {
        let first = out.len();
        for geom in body.geoms.iter().filter(|g| g.class == "collision") {
            let (ends, radius) = match geom.shape {
                Shape::Sphere { center, radius } => ([center; 2], radius),
                Shape::Capsule { ends, radius } => (ends, radius),
                Shape::Box { .. } => {
                    return Err(PhysicsError::Geom {
                        body: body.name.clone(),
                        geom: geom.name.clone(),
                        problem: "the engine collides spheres and capsules; describe a box by capsules",
                    });
                }
            };
            let ends = ends.map(|e| frame(b).tr_mul_vec(Vec3(e)));
            let length2 = (ends[1] - ends[0]).norm2();
            let sphere = length2 < 1e-12;
            out.push(Capsule {
                body: b,
                ends: ends.map(|e| e.0.map(S::from_f64)),
                radius: S::from_f64(radius),
                sphere,
                length2: S::from_f64(length2),
                inv_length2: S::from_f64(if sphere { 0.0 } else { 1.0 / length2 }),
            });
        }
        ranges.push([first, out.len()]);
    }
    Ok((out, ranges))
}

/// Leg against leg with all shapes; the outer two shaped bodies of every other end chain (hands and forearms) against
/// the first shaped body of each leg (thighs).
pub(crate) fn pair_groups<S: Scalar>(
    model: &RobotModel,
    chains: &[Chain],
    legs: &[usize; 2],
    (list, ranges): (&[Capsule<S>], &[[usize; 2]]),
) -> Vec<PairGroup> {
    let shaped = |c: usize| -> Vec<usize> {
        let bodies = chains[c].first + 1..chains[c].end + 1;
        bodies.filter(|&b| ranges[b][0] < ranges[b][1]).collect()
    };
    let group = |chain_a: usize, bodies_a: &[usize], chain_b: usize, bodies_b: &[usize]| {
        let mut pairs = Vec::new();
        for &a in bodies_a {
            for &b in bodies_b {
                if model.contact_exclusions.contains(&(a.min(b), a.max(b))) {
                    continue;
                }
                for i in ranges[a][0]..ranges[a][1] {
                    pairs.extend((ranges[b][0]..ranges[b][1]).map(|j| Pair::new(list, [i, j])));
                }
            }
        }
        PairGroup { chains: [chain_a, chain_b], pairs }
    };
    let mut out = vec![group(legs[0], &shaped(legs[0]), legs[1], &shaped(legs[1]))];
    for c in 0..chains.len() {
        let is_end = !chains.iter().any(|other| other.parent == Some(c));
        if legs.contains(&c) || !is_end {
            continue;
        }
        let bodies = shaped(c);
        let outer = &bodies[bodies.len().saturating_sub(2)..];
        for &leg in legs {
            let leg_bodies = shaped(leg);
            out.push(group(c, outer, leg, &leg_bodies[..leg_bodies.len().min(1)]));
        }
    }
    out.retain(|g| !g.pairs.is_empty());
    out
}
