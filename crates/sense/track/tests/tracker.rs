//! The ball tracker against a Kalman filter in matrices, its consistency, and its lanes.

use paid_lanes::rng::Rng;
use paid_lanes::{F32Array, Mask, Real};
use paid_track::{BallTracker, Measurement, Rolling, TrackerPreset};

type Matrix = [[f64; 4]; 4];

fn multiplied(a: &Matrix, b: &Matrix) -> Matrix {
    let mut out = [[0.0; 4]; 4];
    for i in 0..4 {
        for j in 0..4 {
            out[i][j] = (0..4).map(|k| a[i][k] * b[k][j]).sum();
        }
    }
    out
}

fn transposed(a: &Matrix) -> Matrix {
    let mut out = [[0.0; 4]; 4];
    for i in 0..4 {
        for j in 0..4 {
            out[i][j] = a[j][i];
        }
    }
    out
}

/// A Kalman filter over (x, y, vx, vy), written out.
#[derive(Clone)]
struct Plain {
    x: [f64; 4],
    p: Matrix,
}

impl Plain {
    fn predict(&mut self, dt: f64, decay: f64, q: f64) {
        let kept = (-decay * dt).exp();
        let way = if decay > 0.0 { (1.0 - kept) / decay } else { dt };
        let mut f = [[0.0; 4]; 4];
        let mut noise = [[0.0; 4]; 4];
        for axis in 0..2 {
            (f[axis][axis], f[axis][axis + 2], f[axis + 2][axis + 2]) = (1.0, way, kept);
            noise[axis][axis] = q * dt.powi(3) / 3.0;
            noise[axis][axis + 2] = q * dt.powi(2) / 2.0;
            noise[axis + 2][axis] = q * dt.powi(2) / 2.0;
            noise[axis + 2][axis + 2] = q * dt;
        }
        self.x = [0, 1, 2, 3].map(|i| (0..4).map(|j| f[i][j] * self.x[j]).sum());
        self.p = multiplied(&multiplied(&f, &self.p), &transposed(&f));
        for i in 0..4 {
            for j in 0..4 {
                self.p[i][j] += noise[i][j];
            }
        }
    }

    /// One scalar measurement after the other; their errors are independent.
    fn update(&mut self, z: [f64; 2], r: f64) {
        for axis in 0..2 {
            let s = self.p[axis][axis] + r;
            let gain = [0, 1, 2, 3].map(|i| self.p[i][axis] / s);
            let innovation = z[axis] - self.x[axis];
            for i in 0..4 {
                self.x[i] += gain[i] * innovation;
            }
            let row = self.p[axis];
            for i in 0..4 {
                for j in 0..4 {
                    self.p[i][j] -= gain[i] * row[j];
                }
            }
        }
    }
}

/// One process noise at all times but the strike, so that a linear filter can give the same.
fn linear() -> TrackerPreset {
    TrackerPreset { rolling_noise: 0.05, resting_noise: 0.05, ..TrackerPreset::default() }
}

const DT: f64 = 0.02;

#[test]
fn late_pictures_give_what_a_plain_filter_makes_of_punctual_ones() {
    // The plain filter refuses nothing.
    let preset = TrackerPreset { gate: 100.0, ..linear() };
    for (seed, late) in [(1, 0), (2, 3), (3, 5)] {
        for decay in [0.0, 1.7] {
            let mut rng = Rng::new(seed, 0, 0);
            let age_s = f64::from(late) * DT;
            // Between two control steps, so that nothing hangs on rounding.
            let strike_s = 1.311;
            let mut tracker = BallTracker::<f64>::new();
            let mut plain: Option<Plain> = None;
            let mut way = Vec::new();
            for step in 0..120_i32 {
                let now = f64::from(step) * DT;
                // A ball on a curve; some images do not show it.
                let at = [1.0 + 0.3 * now + 0.02 * rng.normal(), 0.5 - 0.1 * now * now + 0.02 * rng.normal()];
                way.push((at, rng.unit() < 0.6));
                let rolling = Rolling { decay, to_strike_s: strike_s - now };
                tracker.advance(DT, age_s, &rolling, &preset);
                // The plain filter lives at the time of the images.
                let then = now - age_s;
                let q = noise(then - strike_s, &preset);
                if step < late {
                    continue;
                }
                let (position, seen) = way[(step - late) as usize];
                let picture = Measurement { position, variance: 4e-4, age_s, seen };
                if let Some(plain) = &mut plain {
                    // The noise of a step is that of the moment at which it begins, which is one step ago.
                    plain.predict(DT, decay, noise(then - DT - strike_s, &preset));
                    if seen {
                        plain.update(position, 4e-4);
                    }
                } else if seen {
                    let v = preset.speed_m_s.powi(2);
                    let mut p = [[0.0; 4]; 4];
                    (p[0][0], p[1][1], p[2][2], p[3][3]) = (4e-4, 4e-4, v, v);
                    plain = Some(Plain { x: [position[0], position[1], 0.0, 0.0], p });
                }
                tracker.fuse(&picture, &rolling, &preset);
                let Some(plain) = &plain else { continue };
                let mut ahead = plain.clone();
                ahead.predict(age_s, decay, q);
                let estimate = tracker.estimate(&rolling, &preset);
                let [x, y] = estimate.position;
                let [vx, vy] = estimate.velocity;
                for (found, expected) in [x, y, vx, vy].into_iter().zip(ahead.x) {
                    assert!((found - expected).abs() < 1e-9, "{step}: {estimate:?} {:?}", ahead.x);
                }
                let expected = [ahead.p[1][1], ahead.p[1][3], ahead.p[3][3]];
                for (found, expected) in estimate.covariance.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-9 * (1.0 + expected), "{step}: {found} {expected}");
                }
            }
        }
    }
}

/// Density of the process noise `after` the strike `[s]`.
fn noise(after: f64, preset: &TrackerPreset) -> f64 {
    let [from, to] = preset.strike_window_s;
    let rolling = preset.rolling_noise.powi(2);
    if after >= from && after <= to { rolling + preset.strike_noise.powi(2) } else { rolling }
}

/// A sequence of true places with white acceleration, and its images every 33 ms, 60 ms late; returns the squared error normalized by the
/// covariance (NEES), and the squared errors of the estimated and of the filter's place half a second ahead.
fn run(number: u32, rests: bool, preset: &TrackerPreset) -> (f64, [f64; 2]) {
    let mut rng = Rng::new(2026, number, 0);
    let decay = rng.uniform(0.0, 2.0);
    let age_s = 0.06;
    let steps = 30 + rng.below(60);
    let blind_from = rng.below(steps);
    let mut x: [f64; 2] = [rng.uniform(-1.0, 3.0), rng.uniform(-2.0, 2.0)];
    let mut v = [0, 1].map(|_| if rests { 0.0 } else { preset.speed_m_s * rng.normal() });
    let rolling = Rolling { decay, to_strike_s: f64::INFINITY };
    let mut tracker = BallTracker::<f64>::new();
    let mut places = vec![x];
    let mut next = rng.unit() * 1.65;
    for step in 0..steps {
        // Exactly discretized: position and velocity noise of one step are correlated by sqrt(3)/2.
        let kept = (-decay * DT).exp();
        let way = if decay > 0.0 { (1.0 - kept) / decay } else { DT };
        let q = if rests { 0.0 } else { preset.rolling_noise.powi(2) };
        for k in 0..2 {
            let (a, b) = (rng.normal(), rng.normal());
            x[k] += way * v[k] + (q * DT.powi(3) / 3.0).sqrt() * (3.0_f64.sqrt() / 2.0 * a + 0.5 * b);
            v[k] = kept * v[k] + (q * DT).sqrt() * a;
        }
        places.push(x);
        tracker.advance(DT, age_s, &rolling, preset);
        next -= 1.0;
        let due = next < 0.5;
        next += if due { 1.65 } else { 0.0 };
        let seen = due && places.len() > 3 && rng.unit() < 0.8 && (step < 20 || step < blind_from);
        let captured = places[places.len().saturating_sub(4)];
        let sigma = rng.uniform(0.01, 0.05);
        let position = captured.map(|p| p + sigma * rng.normal());
        tracker.fuse(&Measurement { position, variance: sigma * sigma, age_s, seen }, &rolling, preset);
    }
    let estimate = tracker.estimate(&rolling, preset);
    let [pp, pv, vv] = estimate.covariance;
    let det = pp * vv - pv * pv;
    let nees: f64 = (0..2)
        .map(|k| {
            let (e, f) = (estimate.position[k] - x[k], estimate.velocity[k] - v[k]);
            (vv * e * e - 2.0 * pv * e * f + pp * f * f) / det
        })
        .sum();
    let belief = tracker.belief(&rolling, preset);
    let time = paid_track::effective_time(0.5, decay);
    let missed =
        |p: [f64; 2], u: [f64; 2]| (0..2).map(|k| (p[k] - x[k] + time * (u[k] - v[k])).powi(2)).sum();
    let errors =
        [missed(belief.ball.position, belief.ball.velocity), missed(estimate.position, estimate.velocity)];
    assert!(belief.known);
    (nees, errors)
}

#[test]
fn errors_are_as_large_as_the_covariance_says_over_ten_thousand_sequences() {
    // Rolling balls whose velocity wanders by the process noise: chi-square with 4 degrees of freedom. The gate of 4 deviations takes away
    // next to nothing.
    let n = 10_000;
    let sum: f64 = (0..n).map(|k| run(k, false, &linear()).0).sum();
    let (mean, bound) = (sum / f64::from(n), 1.96 * (8.0 / f64::from(n)).sqrt());
    assert!((mean - 4.0).abs() < bound, "{mean} +- {bound}");
}

#[test]
fn believing_in_rest_makes_balls_at_rest_steady_and_costs_rolling_ones_little() {
    let preset = TrackerPreset::default();
    let n = 5_000;
    let mean = |rests: bool| {
        let mut sums = [0.0; 3];
        for k in 0..n {
            let (nees, [belief, filter]) = run(k, rests, &preset);
            sums = [sums[0] + nees, sums[1] + belief, sums[2] + filter];
        }
        sums.map(|s| s / f64::from(n))
    };
    let (rest, roll) = (mean(true), mean(false));
    // The error half a second ahead, squared: less than a third for a ball at rest, a fifth more for one that rolls at any small speed.
    assert!(rest[1] < 0.33 * rest[2] && roll[1] < 1.2 * roll[2], "{rest:?} {roll:?}");
    assert!(rest[1] + roll[1] < 0.8 * (rest[2] + roll[2]), "{rest:?} {roll:?}");
    // The mode decision keeps the covariance honest: 4 would be exact, balls at rest have less.
    assert!((2.0..4.0).contains(&rest[0]) && (roll[0] - 4.0).abs() < 0.9, "{rest:?} {roll:?}");
}

#[test]
fn lanes_track_as_a_single_ball_does() {
    type Lanes = F32Array<8>;
    let preset = TrackerPreset::default();
    let mut lanes = BallTracker::<Lanes>::new();
    let mut single: Vec<BallTracker<f64>> = vec![BallTracker::new(); 8];
    let mut rng = Rng::new(5, 0, 0);
    for step in 0..150 {
        let to_strike = 1.511 - DT * f64::from(step);
        let mut picture = Measurement {
            position: [Lanes::zero(); 2],
            variance: Lanes::c(4e-4),
            age_s: Lanes::c(0.06),
            seen: <Lanes as Real>::Mask::splat(false),
        };
        let mut decay = Lanes::zero();
        let mut seen = 0;
        for lane in 0..8 {
            // Each lane has its own ball, and a false detection now and then.
            let now = DT * f64::from(step);
            let wrong = if rng.unit() < 0.03 { 1.0 } else { 0.0 };
            let place = [1.0 + 0.1 * lane as f64 * now + wrong, 0.3 + 0.02 * rng.normal()];
            seen |= u32::from(rng.unit() < 0.6) << lane;
            for k in 0..2 {
                picture.position[k].set_lane(lane, place[k]);
            }
            decay.set_lane(lane, 0.2 * lane as f64);
        }
        picture.seen = <Lanes as Real>::Mask::from_bits(seen);
        let rolling = Rolling { decay, to_strike_s: Lanes::c(to_strike) };
        lanes.advance(Lanes::c(DT), Lanes::c(0.06), &rolling, &preset);
        lanes.fuse(&picture, &rolling, &preset);
        let belief = lanes.belief(&rolling, &preset);
        for (lane, tracker) in single.iter_mut().enumerate() {
            let rolling = Rolling { decay: decay.lane(lane), to_strike_s: to_strike };
            let picture = Measurement {
                position: [0, 1].map(|k| picture.position[k].lane(lane)),
                variance: 4e-4,
                age_s: 0.06,
                seen: picture.seen.lane(lane),
            };
            tracker.advance(DT, 0.06, &rolling, &preset);
            tracker.fuse(&picture, &rolling, &preset);
            let one = tracker.belief(&rolling, &preset);
            assert_eq!(belief.known.lane(lane), one.known, "{step} {lane}");
            if !one.known {
                continue;
            }
            for k in 0..2 {
                let (p, q) = (belief.ball.position[k].lane(lane), one.ball.position[k]);
                let (v, w) = (belief.ball.velocity[k].lane(lane), one.ball.velocity[k]);
                assert!((p - q).abs() < 1e-3 && (v - w).abs() < 5e-3, "{step} {lane}: {p} {q}, {v} {w}");
            }
            assert!((belief.age_s.lane(lane) - one.age_s).abs() < 1e-4, "{step} {lane}");
        }
    }
}

#[test]
fn a_tracker_of_one_lane_is_restored_from_its_numbers() {
    let preset = TrackerPreset::default();
    let rolling = Rolling { decay: 0.5, to_strike_s: 2.0 };
    let mut tracker = BallTracker::<f64>::new();
    for k in 0..10 {
        let picture =
            Measurement { position: [f64::from(k) * 0.01, 0.2], variance: 1e-4, age_s: 0.04, seen: true };
        tracker.advance(DT, 0.04, &rolling, &preset);
        tracker.fuse(&picture, &rolling, &preset);
    }
    let mut copy = BallTracker::<f64>::new();
    for (to, from) in copy.fields().into_iter().zip(tracker.fields()) {
        *to = *from;
    }
    let (a, b) = (tracker.belief(&rolling, &preset), copy.belief(&rolling, &preset));
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
}
