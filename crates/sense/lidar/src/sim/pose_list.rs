//! A motion given as timed poses: what another simulator recorded.

use nalgebra::{Isometry3, Translation3};

use crate::error::LidarError;
use crate::sim::walk::Trajectory;

/// Timed poses of the torso. Between them positions follow a Catmull-Rom spline and rotations the shortest arc; before the first and
/// after the last the torso stands. Poses every 2 ms or denser give accelerations that hold.
#[derive(Clone, Debug)]
pub struct PoseList {
    poses: Vec<(f64, Isometry3<f64>)>,
}

impl PoseList {
    /// Poses with their times `[s]`.
    ///
    /// # Errors
    ///
    /// Fewer than two poses, a time that does not grow, or a number that is not finite.
    pub fn new(poses: Vec<(f64, Isometry3<f64>)>) -> Result<Self, LidarError> {
        let wrong = |index, expected, found: String| LidarError::Pose { index, expected, found };
        if poses.len() < 2 {
            return Err(wrong(0, "at least two poses", poses.len().to_string()));
        }
        for (index, (time_s, pose)) in poses.iter().enumerate() {
            let finite = time_s.is_finite()
                && pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite());
            if !finite {
                return Err(wrong(index, "finite numbers", format!("{time_s} s, {pose}")));
            }
            if index > 0 && *time_s <= poses[index - 1].0 {
                let found = format!("{time_s} s after {} s", poses[index - 1].0);
                return Err(wrong(index, "a later time than the one before", found));
            }
        }
        Ok(Self { poses })
    }

    /// Adds a pose while the motion continues. Returns whether it was taken: its time `[s]` must be later than the last one's.
    pub fn push(&mut self, time_s: f64, pose: Isometry3<f64>) -> bool {
        let later = self.poses.last().is_none_or(|(last, _)| time_s > *last);
        if later {
            self.poses.push((time_s, pose));
        }
        later
    }

    /// Forgets poses before `time_s` `[s]`, but for the last four of them.
    pub fn forget_before(&mut self, time_s: f64) {
        let first = self.poses.partition_point(|(t, _)| *t < time_s).saturating_sub(4);
        self.poses.drain(..first);
    }
}

impl Trajectory for PoseList {
    fn pose(&self, time_s: f64) -> Isometry3<f64> {
        let last = self.poses.len() - 1;
        let next = self.poses.partition_point(|(t, _)| *t <= time_s);
        if next == 0 {
            return self.poses[0].1;
        }
        if next > last {
            return self.poses[last].1;
        }
        let at = |i: usize| (self.poses[i].0, self.poses[i].1.translation.vector);
        let ((t1, p1), (t2, p2)) = (at(next - 1), at(next));
        let span = t2 - t1;
        let u = (time_s - t1) / span;
        // Slopes from the neighbors on either side; at the ends from the span itself.
        let (t0, p0) = at(next.saturating_sub(2));
        let (t3, p3) = at((next + 1).min(last));
        let (m1, m2) = ((p2 - p0) * (span / (t2 - t0)), (p3 - p1) * (span / (t3 - t1)));
        let (u2, u3) = (u * u, u * u * u);
        let position = p1 * (2.0 * u3 - 3.0 * u2 + 1.0)
            + m1 * (u3 - 2.0 * u2 + u)
            + p2 * (3.0 * u2 - 2.0 * u3)
            + m2 * (u3 - u2);
        let (r1, r2) = (self.poses[next - 1].1.rotation, self.poses[next].1.rotation);
        let rotation = r1 * (r1.inverse() * r2).powf(u);
        Isometry3::from_parts(Translation3::from(position), rotation)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;

    #[test]
    fn a_list_of_poses_follows_the_motion_it_was_taken_from() {
        let truth = |t: f64| {
            let position = Vector3::new(t * t, (3.0 * t).sin(), 0.5);
            Isometry3::from_parts(
                Translation3::from(position),
                UnitQuaternion::from_euler_angles(0.0, 0.1 * t, t),
            )
        };
        let list =
            PoseList::new((0..=500).map(|i| (f64::from(i) * 0.002, truth(f64::from(i) * 0.002))).collect())
                .expect("poses");
        for i in 0..900 {
            let t = 0.05 + f64::from(i) * 0.001;
            let (found, wanted) = (list.pose(t), truth(t));
            assert!((found.translation.vector - wanted.translation.vector).norm() < 1e-7);
            assert!(found.rotation.angle_to(&wanted.rotation) < 1e-5);
        }
        assert_eq!(list.pose(-1.0), list.pose(0.0));
        assert_eq!(list.pose(9.0), list.pose(1.0));
    }

    #[test]
    fn a_time_that_stands_still_is_named() {
        let pose = Isometry3::identity();
        let error = PoseList::new(vec![(0.0, pose), (0.1, pose), (0.1, pose)]).expect_err("equal times");
        assert_eq!(
            error.to_string(),
            "timed poses, number 2: expected a later time than the one before, found 0.1 s after 0.1 s"
        );
    }
}
