//! Hand-made sequences of images.

use paid_track::{BallTracker, Belief, Measurement, Rolling, TrackerPreset};

const DT: f64 = 1.0 / 30.0;
const LATE: f64 = 0.06;

/// A tracker with its clock.
struct Watched {
    tracker: BallTracker<f64>,
    preset: TrackerPreset,
    decay: f64,
    /// Time until the strike `[s]`.
    to_strike: f64,
}

impl Watched {
    fn new(decay: f64) -> Self {
        let tracker = BallTracker::new();
        Self { tracker, preset: TrackerPreset::default(), decay, to_strike: 100.0 }
    }

    fn rolling(&self) -> Rolling<f64> {
        Rolling { decay: self.decay, to_strike_s: self.to_strike }
    }

    /// An image with a deviation of 2 cm, or none, and a thirtieth of a second.
    fn picture(&mut self, seen: Option<[f64; 2]>) -> Belief<f64> {
        self.to_strike -= DT;
        let rolling = self.rolling();
        self.tracker.advance(DT, LATE, &rolling, &self.preset);
        let picture = Measurement {
            position: seen.unwrap_or_default(),
            variance: 4e-4,
            age_s: LATE,
            seen: seen.is_some(),
        };
        self.tracker.fuse(&picture, &rolling, &self.preset);
        self.tracker.belief(&rolling, &self.preset)
    }
}

/// An error of 1.5 cm that changes its sign.
fn error(k: usize) -> f64 {
    if k.is_multiple_of(2) { 0.015 } else { -0.015 }
}

#[test]
fn a_ball_at_rest_becomes_steady() {
    let mut ball = Watched::new(0.0);
    for k in 0..20 {
        ball.picture(Some([1.0 + error(k), -0.4]));
    }
    let early = ball.tracker.estimate(&ball.rolling(), &ball.preset);
    let mut last = None;
    for k in 0..60 {
        last = Some(ball.picture(Some([1.0 + error(k), -0.4])));
    }
    let belief = last.expect("images");
    assert!(belief.rest > 0.99, "{belief:?}");
    assert!((belief.ball.position[0] - 1.0).abs() < 0.002, "{belief:?}");
    assert!(belief.ball.velocity[0].abs() < 1e-4, "{belief:?}");
    // Twenty images in 0.63 s know the velocity to 0.02 sqrt(12 / 20) / 0.63 = 2.5 cm/s, eighty in 2.6 s to 6 mm/s plus the noise of a
    // ball at rest.
    assert!((early.covariance[2].sqrt() - 0.025).abs() < 0.005, "{early:?}");
    assert!(belief.ball.covariance[2].sqrt() < 0.007, "{belief:?}");
    assert!((belief.age_s - LATE).abs() < 1e-12);
}

#[test]
fn a_rolling_ball_is_known_now_and_not_when_its_picture_was_taken() {
    let mut ball = Watched::new(0.0);
    let mut belief = None;
    for k in 0..40 {
        // The image shows where it was 60 ms ago.
        belief = Some(ball.picture(Some([0.3 * (k as f64 * DT - LATE) + error(k), 0.0])));
    }
    let belief = belief.expect("images");
    assert!((belief.ball.position[0] - 0.3 * 39.0 * DT).abs() < 0.01, "{belief:?}");
    assert!((belief.ball.velocity[0] - 0.3).abs() < 0.02 && belief.rest < 1e-3, "{belief:?}");
}

#[test]
fn a_ball_out_of_view_rolls_on_and_becomes_uncertain() {
    // Velocity exp(-2 t) after the last image: 0.3 (1 - exp(-2)) / 2 = 0.13 m in a second.
    let mut ball = Watched::new(2.0);
    let start = |t: f64| 0.3 * (1.0 - (-2.0 * t).exp()) / 2.0;
    let mut belief = None;
    for k in 0..15 {
        belief = Some(ball.picture(Some([start(k as f64 * DT - LATE), 0.0])));
    }
    let before = belief.take().expect("images");
    for _ in 0..30 {
        belief = Some(ball.picture(None));
    }
    let after = belief.expect("images");
    assert!((after.ball.position[0] - start(44.0 * DT)).abs() < 0.015, "{after:?}");
    assert!((after.age_s - LATE - 1.0).abs() < 1e-9, "{after:?}");
    assert!(after.ball.covariance[0] > 1.5 * before.ball.covariance[0], "{before:?} {after:?}");
    // Its images come back and it is certain again.
    for k in 45..60 {
        belief = Some(ball.picture(Some([start(k as f64 * DT - LATE), 0.0])));
    }
    let again = belief.expect("images");
    assert!(again.ball.covariance[0] < before.ball.covariance[0] && (again.age_s - LATE).abs() < 1e-9);
}

#[test]
fn one_false_detection_changes_nothing() {
    let (mut with, mut without) = (Watched::new(0.0), Watched::new(0.0));
    for k in 0..20 {
        let place = Some([1.0 + error(k), 0.0]);
        with.picture(place);
        without.picture(place);
    }
    let (a, b) = (with.picture(Some([1.6, 0.9])), without.picture(None));
    assert_eq!((a.ball.position, a.ball.velocity), (b.ball.position, b.ball.velocity));
    assert!((a.age_s - b.age_s).abs() < 1e-12);
    // Scattered ones do not add up either.
    for (k, wrong) in [[0.2, 0.3], [2.5, -1.0], [0.5, 1.5], [3.0, 0.0]].into_iter().enumerate() {
        let (a, b) = (with.picture(Some(wrong)), without.picture(None));
        assert_eq!(a.ball.position, b.ball.position, "{k}");
    }
}

#[test]
fn a_ball_that_was_moved_is_found_again_after_three_images() {
    let mut ball = Watched::new(0.0);
    for k in 0..20 {
        ball.picture(Some([1.0 + error(k), 0.0]));
    }
    for k in 0..2 {
        let belief = ball.picture(Some([1.8 + error(k), 0.5]));
        assert!((belief.ball.position[0] - 1.0).abs() < 0.02, "{belief:?}");
    }
    let belief = ball.picture(Some([1.8, 0.5]));
    assert!((belief.ball.position[0] - 1.8).abs() < 0.1 && (belief.age_s - LATE).abs() < 1e-9, "{belief:?}");
    let mut belief = None;
    for k in 0..30 {
        belief = Some(ball.picture(Some([1.8 + error(k), 0.5])));
    }
    let belief = belief.expect("images");
    assert!((belief.ball.position[0] - 1.8).abs() < 0.01 && belief.rest > 0.9, "{belief:?}");
}

#[test]
fn a_kicked_ball_is_followed_at_once_where_the_strike_was_expected() {
    let run = |to_strike: f64| {
        let mut ball = Watched::new(0.0);
        ball.to_strike = to_strike + 40.0 * DT;
        for k in 0..40 {
            ball.picture(Some([0.5 + error(k), 0.0]));
        }
        // It leaves with 4 m/s; the images are 60 ms late.
        let mut belief = None;
        for k in 0..5 {
            let flown = 4.0 * (k as f64 * DT).max(0.0);
            belief = Some(ball.picture(Some([0.5 + flown, 0.0])));
        }
        belief.expect("images")
    };
    let (expected, surprised) = (run(0.0), run(50.0));
    assert!((expected.ball.velocity[0] - 4.0).abs() < 0.4, "{expected:?}");
    // Where it was not expected, it was lost for two images, and found again.
    assert!((surprised.ball.velocity[0] - 4.0).abs() < 1.0, "{surprised:?}");
}

#[test]
fn a_picture_that_is_older_than_the_state_is_not_used() {
    let mut ball = Watched::new(0.0);
    for k in 0..10 {
        ball.picture(Some([1.0 + error(k), 0.0]));
    }
    let before = ball.tracker.belief(&ball.rolling(), &ball.preset);
    let old = Measurement { position: [1.05, 0.0], variance: 1e-6, age_s: 0.2, seen: true };
    let rolling = ball.rolling();
    ball.tracker.fuse(&old, &rolling, &ball.preset);
    let after = ball.tracker.belief(&rolling, &ball.preset);
    assert_eq!(before.ball.position, after.ball.position);
}

#[test]
fn a_tracker_without_a_picture_knows_nothing() {
    let mut ball = Watched::new(0.0);
    let belief = ball.picture(None);
    assert!(!belief.known && belief.ball.covariance[0] > 1000.0);
}
