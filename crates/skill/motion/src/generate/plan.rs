//! Where and when the feet stand: from standing at the origin to a plant foot next to the ball, the kick, and a stand where
//! the ball was. Everything here is for a right-footed kick; the left-footed one is its mirror image.

use super::walk::approach;
use super::{Biped, GenerateError, KickStyle, Knot, Track};

/// Frames a second of generated clips.
pub const FPS: f64 = 50.0;
/// Radius of a size-5 ball `[m]`.
pub const BALL_RADIUS: f64 = 0.11;
/// Distance of the goal from the start, along +x `[m]`.
pub const GOAL_DISTANCE: f64 = 5.0;
/// Position of the plant foot and of the kicking foot in pairs.
pub const PLANT: usize = 0;
/// See [`PLANT`].
pub const KICK: usize = 1;

/// Nearest and farthest ball `[m]`, and its largest angle off the heading `[rad]`.
const RING: ([f64; 2], f64) = ([0.55, 2.0], 0.9);

/// A foot flat on the floor: the point below its frame's origin `[m]` and its heading `[rad]`, world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foothold {
    /// Position x, y `[m]`.
    pub xy: [f64; 2],
    /// Heading `[rad]`.
    pub yaw: f64,
}

impl Foothold {
    /// A point given in the foot's axes `[m]`, in the world.
    pub fn point(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (s, c) = self.yaw.sin_cos();
        [self.xy[0] + c * x - s * y, self.xy[1] + s * x + c * y]
    }
}

/// A foot in the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swing {
    /// 0 the plant foot, 1 the kicking foot.
    pub foot: usize,
    /// It leaves the floor `[s]`.
    pub lift: f64,
    /// It is down again `[s]`.
    pub land: f64,
    /// Where it came from.
    pub from: Foothold,
    /// Where it goes.
    pub to: Foothold,
}

/// The moments of the kick `[s]`.
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
    /// Ball `[m]`, world.
    pub ball: [f64; 2],
    /// Heading of the shot `[rad]`, world.
    pub aim: f64,
    /// Last frame `[s]`.
    pub end: f64,
}

impl Plan {
    /// The plan for a ball at `ball`, as seen from the anchor's start (x forward, y left) `[m]`; `start_x` is where the feet
    /// start along x so that the anchor starts at the origin; `extra_steps` are taken beyond the fewest.
    ///
    /// # Errors
    /// A ball that cannot be reached in good steps.
    pub fn new(
        figure: &Biped<'_>,
        style: &KickStyle,
        ball: [f64; 2],
        start_x: f64,
        extra_steps: usize,
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
        let approach = approach(start, plant, style.take_off, extra_steps).ok_or(GenerateError::Ball {
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

    /// Headings of the base: the middle of both feet's whenever one has come down: time `[s]`, angle `[rad]`.
    pub fn headings(&self) -> Vec<(f64, f64)> {
        let mut feet = self.start;
        let mut out = vec![(self.swings[0].lift - 0.2, 0.0)];
        for swing in &self.swings {
            feet[swing.foot] = swing.to;
            out.push((swing.land, f64::midpoint(feet[0].yaw, feet[1].yaw)));
        }
        out
    }

    /// Where the center of pressure should be: the middle of the sole that stands, moving over while both do `[m]`.
    pub fn pressure(&self, figure: &Biped<'_>) -> Track<2> {
        let center = figure.sole_center();
        let middle = |feet: [Foothold; 2]| {
            let [a, b] = feet.map(|f| f.point([center, 0.0]));
            [f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1])]
        };
        let mut feet = self.start;
        let mut knots = vec![(0.14, middle(feet))];
        for swing in &self.swings {
            let stands = feet[1 - swing.foot].point([center, 0.0]);
            knots.extend([(swing.lift, stands), (swing.land, stands)]);
            feet[swing.foot] = swing.to;
        }
        let last = self.swings.last().map_or(0.0, |s| s.land);
        knots.push((last + 0.40, middle(feet)));
        Track::resting(&knots)
    }

    /// Soles on the floor at time `t`: their corner points, world `[m]`.
    pub fn support(&self, figure: &Biped<'_>, t: f64) -> Vec<[f64; 2]> {
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

    /// Way of the toe while it kicks, world `[m]`, from lift to landing.
    pub fn toe_way(&self, figure: &Biped<'_>, style: &KickStyle) -> Track<3> {
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
            rest(self.kick.through, near(style.through, style.through_side, style.through_height)),
            rest(self.kick.land, stand(to)),
        ])
    }
}

/// A whole number of frames of about `seconds` `[s]`.
fn frames(seconds: f64) -> f64 {
    (seconds * FPS).round().max(1.0) / FPS
}

/// The next moment at which a foot may leave the floor `[s]`.
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
