//! What the robot remembers of the balls around it, and which of them is its own.
//!
//! Every ball has a [`BallTracker`] of its own. A detection in an image goes to the ball that explains it best (the smallest negative log
//! likelihood within the tracker's gate); what fits none begins another one. Odds that a ball is there grow with every detection and fall
//! with every image that should have shown it and did not: a ball behind the robot's leg or outside the image keeps them. The robot keeps
//! to the ball that it has chosen until that one is lost.

use crate::{BallTracker, Belief, Measurement, MemoryPreset, Rolling, TrackerPreset};

/// How well a ball's place is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BallState {
    /// It is in the images.
    Seen,
    /// It was, and nothing contradicts its being where it should be.
    Remembered,
    /// It is not where it should be, was not seen for long, or could be anywhere.
    Lost,
}

impl BallState {
    /// As one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Seen => "seen",
            Self::Remembered => "remembered",
            Self::Lost => "lost",
        }
    }
}

/// A detection in an image.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Its place and age.
    pub measurement: Measurement<f64>,
    /// The detector's score, 0 to 1.
    pub score: f64,
}

/// One image, as far as balls go.
pub struct Glance<'a> {
    /// Time since its capture `[s]`.
    pub age_s: f64,
    /// What was found in it.
    pub finds: &'a [Candidate],
    /// Whether it would show a ball at a place (x, y) of the odometry frame `[m]`: inside the image and not behind the robot's body.
    pub shows: &'a dyn Fn([f64; 2]) -> bool,
}

/// The ball to kick.
#[derive(Clone, Copy, Debug)]
pub struct TrackedBall {
    /// Position, velocity, covariance, probability of rest and age.
    pub belief: Belief<f64>,
    /// How well it is known.
    pub state: BallState,
    /// Numbers the balls: another one has another number.
    pub id: u32,
}

#[derive(Clone, Debug)]
struct Ball {
    tracker: BallTracker<f64>,
    odds: f64,
    finds: usize,
    score: f64,
    id: u32,
}

/// The memory. Positions are those of the odometry frame.
///
/// ```
/// use paid_track::{BallMemory, BallState, Candidate, Glance, MemoryPreset, Measurement, Rolling, TrackerPreset};
///
/// let rolling = Rolling { decay: 0.0, to_strike_s: f64::INFINITY };
/// let mut memory = BallMemory::new(MemoryPreset::default(), TrackerPreset::default());
/// for _ in 0..5 {
///     memory.advance(0.04, 0.1, &rolling);
///     let measurement = Measurement { position: [1.0, 0.2], variance: 4e-4, age_s: 0.06, seen: true };
///     let finds = [Candidate { measurement, score: 0.9 }];
///     memory.look(&Glance { age_s: 0.06, finds: &finds, shows: &|_| true }, &rolling);
/// }
/// let ball = memory.own(&rolling).expect("five images of it");
/// assert!(ball.state == BallState::Seen && (ball.belief.ball.position[0] - 1.0).abs() < 1e-6);
/// ```
#[derive(Clone, Debug)]
pub struct BallMemory {
    preset: MemoryPreset,
    tracker: TrackerPreset,
    balls: Vec<Ball>,
    own: Option<u32>,
    next_id: u32,
}

impl BallMemory {
    /// A memory of nothing.
    pub fn new(preset: MemoryPreset, tracker: TrackerPreset) -> Self {
        Self { preset, tracker, balls: Vec::new(), own: None, next_id: 0 }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.balls.clear();
        self.own = None;
    }

    /// Time passes, as for [`BallTracker::advance`]. Only the ball to kick is struck.
    pub fn advance(&mut self, dt_s: f64, horizon_s: f64, rolling: &Rolling<f64>) {
        let own = self.own;
        for ball in &mut self.balls {
            let rolling = of_ball(own, ball.id, rolling);
            ball.tracker.advance(dt_s, horizon_s, &rolling, &self.tracker);
        }
    }

    /// Takes in an image. Returns the index of the detection that was taken for the ball to kick.
    pub fn look(&mut self, glance: &Glance<'_>, rolling: &Rolling<f64>) -> Option<usize> {
        let pairs = self.pairs(glance, rolling);
        let mut taken = vec![false; glance.finds.len()];
        let mut found = vec![None; self.balls.len()];
        for (_, ball, find) in pairs {
            if !taken[find] && found[ball].is_none() {
                (taken[find], found[ball]) = (true, Some(find));
            }
        }
        let mut of_own = None;
        for (ball, find) in self.balls.iter_mut().zip(&found) {
            let rolling = of_ball(self.own, ball.id, rolling);
            if let Some(index) = *find {
                let find = &glance.finds[index];
                ball.tracker.fuse(&find.measurement, &rolling, &self.tracker);
                ball.odds = (ball.odds * self.preset.found_factor).min(self.preset.most_odds);
                ball.finds += 1;
                ball.score += 0.1 * (find.score - ball.score);
                if self.own == Some(ball.id) {
                    of_own = Some(index);
                }
                continue;
            }
            let now = ball.tracker.belief(&rolling, &self.tracker).ball;
            let then = [0, 1].map(|k| now.position[k] - glance.age_s * now.velocity[k]);
            if (glance.shows)(then) {
                ball.odds *= self.preset.missed_factor;
            }
        }
        for (find, _) in glance.finds.iter().zip(&taken).filter(|(_, taken)| !**taken) {
            self.begin(find, rolling);
        }
        let (own, least) = (self.own, self.preset.lost_odds);
        self.balls.retain(|ball| own == Some(ball.id) || ball.odds >= least);
        self.choose(rolling);
        of_own
    }

    /// The ball to kick; `None` until one was found.
    pub fn own(&self, rolling: &Rolling<f64>) -> Option<TrackedBall> {
        let ball = self.balls.iter().find(|ball| Some(ball.id) == self.own)?;
        Some(self.known(ball, rolling))
    }

    /// Every confirmed ball, the one to kick among them.
    pub fn all(&self, rolling: &Rolling<f64>) -> Vec<TrackedBall> {
        self.balls
            .iter()
            .filter(|ball| self.is_confirmed(ball))
            .map(|ball| self.known(ball, &of_ball(self.own, ball.id, rolling)))
            .collect()
    }

    fn known(&self, ball: &Ball, rolling: &Rolling<f64>) -> TrackedBall {
        let mut belief = ball.tracker.belief(rolling, &self.tracker);
        let deviation = belief.ball.covariance[0].max(0.0).sqrt();
        // Between two images of a ball that is in them, a strike makes its place uncertain, not its presence.
        let state = if self.is_gone(ball, belief.age_s) {
            BallState::Lost
        } else if belief.age_s <= self.preset.seen_s {
            BallState::Seen
        } else if deviation > self.preset.lost_deviation_m {
            BallState::Lost
        } else {
            BallState::Remembered
        };
        belief.known = true;
        TrackedBall { belief, state, id: ball.id }
    }

    fn is_gone(&self, ball: &Ball, age_s: f64) -> bool {
        ball.odds < self.preset.lost_odds || age_s > self.preset.forget_s
    }

    fn is_confirmed(&self, ball: &Ball) -> bool {
        ball.finds >= self.preset.confirm
    }

    /// Detections that a ball explains: negative log likelihood, ball, detection; the likeliest first.
    fn pairs(&self, glance: &Glance<'_>, rolling: &Rolling<f64>) -> Vec<(f64, usize, usize)> {
        let mut pairs = Vec::new();
        for (b, ball) in self.balls.iter().enumerate() {
            let rolling = of_ball(self.own, ball.id, rolling);
            let now = ball.tracker.estimate(&rolling, &self.tracker);
            for (f, find) in glance.finds.iter().enumerate() {
                let variance = now.covariance[0] + find.measurement.variance;
                let apart = [0, 1].map(|k| {
                    let then = now.position[k] - find.measurement.age_s * now.velocity[k];
                    find.measurement.position[k] - then
                });
                let distance2 = (apart[0] * apart[0] + apart[1] * apart[1]) / variance;
                if distance2 <= self.tracker.gate * self.tracker.gate {
                    pairs.push((0.5 * distance2 + variance.ln(), b, f));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        pairs
    }

    /// A new ball; the least likely one makes room for it.
    fn begin(&mut self, find: &Candidate, rolling: &Rolling<f64>) {
        if self.balls.len() >= self.preset.most_balls {
            let own = self.own;
            let weakest = self
                .balls
                .iter()
                .enumerate()
                .filter(|(_, ball)| Some(ball.id) != own)
                .min_by(|a, b| a.1.odds.total_cmp(&b.1.odds))
                .map(|(index, _)| index);
            let Some(weakest) = weakest else { return };
            self.balls.remove(weakest);
        }
        let mut tracker = BallTracker::new();
        tracker.fuse(&find.measurement, &of_ball(None, 0, rolling), &self.tracker);
        self.balls.push(Ball { tracker, odds: 1.0, finds: 1, score: find.score, id: self.next_id });
        self.next_id += 1;
    }

    /// Keeps to the ball to kick; if there is none or it is gone, takes the surest.
    fn choose(&mut self, rolling: &Rolling<f64>) {
        let age = |ball: &Ball| {
            let rolling = of_ball(self.own, ball.id, rolling);
            ball.tracker.belief(&rolling, &self.tracker).age_s
        };
        let own = self.balls.iter().find(|ball| Some(ball.id) == self.own);
        if own.is_some_and(|ball| !self.is_gone(ball, age(ball))) {
            return;
        }
        let best = self
            .balls
            .iter()
            .filter(|ball| self.is_confirmed(ball) && !self.is_gone(ball, age(ball)) && ball.odds > 1.0)
            .max_by(|a, b| (a.odds * a.score).total_cmp(&(b.odds * b.score)))
            .map(|ball| ball.id);
        let Some(best) = best else { return };
        let old = self.own.replace(best);
        self.balls.retain(|ball| Some(ball.id) != old || ball.id == best);
    }
}

/// Another ball than the one to kick is not struck.
fn of_ball(own: Option<u32>, id: u32, rolling: &Rolling<f64>) -> Rolling<f64> {
    if own == Some(id) { *rolling } else { Rolling { to_strike_s: f64::INFINITY, ..*rolling } }
}
