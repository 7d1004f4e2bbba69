//! A log as a chart: where the robot was, and how the run went over time.

use paid_plot::{Anchor, Chart, Figure, Rgb, Series};
use paid_runtime::State;
use paid_runtime::log::{Course, CoursePoint};

/// A ball last seen this long ago counts as remembered `[s]`.
const REMEMBERED_S: f64 = 0.2;
/// Size of the map, and its margin, in pixels.
const MAP: [i64; 2] = [900, 600];
const MARGIN: f64 = 60.0;
/// Height of the band of states in pixels.
const BAND: i64 = 90;

const INK: Rgb = [30, 30, 30];
const GRID: Rgb = [225, 228, 232];
const SEEN: Rgb = [40, 90, 200];
const REMEMBERED: Rgb = [230, 140, 20];
const GOAL: Rgb = [30, 130, 60];

fn color(state: State) -> Rgb {
    match state {
        State::Passive => [190, 196, 204],
        State::StandUp => [150, 110, 200],
        State::Ready => [90, 170, 230],
        State::Kick => [220, 70, 50],
        State::Settle => [240, 180, 60],
        State::Damping => [60, 60, 66],
    }
}

/// A map, the states, the tilt and the ball over time.
pub fn draw_course(course: &Course) -> Figure {
    let points = course.points();
    let band = band(points);
    let charts = [map(points), tilt(points), ball(points, 0), ball(points, 1)];
    let grid = Figure::tiled(&charts, 2);
    let mut all = Figure::new(grid.size()[0], grid.size()[1] + band.size()[1]);
    all.place([0, 0], &band);
    all.place([0, band.size()[1]], &grid);
    all
}

/// The states as colors, with their names.
fn band(points: &[CoursePoint]) -> Figure {
    let width = 2 * MAP[0];
    let mut figure = Figure::new(width, BAND);
    let end = points.last().map_or(1.0, |p| p.time_s.max(1e-3));
    let place = |time_s: f64| MARGIN + time_s / end * (width as f64 - 2.0 * MARGIN);
    for pair in points.windows(2) {
        let (from, to) = (place(pair[0].time_s), place(pair[1].time_s));
        let size = [(to.ceil() - from.floor()) as i64, 24];
        figure.rect([from.floor() as i64, 40], size, color(pair[0].state));
    }
    let kicks = points.last().map_or(0, |p| p.kicks);
    figure.text([MARGIN as i64, 26], 18, Anchor::Start, &format!("{end:.1} s, kicks: {kicks}"));
    let states = [State::Passive, State::StandUp, State::Ready, State::Kick, State::Settle, State::Damping];
    for (k, state) in states.into_iter().enumerate() {
        let x = 420 + 130 * k as i64;
        figure.rect([x, 14], [14, 14], color(state));
        figure.text([x + 20, 26], 14, Anchor::Start, &state.to_string());
    }
    figure
}

/// The pelvis from above, by odometry, with a dot where a kick began; the goal by its belief.
fn map(points: &[CoursePoint]) -> Figure {
    let mut figure = Figure::new(MAP[0], MAP[1]);
    figure.text([MARGIN as i64, 30], 20, Anchor::Start, "the pelvis by odometry [m]");
    let path: Vec<[f64; 2]> = points.iter().filter_map(|p| p.at).collect();
    let goals: Vec<[f64; 2]> = points.iter().filter_map(|p| p.goal).collect();
    let all = || path.iter().chain(&goals);
    let span = |k: usize| {
        let of = all().map(|p| p[k]);
        of.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], v| [lo.min(v), hi.max(v)])
    };
    let [x, y] = [span(0), span(1)];
    if x[0] > x[1] {
        figure.text([MARGIN as i64, 80], 14, Anchor::Start, "no odometry");
        return figure;
    }
    // As many pixels a meter in both directions; x to the right, y up.
    let room = MAP.map(|n| n as f64 - 2.0 * MARGIN);
    let meter = (room[0] / (x[1] - x[0]).max(1.0)).min(room[1] / (y[1] - y[0]).max(1.0));
    let place = |p: [f64; 2]| {
        let [mx, my] = [f64::midpoint(x[0], x[1]), f64::midpoint(y[0], y[1])];
        [0.5 * MAP[0] as f64 + (p[0] - mx) * meter, 0.5 * MAP[1] as f64 - (p[1] - my) * meter]
    };
    let every = spacing(meter);
    let lines = |range: [f64; 2]| {
        let [first, last] = [range[0] / every, range[1] / every];
        (first.floor() as i64..=last.ceil() as i64).map(move |v| v as f64 * every)
    };
    let within = |pixel: f64, size: i64| (MARGIN..=size as f64 - MARGIN).contains(&pixel);
    for v in lines(x) {
        let [px, _] = place([v, 0.0]);
        if !within(px, MAP[0]) {
            continue;
        }
        figure.line(vec![[px, MARGIN], [px, MAP[1] as f64 - MARGIN]], 1, GRID);
        figure.text([px as i64, MAP[1] - 36], 14, Anchor::Middle, &format!("{v:.0}"));
    }
    for v in lines(y) {
        let [_, py] = place([0.0, v]);
        if !within(py, MAP[1]) {
            continue;
        }
        figure.line(vec![[MARGIN, py], [MAP[0] as f64 - MARGIN, py]], 1, GRID);
        figure.text([50, py as i64 + 5], 14, Anchor::End, &format!("{v:.0}"));
    }
    goals.iter().for_each(|goal| figure.disc(place(*goal), 4.0, GOAL));
    figure.line(path.iter().map(|p| place(*p)).collect(), 2, INK);
    for pair in points.windows(2) {
        if let (true, Some(at)) = (pair[1].kicks > pair[0].kicks, pair[1].at) {
            figure.disc(place(at), 5.0, color(State::Kick));
        }
    }
    figure.colored_text([860, 30], 14, Anchor::End, GOAL, "goal");
    figure.colored_text([800, 30], 14, Anchor::End, color(State::Kick), "a kick begins");
    figure
}

fn tilt(points: &[CoursePoint]) -> Figure {
    let points = points.iter().map(|p| [p.time_s, p.tilt_rad]).collect();
    Chart {
        title: "pelvis from upright",
        x_label: "time [s]",
        y_label: "[rad]",
        logarithmic: false,
        series: vec![Series { points, color: INK, dots: false }],
    }
    .draw()
}

/// A coordinate of the ball's estimate over time.
fn ball(points: &[CoursePoint], k: usize) -> Figure {
    let of = |fresh: bool| {
        let known = points.iter().filter_map(|p| p.ball.map(|ball| (p.time_s, ball)));
        known
            .filter(|(_, (_, age_s))| (*age_s < REMEMBERED_S) == fresh)
            .map(|(time_s, (place, _))| [time_s, place[k]])
            .collect()
    };
    let title = ["ball ahead of the torso, estimated", "ball to its left"][k];
    let mut figure = Chart {
        title,
        x_label: "time [s]",
        y_label: "[m]",
        logarithmic: false,
        series: vec![
            Series { points: of(false), color: REMEMBERED, dots: true },
            Series { points: of(true), color: SEEN, dots: true },
        ],
    }
    .draw();
    figure.colored_text([700, 30], 14, Anchor::Start, SEEN, "seen");
    figure.colored_text([760, 30], 14, Anchor::Start, REMEMBERED, "remembered");
    figure
}

/// Meters from one line of the map to the next, so that their numbers have room; `meter`: the pixels of a meter.
fn spacing(meter: f64) -> f64 {
    /// Pixels of a number like -100 and of the gap to the next.
    const ROOM: f64 = 42.0;
    [1.0, 2.0, 5.0, 10.0, 20.0, 50.0].into_iter().find(|every| every * meter >= ROOM).unwrap_or(100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_the_map_have_room() {
        // A match of 11 stays within 13 m, one of 50 goes 32 m, on a map of 780 pixels.
        assert_eq!([60.0, 24.0, 17.0, 3.0, 0.5].map(spacing), [1.0, 2.0, 5.0, 20.0, 100.0]);
    }

    #[test]
    fn a_run_without_odometry_has_a_picture_that_says_so() {
        let svg = draw_course(&Course::default()).svg();
        assert!(svg.contains("no odometry") && svg.contains("kicks: 0"), "{svg}");
    }
}
