//! Levenberg and Marquardt's iteration over all frames at once.

use super::problem::{Problem, moved};
use super::rows::Band;
use crate::generate::Pose;

/// Steps at each stress of the conditions.
const STEPS: [(f64, usize); 4] = [(0.1, 50), (0.3, 40), (1.0, 40), (1.0, 30)];
/// The iteration ends when the cost falls by less than this share.
const ENOUGH: f64 = 1e-3;

/// The best poses, from the plan's, and the number of steps.
pub(super) fn solve(problem: &mut Problem<'_>, start: &[Pose]) -> (Vec<Pose>, usize) {
    let n = problem.figure.n;
    let mut poses = start.to_vec();
    let mut band = Band::new(n * poses.len(), 3 * n);
    let mut steps = 0;
    for (stress, most) in STEPS {
        problem.set(stress, &poses);
        let mut damping = 1e-3;
        let mut slow = 0;
        let mut cost = problem.cost(&poses, None);
        for _ in 0..most {
            steps += 1;
            let mut fell = 0.0;
            // A step that makes things worse is taken back and tried shorter.
            for _ in 0..6 {
                problem.cost(&poses, Some(&mut band));
                band.damp(damping, 1e-6);
                if let Some(step) = band.solve() {
                    let tried: Vec<Pose> =
                        poses.iter().zip(step.chunks_exact(n)).map(|(p, s)| moved(p, s)).collect();
                    let now = problem.cost(&tried, None);
                    if now < cost {
                        fell = (cost - now) / cost;
                        (poses, cost) = (tried, now);
                        damping = (damping * 0.3).max(1e-7);
                        break;
                    }
                }
                damping *= 10.0;
            }
            slow = if fell < ENOUGH { slow + 1 } else { 0 };
            if slow >= 3 || fell == 0.0 {
                break;
            }
        }
    }
    problem.set(1.0, &poses);
    (poses, steps)
}
