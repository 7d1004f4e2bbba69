//! Where and when the feet stand: from standing at the origin to a plant foot beside the ball, the kick, and a stand where
//! the ball was. Everything here is for a right-footed kick; the left-footed one is its mirror image.

use super::{Figure, GenerateError, KickStyle, Knot, Track};

/// Frames a second of generated clips.
pub const FPS: f64 = 50.0;
/// Radius of a size-5 ball [m].
pub const BALL_RADIUS: f64 = 0.11;
/// Distance of the goal from the start, along +x [m].
pub const GOAL_DISTANCE: f64 = 5.0;
/// Position of the plant foot and of the kicking foot in pairs.
pub const PLANT: usize = 0;
/// See [`PLANT`].
pub const KICK: usize = 1;

/// Longest distance of the two ankles along the feet when one comes down [m]: what the legs reach at walking height.
const LONGEST_STRIDE: f64 = 0.38;
/// Least and largest distance across [m]: shins that do not touch; ankles that lean no farther than they can.
const ACROSS: [f64; 2] = [0.16, 0.315];
/// Largest turn of the feet on the way [rad].
const LARGEST_TURN: f64 = 0.70;
/// Longest way of one foot in one step [m].
const LONGEST_STEP: f64 = 0.72;
/// Turns of the last pair before the plant foot's step that are tried [rad]; a large positive one would have the kicking foot
/// in the ball.
const TAKE_OFF_TURNS: [f64; 7] = [0.0, 0.15, -0.15, -0.3, -0.45, -0.6, 0.25];
/// Nearest and farthest ball [m], and its largest angle off the heading [rad].
const RING: ([f64; 2], f64) = ([0.55, 2.0], 0.9);

/// A foot flat on the floor: the point below its frame's origin [m] and its heading [rad], world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foothold {
    /// Position x, y [m].
    pub xy: [f64; 2],
    /// Heading [rad].
    pub yaw: f64,
}

impl Foothold {
    /// A point given in the foot's axes [m], in the world.
    pub fn point(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (s, c) = self.yaw.sin_cos();
        [self.xy[0] + c * x - s * y, self.xy[1] + s * x + c * y]
    }
}

/// A foot in the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// [`PLANT`] or [`KICK`].
    pub foot: usize,
    /// It leaves the floor [s].
    pub lift: f64,
    /// It is down again [s].
    pub land: f64,
    /// Where it came from.
    pub from: Foothold,
    /// Where it goes.
    pub to: Foothold,
}

/// The moments of the kick [s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KickTimes {
    /// The foot leaves the floor.
    pub lift: f64,
    /// It turns from back-swing to strike.
    pub back: f64,
    /// It meets the ball.
    pub contact: f64,
    /// It comes to rest in front.
    pub through: f64,
    /// It is down again.
    pub land: f64,
}

/// Feet and their times.
#[derive(Clone, Debug)]
pub struct Plan {
    /// First footholds.
    pub start: [Foothold; 2],
    /// All swings in order; the kick is the last but one.
    pub swings: Vec<Swing>,
    /// Moments of the kick.
    pub kick: KickTimes,
    /// Ball [m], world.
    pub ball: [f64; 2],
    /// Heading of the shot [rad], world.
    pub aim: f64,
    /// Last frame [s].
    pub end: f64,
}

impl Plan {
    /// The plan for a ball at `ball`, as seen from the anchor's start (x forward, y left) [m]; `start_x` is where the feet
    /// start along x so that the anchor starts at the origin.
    ///
    /// # Errors
    /// A ball that cannot be reached in good steps.
    pub fn new(
        figure: &Figure<'_>,
        style: &KickStyle,
        ball: [f64; 2],
        start_x: f64,
    ) -> Result<Self, GenerateError> {
        let ([near, far], widest) = RING;
        let (radius, angle) = (ball[0].hypot(ball[1]), ball[1].atan2(ball[0]));
        if !(near..=far).contains(&radius) || angle.abs() > widest {
            return Err(GenerateError::Ball { ball, near, far, degrees: widest.to_degrees() });
        }
        let aim = (-ball[1]).atan2(GOAL_DISTANCE - ball[0]);
        let half = figure.stance().1;
        let stand =
            |at: [f64; 2]| [half, -half].map(|y| Foothold { xy: [at[0] + start_x, at[1] + y], yaw: 0.0 });
        let (start, finish) = (stand([0.0; 2]), stand(ball));
        let beside = Foothold { xy: ball, yaw: aim };
        let plant = Foothold { xy: beside.point(style.plant), yaw: aim };

        let mut clock = Clock(0.60);
        let mut swings = Vec::new();
        let mut at = start;
        let approach = approach(start, plant, style.take_off).ok_or(GenerateError::Ball {
            ball,
            near,
            far,
            degrees: widest.to_degrees(),
        })?;
        for (foot, to) in approach {
            swings.push(clock.step(foot, at[foot], to));
            at[foot] = to;
        }
        let lift = clock.0;
        let back = lift + frames(0.36);
        let contact = back + frames(2.0 * style.back / style.speed);
        let through = contact + frames(2.0 * style.through / style.speed);
        let land = through + frames(0.42);
        swings.push(Swing { foot: KICK, lift, land, from: at[KICK], to: finish[KICK] });
        clock.0 = land + frames(0.18);
        swings.push(clock.step(PLANT, plant, finish[PLANT]));
        let kick = KickTimes { lift, back, contact, through, land };
        Ok(Self { start, swings, kick, ball, aim, end: clock.0 + frames(0.90) })
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        (self.end * FPS).round() as usize + 1
    }

    /// Headings of the base: the middle of both feet's whenever one has come down: time [s], angle [rad].
    pub fn headings(&self) -> Vec<(f64, f64)> {
        let mut feet = self.start;
        let mut out = vec![(self.swings[0].lift - 0.2, 0.0)];
        for swing in &self.swings {
            feet[swing.foot] = swing.to;
            out.push((swing.land, f64::midpoint(feet[0].yaw, feet[1].yaw)));
        }
        out
    }

    /// Where the centre of pressure should be: the middle of the sole that stands, moving over while both do [m].
    pub fn pressure(&self, figure: &Figure<'_>) -> Track<2> {
        let centre = figure.sole_centre();
        let middle = |feet: [Foothold; 2]| {
            let [a, b] = feet.map(|f| f.point([centre, 0.0]));
            [f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1])]
        };
        let mut feet = self.start;
        let mut knots = vec![(0.14, middle(feet))];
        for swing in &self.swings {
            let stands = feet[1 - swing.foot].point([centre, 0.0]);
            knots.extend([(swing.lift, stands), (swing.land, stands)]);
            feet[swing.foot] = swing.to;
        }
        let last = self.swings.last().map_or(0.0, |s| s.land);
        knots.push((last + 0.40, middle(feet)));
        Track::resting(&knots)
    }

    /// Soles on the floor at time `t`: their corner points, world [m].
    pub fn support(&self, figure: &Figure<'_>, t: f64) -> Vec<[f64; 2]> {
        let (mut feet, mut aloft) = (self.start, [false; 2]);
        for swing in self.swings.iter().filter(|s| t > s.lift + 1e-9) {
            feet[swing.foot] = swing.to;
            aloft[swing.foot] = t < swing.land - 1e-9;
        }
        (0..2)
            .filter(|&i| !aloft[i])
            .flat_map(|i| figure.soles[i].iter().map(move |p| feet[i].point([p[0], p[1]])))
            .collect()
    }

    /// The swing that kicks.
    pub fn kick_swing(&self) -> &Swing {
        &self.swings[self.swings.len() - 2]
    }

    /// Way of the toe while it kicks, world [m], from lift to landing.
    pub fn toe_way(&self, figure: &Figure<'_>, style: &KickStyle) -> Track<3> {
        let [x, y, z] = figure.toe[KICK];
        let down = figure.sole_height() + z;
        let stand = |hold: Foothold| {
            let [px, py] = hold.point([x, y]);
            [px, py, down]
        };
        let beside = Foothold { xy: self.ball, yaw: self.aim };
        let meets = -(BALL_RADIUS + figure.toe_radius);
        let near = |along: f64, left: f64, height: f64| {
            let [px, py] = beside.point([meets + along, left]);
            [px, py, height]
        };
        let (s, c) = self.aim.sin_cos();
        let Swing { from, to, .. } = *self.kick_swing();
        let rest = |t: f64, pos: [f64; 3]| Knot { t, pos, vel: [0.0; 3] };
        Track::new(vec![
            rest(self.kick.lift, stand(from)),
            rest(self.kick.back, near(-style.back, style.back_side, style.back_height)),
            Knot {
                t: self.kick.contact,
                pos: near(0.0, 0.0, style.strike_height),
                vel: [style.speed * c, style.speed * s, 0.0],
            },
            rest(self.kick.through, near(style.through, 0.04, style.through_height)),
            rest(self.kick.land, stand(to)),
        ])
    }
}

/// A whole number of frames of about `seconds` [s].
fn frames(seconds: f64) -> f64 {
    (seconds * FPS).round().max(1.0) / FPS
}

/// The next moment at which a foot may leave the floor [s].
struct Clock(f64);

impl Clock {
    fn step(&mut self, foot: usize, from: Foothold, to: Foothold) -> Swing {
        let way = (to.xy[0] - from.xy[0]).hypot(to.xy[1] - from.xy[1]);
        let lift = self.0;
        let land = lift + frames((0.34 + 0.24 * way).min(0.52));
        self.0 = land + frames(0.14);
        Swing { foot, lift, land, from, to }
    }
}

/// A walk: which foot goes where, in order.
type Walk = Vec<(usize, Foothold)>;

/// The fewest good steps from `start` to the plant foot, the last; the kicking foot's last hold is `take_off` from it [m], in the
/// axes of a pair that may be turned a little. On the way the feet may turn towards the goal of the walk, so that a ball at the
/// side is walked to and not only side-stepped to.
fn approach(start: [Foothold; 2], plant: Foothold, take_off: [f64; 2]) -> Option<Walk> {
    let mut best: Option<(f64, Walk)> = None;
    for turn in TAKE_OFF_TURNS {
        let turned = Foothold { xy: plant.xy, yaw: plant.yaw + turn };
        let goal = [plant, Foothold { xy: turned.point(take_off), yaw: turned.yaw }];
        let middle = |feet: [Foothold; 2]| [0, 1].map(|i| f64::midpoint(feet[PLANT].xy[i], feet[KICK].xy[i]));
        let (from, to) = (middle(start), middle(goal));
        let heading = (to[1] - from[1]).atan2(to[0] - from[0]);
        for share in [0.0, 0.2, 0.4, 0.6, 0.8] {
            let heading = (share * heading).clamp(-LARGEST_TURN, LARGEST_TURN);
            for (steps, first) in (1..=6).flat_map(|n| [(n, KICK), (n, PLANT)]) {
                let walk = walk(start, goal, heading, first, steps);
                let Some(longest) = effort(start, &walk) else { continue };
                // A step costs a second; a turn or a long stride only decides between equals.
                let cost = walk.len() as f64 + longest + 0.5 * (heading.abs() + turn.abs());
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    best = Some((cost, walk));
                }
            }
        }
    }
    best.map(|(_, walk)| walk)
}

/// `steps` steps of the plant foot and as many of the other, or one less, spread evenly, under way at `heading`.
fn walk(start: [Foothold; 2], goal: [Foothold; 2], heading: f64, first: usize, steps: usize) -> Walk {
    let half = 0.5 * (start[PLANT].xy[1] - start[KICK].xy[1]);
    let side = [half, -half];
    let counts = [steps, if first == KICK { steps } else { steps - 1 }];
    let mut done = [0, 0];
    let mut out = Vec::new();
    for i in 0..counts[0] + counts[1] {
        let foot = if i % 2 == 0 { first } else { 1 - first };
        done[foot] += 1;
        let share = done[foot] as f64 / counts[foot] as f64;
        if done[foot] == counts[foot] {
            out.push((foot, goal[foot]));
            continue;
        }
        // The middle of a pair of which this foot is one.
        let (a, b) = (start[foot].point([0.0, -side[foot]]), goal[foot].point([0.0, -side[foot]]));
        let turned = share * share;
        let pair = Foothold {
            xy: [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])],
            yaw: heading + turned * (goal[foot].yaw - heading),
        };
        out.push((foot, Foothold { xy: pair.point([0.0, side[foot]]), yaw: pair.yaw }));
    }
    out
}

/// The longest stride of a walk [m], or nothing if a step is no good.
fn effort(start: [Foothold; 2], walk: &Walk) -> Option<f64> {
    let mut at = start;
    let mut longest: f64 = 0.0;
    for &(foot, to) in walk {
        let way = (to.xy[0] - at[foot].xy[0]).hypot(to.xy[1] - at[foot].xy[1]);
        at[foot] = to;
        let (s, c) = f64::midpoint(at[0].yaw, at[1].yaw).sin_cos();
        let apart = [at[PLANT].xy[0] - at[KICK].xy[0], at[PLANT].xy[1] - at[KICK].xy[1]];
        let (along, across) = (c * apart[0] + s * apart[1], c * apart[1] - s * apart[0]);
        longest = longest.max(along.abs());
        let good = along.abs() <= LONGEST_STRIDE
            && (ACROSS[0]..=ACROSS[1]).contains(&across)
            && (at[0].yaw - at[1].yaw).abs() <= LARGEST_TURN
            && way <= LONGEST_STEP;
        if !good {
            return None;
        }
    }
    Some(longest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_leg_takes_a_stride_it_cannot() {
        let start = [0.12, -0.12].map(|y| Foothold { xy: [0.0, y], yaw: 0.0 });
        for (x, y, yaw) in [(0.5, 0.2, 0.0), (0.4, -0.3, 0.1), (1.2, -0.3, 0.2), (0.5, 0.6, -0.1)] {
            let plant = Foothold { xy: [x, y], yaw };
            let walk = approach(start, plant, [-0.25, -0.24]).expect("a way");
            assert_eq!(walk.last(), Some(&(PLANT, plant)));
            assert!(walk.windows(2).all(|pair| pair[0].0 != pair[1].0), "feet alternate");
            assert!(effort(start, &walk).is_some_and(|longest| longest <= LONGEST_STRIDE));
        }
        let far = Foothold { xy: [4.5, 0.0], yaw: 0.0 };
        assert!(approach(start, far, [-0.25, -0.24]).is_none());
    }
}
