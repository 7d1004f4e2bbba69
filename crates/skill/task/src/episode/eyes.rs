//! How onboard perception begins an episode.

use paid_lanes::Real;
use paid_lanes::rng::Rng;
use paid_track::{BallAtStart, Eyes, EyesStart};

use crate::config::TaskConfig;
use crate::episode::reset::Start;
use crate::scene::rolling::roll_decay;

/// Begins an episode of onboard perception in a lane.
pub(crate) fn begin_lane<V: Real>(
    eyes: &mut Eyes<V>,
    lane: usize,
    start: &Start,
    heading: f64,
    config: &TaskConfig,
    rng: &mut Rng,
) {
    let (ball, preset) = (&start.params.ball, &config.preset.eyes);
    let base = [start.state.base_pos[0], start.state.base_pos[1]];
    let (sin, cos) = heading.sin_cos();
    let local = |[x, y]: [f64; 2]| [cos * x + sin * y, cos * y - sin * x];
    let ball = BallAtStart {
        place: local([0, 1].map(|k| start.state.ball_pos[k] - base[k])),
        velocity: local([start.state.ball_vel[0], start.state.ball_vel[1]]),
        decay: roll_decay(ball),
        height_m: config.nominal_height_m,
    };
    let draw = preset.draw(rng);
    let elapsed_s = start.frame as f64 * config.dt_s;
    let radius_m = start.params.ball.radius_m;
    let start = EyesStart { draw, ball, heading, base, elapsed_s, radius_m };
    eyes.begin_lane(lane, &start, preset, rng);
}
