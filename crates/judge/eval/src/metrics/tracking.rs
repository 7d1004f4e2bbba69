//! How closely one trajectory of bodies follows another.
//!
//! Definitions as in the public MuJoCo evaluation of the paper's policy: positions of both trajectories are first
//! shifted so that body 0 (the root) starts at the origin.

/// Positions of `bodies` bodies over time `[T, B]`, world axes `[m]`; body 0 is the root.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyTrack {
    bodies: usize,
    pos: Vec<[f64; 3]>,
}

impl BodyTrack {
    /// An empty trajectory of `bodies` bodies.
    ///
    /// # Panics
    /// If `bodies` is zero.
    pub fn new(bodies: usize) -> Self {
        assert!(bodies > 0, "a trajectory needs a root");
        Self { bodies, pos: Vec::new() }
    }
    /// Appends a frame.
    ///
    /// # Panics
    /// If the number of bodies differs.
    pub fn push(&mut self, frame: impl IntoIterator<Item = [f64; 3]>) {
        self.pos.extend(frame);
        assert!(self.pos.len().is_multiple_of(self.bodies), "a frame has {} bodies", self.bodies);
    }
    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.pos.len() / self.bodies.max(1)
    }
    /// Positions of frame `t`.
    pub fn frame(&self, t: usize) -> &[[f64; 3]] {
        &self.pos[t * self.bodies..(t + 1) * self.bodies]
    }
    /// Root position of frame `t`.
    pub fn root(&self, t: usize) -> [f64; 3] {
        self.pos[t * self.bodies]
    }
}

/// Errors of a trajectory against a reference of the same frames and bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TrackingErrors {
    /// Mean distance of bodies relative to each frame's root `[mm]`.
    pub mpjpe_mm: f64,
    /// Mean distance of bodies, roots starting at one point `[mm]`.
    pub g_mpjpe_mm: f64,
    /// Mean norm of the difference of the root's displacement per frame `[mm]`.
    pub velocity_error_mm: f64,
}

/// Errors over the frames that both trajectories have; `None` without a common frame. With a single frame the velocity
/// error is zero.
///
/// # Panics
/// If the numbers of bodies differ.
pub fn tracking_errors(robot: &BodyTrack, reference: &BodyTrack) -> Option<TrackingErrors> {
    assert_eq!(robot.bodies, reference.bodies, "both trajectories have the same bodies");
    let frames = robot.frames().min(reference.frames());
    if frames == 0 {
        return None;
    }
    let (a0, b0) = (robot.root(0), reference.root(0));
    let (mut local, mut global, mut velocity) = (0.0, 0.0, 0.0);
    for t in 0..frames {
        let (ra, rb) = (robot.root(t), reference.root(t));
        for (a, b) in robot.frame(t).iter().zip(reference.frame(t)) {
            global += distance(sub(*a, a0), sub(*b, b0));
            local += distance(sub(*a, ra), sub(*b, rb));
        }
        if t > 0 {
            velocity += distance(sub(ra, robot.root(t - 1)), sub(rb, reference.root(t - 1)));
        }
    }
    let samples = (frames * robot.bodies) as f64;
    Some(TrackingErrors {
        mpjpe_mm: 1e3 * local / samples,
        g_mpjpe_mm: 1e3 * global / samples,
        velocity_error_mm: 1e3 * velocity / (frames - 1).max(1) as f64,
    })
}

/// Mean distance of each body relative to each frame's root over the frames that both trajectories have `[mm]`; their mean is the MPJPE.
///
/// # Panics
/// If the numbers of bodies differ.
pub fn body_errors(robot: &BodyTrack, reference: &BodyTrack) -> Vec<f64> {
    assert_eq!(robot.bodies, reference.bodies, "both trajectories have the same bodies");
    let frames = robot.frames().min(reference.frames());
    let mut sums = vec![0.0; robot.bodies];
    for t in 0..frames {
        let (ra, rb) = (robot.root(t), reference.root(t));
        for ((sum, a), b) in sums.iter_mut().zip(robot.frame(t)).zip(reference.frame(t)) {
            *sum += distance(sub(*a, ra), sub(*b, rb));
        }
    }
    sums.iter().map(|sum| 1e3 * sum / frames.max(1) as f64).collect()
}

/// Time-averaged peak link jerk `[m/frame^3]`: per frame the largest over bodies of the L1 norm of the third difference
/// of position, averaged over time; zero with fewer than four frames.
pub fn peak_jerk(track: &BodyTrack) -> f64 {
    let frames = track.frames();
    if frames < 4 {
        return 0.0;
    }
    let mut sum = 0.0;
    for t in 3..frames {
        let mut peak = 0.0_f64;
        for i in 0..track.bodies {
            let p = |k: usize| track.frame(t - k)[i];
            let l1: f64 = (0..3).map(|c| (p(0)[c] - 3.0 * p(1)[c] + 3.0 * p(2)[c] - p(3)[c]).abs()).sum();
            peak = peak.max(l1);
        }
        sum += peak;
    }
    sum / (frames - 3) as f64
}

/// How much of the reference's horizontal displacement was walked: the projection onto it as a share of its length. One
/// for a reference that stays in place.
pub fn displacement_share(robot: [f64; 2], reference: [f64; 2]) -> f64 {
    let length2 = reference[0] * reference[0] + reference[1] * reference[1];
    if length2 < 1e-6 { 1.0 } else { (robot[0] * reference[0] + robot[1] * reference[1]) / length2 }
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = sub(a, b);
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(frames: &[[[f64; 3]; 2]]) -> BodyTrack {
        let mut track = BodyTrack::new(2);
        for frame in frames {
            track.push(*frame);
        }
        track
    }

    #[test]
    fn two_frames_by_hand() {
        let reference = track(&[[[0.0; 3], [0.0, 0.0, 1.0]], [[0.1, 0.0, 0.0], [0.1, 0.0, 1.0]]]);
        // Starts 5 m aside (not an error), then falls 30 mm behind and lifts body 1 by 40 mm.
        let robot = track(&[[[5.0, 0.0, 0.0], [5.0, 0.0, 1.0]], [[5.07, 0.0, 0.0], [5.07, 0.0, 1.04]]]);
        let errors = tracking_errors(&robot, &reference).expect("common frames");
        // Global: 0, 0, 30, 50 mm. Local: 0, 0, 0, 40 mm. Root displacement: 70 instead of 100 mm.
        assert!((errors.g_mpjpe_mm - 20.0).abs() < 1e-9, "{errors:?}");
        assert!((errors.mpjpe_mm - 10.0).abs() < 1e-9, "{errors:?}");
        assert!((errors.velocity_error_mm - 30.0).abs() < 1e-9, "{errors:?}");
        // The root has no error by definition; the other body's mean is over both frames.
        let bodies = body_errors(&robot, &reference);
        assert!(bodies[0] == 0.0 && (bodies[1] - 20.0).abs() < 1e-9, "{bodies:?}");
    }

    #[test]
    fn a_trajectory_against_itself_has_no_error() {
        let t = track(&[[[1.0; 3], [2.0; 3]], [[3.0; 3], [4.0; 3]]]);
        assert_eq!(tracking_errors(&t, &t), Some(TrackingErrors::default()));
    }

    #[test]
    fn without_a_common_frame_there_is_no_error_to_report() {
        assert_eq!(tracking_errors(&BodyTrack::new(2), &track(&[[[0.0; 3]; 2]])), None);
    }

    #[test]
    fn a_cubic_has_constant_jerk() {
        // x = 0.5 t^3 and y = -0.25 t^3 a frame: third differences 3 and -1.5, L1 norm 4.5; the root's is 0.
        let mut t = BodyTrack::new(2);
        for k in 0..9 {
            let cube = f64::from(k).powi(3);
            t.push([[0.0, f64::from(k), 0.0], [0.5 * cube, -0.25 * cube, f64::from(k).powi(2)]]);
        }
        assert!((peak_jerk(&t) - 4.5).abs() < 1e-9, "{}", peak_jerk(&t));
    }

    #[test]
    fn three_frames_have_no_jerk() {
        assert_eq!(peak_jerk(&track(&[[[0.0; 3]; 2], [[1.0; 3]; 2], [[9.0; 3]; 2]])), 0.0);
    }

    #[test]
    fn walking_sideways_does_not_count_as_walking_ahead() {
        assert_eq!(displacement_share([0.0, 1.0], [2.0, 0.0]), 0.0);
        assert_eq!(displacement_share([1.0, 0.5], [2.0, 0.0]), 0.5);
        assert_eq!(displacement_share([0.3, 0.0], [0.0, 0.0]), 1.0);
    }
}
