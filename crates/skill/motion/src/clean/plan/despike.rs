//! Joints that jump.

use super::super::figure::Figure;
use crate::generate::Pose;

/// Joints that change their speed in a frame by more than this share of its limit are smoothed, over this many frames to both sides, at
/// most this many times.
const SPIKE: f64 = 0.40;
const SPIKE_REACH: usize = 3;
const SPIKE_ROUNDS: usize = 40;

/// Joints that jump from frame to frame are smoothed there and near there (weights 1, 2, 1, repeatedly), until they do not.
pub(super) fn despike(figure: &Figure<'_>, poses: &mut [Pose], fps: f64) {
    let last = poses.len() - 1;
    for (j, limit) in figure.speed_limit.iter().enumerate() {
        for _ in 0..SPIKE_ROUNDS {
            let q: Vec<f64> = poses.iter().map(|p| p.joints[j]).collect();
            let jumps = (1..last).filter(|&t| (q[t + 1] - 2.0 * q[t] + q[t - 1]).abs() * fps > SPIKE * limit);
            let mut near = vec![false; q.len()];
            for t in jumps {
                near[t.saturating_sub(SPIKE_REACH)..=(t + SPIKE_REACH).min(last)].fill(true);
            }
            if !near.contains(&true) {
                break;
            }
            for t in 1..last {
                if near[t] {
                    poses[t].joints[j] = 0.25 * (q[t - 1] + 2.0 * q[t] + q[t + 1]);
                }
            }
        }
    }
}
