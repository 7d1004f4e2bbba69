//! What a cleaning did, in numbers.

use serde::Serialize;

use super::figure::Frame;
use super::problem::Problem;
use crate::Clip;
use crate::check::{ClipReport, Verdict};
use crate::generate::Pose;

/// The largest value of a joint's share.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Peak {
    /// The value.
    pub value: f64,
    /// Its frame.
    pub frame: usize,
    /// The joint.
    pub joint: String,
}

/// What was done and what came of it. Distances are over the frames of the original that were kept, after it was put on the floor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CleanReport {
    /// The clip.
    pub name: String,
    /// Frames cut off at the beginning and the end, at the new rate.
    pub cut: [usize; 2],
    /// Frames added before and after: stand, steps, blending.
    pub added: [usize; 2],
    /// Frames with both feet in the air.
    pub flight: usize,
    /// How far the motion was moved down to the floor `[m]`.
    pub floor_m: f64,
    /// Everything takes this many times as long.
    pub slow: f64,
    /// Distance of the feet from the original, mean and largest `[m]`.
    pub feet_m: [f64; 2],
    /// Distance of the hands from the original, mean and largest `[m]`.
    pub hands_m: [f64; 2],
    /// Distance of the base from the original, mean and largest `[m]`.
    pub base_m: [f64; 2],
    /// Largest speed of the kicking foot before and after `[m/s]`.
    pub kick_speed: [f64; 2],
    /// Largest torque over its limit before and after, on rigid ground.
    pub torque: [Peak; 2],
    /// Share of joint samples beyond the torque limit before and after.
    pub torque_over: [f64; 2],
    /// Steps of the optimization.
    pub steps: usize,
    /// Time of everything `[s]`.
    pub seconds: f64,
    /// Why the result is not a pass, in plain sentences; empty if it is.
    pub reasons: Vec<String>,
    /// What was lost that no check sees, in plain sentences.
    pub warnings: Vec<String>,
    /// Check of the input.
    pub before: ClipReport,
    /// Check of the result.
    pub after: ClipReport,
}

impl CleanReport {
    pub(super) fn new(
        problem: &Problem<'_>,
        original: &Clip,
        poses: &[Pose],
        before: ClipReport,
        after: ClipReport,
    ) -> Self {
        let (figure, plan) = (problem.figure, problem.plan);
        let kept = plan.added[0]..poses.len() - plan.added[1];
        let frames =
            |poses: &[Pose]| -> Vec<Frame> { poses[kept.clone()].iter().map(|p| figure.frame(p)).collect() };
        let pairs: Vec<(Frame, Frame)> = frames(&plan.poses).into_iter().zip(frames(poses)).collect();
        let distance = |bodies: &[usize]| {
            let all: Vec<f64> = pairs
                .iter()
                .flat_map(|(a, b)| bodies.iter().map(|&i| (a.pos[i] - b.pos[i]).norm()))
                .collect();
            [all.iter().sum::<f64>() / all.len().max(1) as f64, all.iter().copied().fold(0.0, f64::max)]
        };
        let shares = [&plan.poses[..], poses].map(|poses| problem.torque_shares(poses));
        let peak = |shares: &[Vec<f64>]| {
            let mut best = Peak { value: 0.0, frame: 0, joint: String::new() };
            for (frame, row) in shares.iter().enumerate() {
                for (j, &value) in row.iter().enumerate() {
                    if value > best.value {
                        best = Peak { value, frame, joint: figure.model.joints[j].name.clone() };
                    }
                }
            }
            best
        };
        let over = |shares: &[Vec<f64>]| {
            let all = shares.iter().flatten();
            all.clone().filter(|s| **s > 1.0).count() as f64 / all.count().max(1) as f64
        };
        let verdict_reasons = |r: &ClipReport| {
            let lasting = r.findings.iter().filter(|f| f.verdict > Verdict::Pass);
            lasting.map(|f| f.reason.clone()).collect()
        };
        Self {
            name: original.name.clone(),
            cut: [plan.kept[0], original.frames - plan.kept[1]],
            added: plan.added,
            flight: plan.flight(),
            floor_m: plan.floor,
            slow: 1.0,
            feet_m: distance(&figure.feet),
            hands_m: distance(&figure.hands),
            base_m: distance(&[0]),
            kick_speed: [before.measures.foot_speed.value, after.measures.foot_speed.value],
            torque: [peak(&shares[0]), peak(&shares[1])],
            torque_over: [over(&shares[0]), over(&shares[1])],
            steps: 0,
            seconds: 0.0,
            reasons: verdict_reasons(&after),
            warnings: slower([before.measures.foot_speed.value, after.measures.foot_speed.value])
                .into_iter()
                .collect(),
            before,
            after,
        }
    }
}

/// Share of the kick's foot speed that may be lost without a warning.
const LOSS: f64 = 0.10;

/// A warning on the kicking foot's largest speed before and after `[m/s]`.
fn slower([before, after]: [f64; 2]) -> Option<String> {
    let lost = 1.0 - after / before;
    (lost > LOSS).then(|| {
        format!(
            "the kicking foot lost {:.0} % of its speed: {after:.2} m/s of {before:.2} m/s; a smaller --stretch keeps more",
            100.0 * lost
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kick_that_lost_more_than_a_tenth_of_its_speed_is_reported() {
        assert_eq!(slower([10.0, 9.01]), None);
        assert_eq!(slower([10.0, 11.0]), None);
        assert_eq!(slower([0.0, 0.0]), None);
        let text = slower([10.0, 8.5]).expect("15 % are lost");
        assert!(text.starts_with("the kicking foot lost 15 % of its speed: 8.50 m/s of 10.00 m/s"), "{text}");
    }
}
