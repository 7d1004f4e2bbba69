//! Simulated eyes: what camera, odometry and tracker make of the true scene.

use paid_lanes::rng::Rng;
use paid_lanes::{Mask, Mat3, Real, Vec3};

use crate::{BallAtStart, BallTracker, Belief, EyesDraw, EyesPreset, Measurement, OdometryDrift, Rolling};

/// A body in the world.
#[derive(Clone, Copy, Debug)]
pub struct BodyPose<V> {
    /// Origin `[m]`.
    pub pos: Vec3<V>,
    /// Body frame in the world.
    pub rot: Mat3<V>,
}

/// The true scene.
#[derive(Clone, Copy, Debug)]
pub struct TrueScene<V> {
    /// The robot's base.
    pub base: BodyPose<V>,
    /// Velocity of its origin, world axes `[m/s]`.
    pub base_vel: Vec3<V>,
    /// The body that carries the camera.
    pub carrier: BodyPose<V>,
    /// Center of the ball, world `[m]`.
    pub ball: Vec3<V>,
    /// Its velocity, world axes `[m/s]`.
    pub ball_vel: Vec3<V>,
}

/// Random numbers of a control step.
#[derive(Clone, Copy, Debug)]
pub struct EyesNumbers<V> {
    /// Standard normal: noise of x and y, then jitter of x, y and heading.
    pub normal: [V; 5],
    /// Uniform in (-1, 1): drop-out, false detection, and its place in the image.
    pub symmetric: [V; 4],
}

/// An image on its way to the tracker.
#[derive(Clone, Copy, Debug)]
struct DelayedMeasurement<V> {
    position: [V; 2],
    variance: V,
    /// 1 where there is a detection.
    seen: V,
}

/// Eyes, odometry and tracker of a group, one robot a lane.
#[derive(Clone, Debug)]
pub struct Eyes<V> {
    odometry: OdometryDrift<V>,
    tracker: BallTracker<V>,
    /// Images on their way; entry `k` is `k` control steps old.
    on_the_way: Vec<DelayedMeasurement<V>>,
    /// Age of an image when it arrives [control steps], a whole number.
    latency: V,
    /// Control steps between two images, and until the next one.
    period: V,
    next: V,
    dropout: V,
    noise_scale: V,
    /// What the robot takes for the ball's decay `[1/s]`.
    decay: V,
    /// Center of a ball on the ground `[m]`.
    radius: V,
    /// Control period `[s]`.
    dt_s: f64,
}

/// How an episode begins in a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EyesStart {
    /// What the episode has of its own.
    pub draw: EyesDraw,
    /// The ball relative to the base, in axes with this heading in the world `[rad]`.
    pub ball: BallAtStart,
    /// See `ball`.
    pub heading: f64,
    /// Place of the base (x, y), world `[m]`.
    pub base: [f64; 2],
    /// Time that odometry has run `[s]`.
    pub elapsed_s: f64,
    /// Radius of the ball `[m]`.
    pub radius_m: f64,
}

impl<V: Real> Eyes<V> {
    /// Eyes that have seen nothing; a control step takes `dt_s` `[s]`.
    pub fn new(preset: &EyesPreset, dt_s: f64) -> Self {
        let zero = V::zero();
        let latest = (preset.latency_s[1] / dt_s).round() as usize;
        let nothing = DelayedMeasurement { position: [zero; 2], variance: zero, seen: zero };
        Self {
            odometry: OdometryDrift::new(),
            tracker: BallTracker::new(),
            on_the_way: vec![nothing; latest + 1],
            latency: zero,
            period: V::one(),
            next: zero,
            dropout: zero,
            noise_scale: V::one(),
            decay: zero,
            radius: zero,
            dt_s,
        }
    }

    /// Every number, for save and restore.
    pub fn fields(&mut self) -> Vec<&mut V> {
        let mut fields = vec![
            &mut self.latency,
            &mut self.period,
            &mut self.next,
            &mut self.dropout,
            &mut self.noise_scale,
            &mut self.decay,
            &mut self.radius,
        ];
        fields.extend(self.odometry.fields());
        fields.extend(self.tracker.fields());
        for sighting in &mut self.on_the_way {
            let [x, y] = &mut sighting.position;
            fields.extend([x, y, &mut sighting.variance, &mut sighting.seen]);
        }
        fields
    }

    /// Begins an episode in one lane: the robot has looked at the ball, and the next image comes at a random time.
    pub fn begin_lane(&mut self, lane: usize, start: &EyesStart, preset: &EyesPreset, rng: &mut Rng) {
        let EyesStart { draw, ball, heading, base, elapsed_s, radius_m } = *start;
        let tracker = draw.first_look(preset, &ball, rng);
        self.odometry.begin_lane(lane, elapsed_s, &preset.odometry, rng);
        let [error_x, error_y, turned] = self.odometry.error(lane);
        let origin = [base[0] + error_x, base[1] + error_y];
        let turn = heading + turned;
        self.tracker.set_lane(lane, &tracker.moved(turn, origin));
        let period = draw.period_s / self.dt_s;
        self.latency
            .set_lane(lane, (draw.latency_s / self.dt_s).round().min((self.on_the_way.len() - 1) as f64));
        self.period.set_lane(lane, period.max(1.0));
        self.next.set_lane(lane, period * rng.unit());
        self.dropout.set_lane(lane, draw.dropout);
        self.noise_scale.set_lane(lane, draw.noise_scale);
        self.decay.set_lane(lane, draw.decay(&ball));
        self.radius.set_lane(lane, radius_m);
        for sighting in &mut self.on_the_way {
            sighting.seen.set_lane(lane, 0.0);
        }
    }

    /// The rate at which the robot believes the ball to slow down `[1/s]`.
    #[inline(always)]
    pub fn decay(&self) -> V {
        self.decay
    }

    /// A control step: odometry moves on, an image may be taken, and one may arrive. `to_strike_s` is the time until the reference
    /// strikes `[s]`.
    #[inline(always)]
    pub fn look(
        &mut self,
        scene: &TrueScene<V>,
        numbers: &EyesNumbers<V>,
        to_strike_s: V,
        preset: &EyesPreset,
    ) {
        let [nx, ny, jitter @ ..] = numbers.normal;
        self.odometry.advance(V::c(self.dt_s), jitter, &preset.odometry);
        let taken = self.picture(scene, [nx, ny], &numbers.symmetric, preset);
        let last = self.on_the_way.len() - 1;
        for k in (0..last).rev() {
            self.on_the_way[k + 1] = self.on_the_way[k];
        }
        self.on_the_way[0] = taken;
        let mut arrived = self.on_the_way[0];
        for (k, sighting) in self.on_the_way.iter().enumerate().skip(1) {
            let this = self.latency.gt(V::c(k as f64 - 0.5));
            for i in 0..2 {
                arrived.position[i] = V::select(this, sighting.position[i], arrived.position[i]);
            }
            arrived.variance = V::select(this, sighting.variance, arrived.variance);
            arrived.seen = V::select(this, sighting.seen, arrived.seen);
        }
        let age_s = self.latency * V::c(self.dt_s);
        let rolling = Rolling { decay: self.decay, to_strike_s };
        self.tracker.advance(V::c(self.dt_s), age_s, &rolling, &preset.tracker);
        let picture = Measurement {
            position: arrived.position,
            variance: arrived.variance,
            age_s,
            seen: arrived.seen.gt(V::c(0.5)),
        };
        self.tracker.fuse(&picture, &rolling, &preset.tracker);
    }

    /// What the camera detects in this control step.
    #[inline(always)]
    fn picture(
        &mut self,
        scene: &TrueScene<V>,
        normal: [V; 2],
        symmetric: &[V; 4],
        preset: &EyesPreset,
    ) -> DelayedMeasurement<V> {
        // Half a control step of play: an image is taken at the control step nearest to its time.
        let wait = self.next - V::one();
        let due = wait.lt(V::c(0.5));
        self.next = V::select(due, wait + self.period, wait);

        let (camera, TrueScene { base, carrier, ball, .. }) = (preset.camera.geometry(), scene);
        let far = V::c(preset.range_m[1]);
        let visible = preset.in_picture(carrier, *ball);
        // A uniform number in (-1, 1) is below 2 p - 1 with probability p.
        let below = |number: V, share: V| number.lt(share + share - V::one());
        let found = visible.and(below(symmetric[0], self.dropout).not());
        let wrong = below(symmetric[1], V::c(preset.false_share));

        let noise = preset.noise();
        let speed = (scene.ball_vel - scene.base_vel).norm();
        let expected = noise.deviation(speed, (*ball - base.pos).norm());
        let sigma = expected * self.noise_scale;
        let at = [normal[0].mul_add(sigma, ball.x()), normal[1].mul_add(sigma, ball.y())];
        // Something on the ground anywhere in the image.
        let eye = carrier.rot.mul_vec(camera.mount()) + carrier.pos;
        let ray = carrier.rot.mul_vec(camera.ray(symmetric[2], symmetric[3]));
        let depth = (eye.z() - self.radius) / (-ray.z()).max(V::c(1e-6));
        let other = [ray.x().mul_add(depth, eye.x()), ray.y().mul_add(depth, eye.y())];
        let within_range = (ray.norm() * depth).le(far).and(depth.gt(V::zero()));
        let other_expected =
            noise.deviation(scene.base_vel.norm(), (ray.scale(depth) + eye - base.pos).norm());

        let at = [0, 1].map(|k| V::select(wrong, other[k], at[k]));
        let expected = V::select(wrong, other_expected, expected);
        // Chosen by the false detection where there is one, else by the ball's.
        let yes = V::one();
        let seen =
            V::select(wrong, V::select(within_range, yes, V::zero()), V::select(found, yes, V::zero()));
        let finite = at[0].is_finite().and(at[1].is_finite());
        DelayedMeasurement {
            position: self.odometry.placed(at, [base.pos.x(), base.pos.y()]),
            variance: expected * expected,
            seen: V::select(due.and(finite), seen, V::zero()),
        }
    }

    /// What the tracker believes now, odometry frame; `to_strike_s` as in [`Eyes::look`].
    #[inline(always)]
    pub fn belief(&self, to_strike_s: V, preset: &EyesPreset) -> Belief<V> {
        self.tracker.belief(&Rolling { decay: self.decay, to_strike_s }, &preset.tracker)
    }

    /// The tracker's center of the ball with its height: a ball on flat ground `[m]`.
    #[inline(always)]
    pub fn on_the_ground(&self, position: [V; 2]) -> Vec3<V> {
        Vec3([position[0], position[1], self.radius])
    }

    /// The pose that odometry gives a base.
    #[inline(always)]
    pub fn estimated(&self, base: &BodyPose<V>) -> BodyPose<V> {
        let (pos, rot) = self.odometry.pose(base.pos, &base.rot);
        BodyPose { pos, rot }
    }
}
