//! A random place to play: floor, light, ball and cameras of one robot's kick.

use paid_lanes::rng::Rng;

use super::draw::Draw;
use super::{Scatter, Use, robot_colors, things};
use crate::render::{BallPaint, BallPattern, ColorSensor, DepthSensor, Ground, Light, V3};

/// What a place looks like, and through which cameras.
#[derive(Clone, Debug)]
pub struct Place {
    /// The floor at height 0.
    pub ground: Ground,
    /// Lamp and sky.
    pub light: Light,
    /// Colors above the horizon, low and high, linear.
    pub background: [V3; 2],
    /// The ball.
    pub ball: BallPaint,
    /// Shells and joints of the robot.
    pub robot_colors: [V3; 2],
    /// The color camera.
    pub color: ColorSensor,
    /// The depth camera.
    pub depth: DepthSensor,
    /// How long an image gathers light `[s]`.
    pub exposure_s: f64,
}

/// Random stream of places.
const STREAM: u32 = 3;

impl Scatter {
    /// The place of this number: the same for the same seed and number, unlike every scene of training. There is no clutter in it.
    pub fn place(&self, number: u32) -> Place {
        let mut draw = Draw(Rng::new(self.seed, number, STREAM));
        let patterns: &[BallPattern] = match self.purpose {
            Use::Training => &BallPattern::ALL[..3],
            Use::HeldOut => &BallPattern::ALL,
        };
        let light = things::light(&mut draw);
        let exposure_s = draw.between(0.002, 0.012);
        let ball = things::ball_paint(&mut draw, patterns);
        let colors = robot_colors(&mut draw);
        let color = things::color_sensor(&mut draw, &light, [0.0; 2]);
        let depth = things::depth_sensor(&mut draw);
        let background = [draw.color([0.0, 0.4], [0.1, 0.8]), draw.color([0.0, 0.4], [0.1, 0.9])];
        let ground = things::ground(&mut draw);
        Place { ground, light, background, ball, robot_colors: colors, color, depth, exposure_s }
    }
}
