//! Random boxes on endless ground, without a list of them.

use nalgebra::Vector3;
use paid_lanes::rng::Rng;

use super::scene::Shape;

/// Every square of this size holds one box `[m]`.
const SQUARE_M: f64 = 8.0;
/// A box's middle is off the middle of its square by this much at most, along x and y `[m]`.
const OFF_M: f64 = 1.6;
/// Half of a box's length and width, least and most `[m]`.
const HALF_M: [(f64, f64); 2] = [(0.8, 1.5), (0.3, 0.8)];
/// Height of a box, least and most `[m]`.
const HEIGHT_M: (f64, f64) = (1.0, 3.0);
/// Beyond this way along the ground no box is looked for: the sensor does not reach farther `[m]`.
const REACH_M: f64 = 45.0;

/// One box in every square of the ground, turned anyhow. The same seed gives the same boxes everywhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Boxes {
    pub seed: u64,
}

impl Boxes {
    /// The box of a square.
    fn of(self, square: [i32; 2]) -> Shape {
        let [x, y] = square.map(i32::cast_unsigned);
        let mut rng = Rng::new(self.seed, x, y);
        let at = square.map(|i| (f64::from(i) + 0.5) * SQUARE_M + rng.uniform(-OFF_M, OFF_M));
        let [length, width] = HALF_M.map(|(low, high)| rng.uniform(low, high));
        let height = 0.5 * rng.uniform(HEIGHT_M.0, HEIGHT_M.1);
        let (sine, cosine) = rng.uniform(0.0, core::f64::consts::PI).sin_cos();
        Shape::Block {
            center: Vector3::new(at[0], at[1], height),
            half: Vector3::new(length, width, height),
            turn: (cosine, sine),
        }
    }

    /// Distance `[m]` along the unit vector `ray` from `origin` to the first box.
    pub fn hit(self, origin: &Vector3<f64>, ray: &Vector3<f64>) -> Option<f64> {
        let along = ray.xy().norm();
        if along < 1e-6 {
            return None;
        }
        // From square to square: a box lies within its own, so the first that is hit is the nearest.
        let farthest = REACH_M / along;
        let mut square = [0, 1].map(|k| (origin[k] / SQUARE_M).floor() as i32);
        let step = [0, 1].map(|k| if ray[k] < 0.0 { -1 } else { 1 });
        let width = [0, 1].map(|k| SQUARE_M / ray[k].abs().max(1e-12));
        let mut next = [0, 1].map(|k| {
            let border = f64::from(square[k] + i32::from(step[k] > 0)) * SQUARE_M;
            if ray[k].abs() < 1e-12 { f64::INFINITY } else { (border - origin[k]) / ray[k] }
        });
        loop {
            if let Some(range) = self.of(square).hit(origin, ray, 0.0) {
                return Some(range);
            }
            let k = usize::from(next[1] < next[0]);
            if next[k] > farthest {
                return None;
            }
            square[k] += step[k];
            next[k] += width[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nearest of all boxes within 6 squares, one by one.
    fn by_hand(boxes: Boxes, origin: &Vector3<f64>, ray: &Vector3<f64>) -> Option<f64> {
        let at = [0, 1].map(|k| (origin[k] / SQUARE_M).floor() as i32);
        (-6..=6)
            .flat_map(|i| (-6..=6).map(move |j| [at[0] + i, at[1] + j]))
            .filter_map(|square| boxes.of(square).hit(origin, ray, 0.0))
            .reduce(f64::min)
            .filter(|range| range * ray.xy().norm() < REACH_M - SQUARE_M)
    }

    #[test]
    fn the_walk_from_square_to_square_finds_the_nearest_box() {
        let boxes = Boxes { seed: 3 };
        let mut rng = Rng::new(1, 0, 0);
        let mut found = 0;
        for _ in 0..1000 {
            let mut uniform = |span: f64| rng.uniform(-span, span);
            let origin = Vector3::new(uniform(200.0), uniform(200.0), 1.2);
            let ray = Vector3::new(uniform(1.0), uniform(1.0), uniform(0.1)).normalize();
            if let Some(expected) = by_hand(boxes, &origin, &ray) {
                assert_eq!(boxes.hit(&origin, &ray), Some(expected), "from {origin} along {ray}");
                found += 1;
            }
        }
        assert!(found > 300, "{found} rays met a box");
    }

    #[test]
    fn boxes_stay_in_their_squares() {
        for square in [[0, 0], [-1, 5], [40, -17]] {
            let Shape::Block { center, half, .. } = (Boxes { seed: 9 }).of(square) else {
                panic!("a box");
            };
            let corner = half.xy().norm();
            for k in 0..2 {
                let low = f64::from(square[k]) * SQUARE_M;
                assert!(low < center[k] - corner && center[k] + corner < low + SQUARE_M, "{square:?}");
            }
        }
    }
}
