//! The plots of a set of kicks.

use paid_plot::{Anchor, Chart, Figure, Floor, HeatMap, Rgb, Series, color_of};

use super::{Dataset, Kick};

const INK: Rgb = [30, 30, 30];
const HOLE: Rgb = [214, 39, 40];
/// Height or width of a floor in pixels.
const FLOOR: f64 = 620.0;
/// Width of the legend without its texts, and of one of their characters, and height of its lines, in pixels.
const LEGEND: i64 = 90;
const CHARACTER: i64 = 8;
const LINE: i64 = 24;
/// Pixels between the points of a way.
const APART: f64 = 4.0;
/// Half the side of a square of the grid in the coverage plot `[m]`.
const HALF_CELL: f64 = 0.5;

/// A kick's color: hues a golden angle apart, so that neighbors in the list differ most, in three brightnesses.
fn color_of_kick(i: usize) -> Rgb {
    let hue = (i as f64 * 137.508 / 60.0) % 6.0;
    let value = [210.0, 150.0, 240.0][i % 3];
    [5.0, 3.0, 1.0].map(|n| {
        let k: f64 = (n + hue) % 6.0;
        (value * (1.0 - 0.75 * k.min(4.0 - k).clamp(0.0, 1.0))).round() as u8
    })
}

fn pale(color: Rgb) -> Rgb {
    color.map(|c| (255.0 - 0.25 * (255.0 - f64::from(c))).round() as u8)
}

/// A plot with the list of kicks on its right.
fn with_legend(set: &Dataset, picture: &Figure, about: impl Fn(&Kick) -> String) -> Figure {
    let [width, height] = picture.size();
    let texts: Vec<String> = set.kicks.iter().map(|k| format!("{} {}", k.name, about(k))).collect();
    let longest = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0) as i64;
    let legend = LEGEND + CHARACTER * longest;
    let mut figure = Figure::new(width + legend, height.max(80 + LINE * set.kicks.len() as i64));
    figure.place([0, 0], picture);
    for (row, (i, text)) in (0..).zip(texts.iter().enumerate()) {
        let y = 72 + LINE * row;
        figure.rect([width + 8, y - 12], [14, 14], color_of_kick(i));
        figure.text([width + 52, y], 14, Anchor::End, &(i + 1).to_string());
        figure.text([width + 62, y], 14, Anchor::Start, text);
    }
    figure
}

fn place_text(kick: &Kick) -> String {
    format!("({}) {:.2}, {:.2}", kick.leg, kick.place[0], kick.place[1])
}

/// A kick's place with its number.
fn mark(figure: &mut Figure, at: [f64; 2], i: usize) {
    figure.disc(at, 7.0, INK);
    figure.disc(at, 5.0, color_of_kick(i));
    figure.text([at[0] as i64 + 10, at[1] as i64 + 5], 14, Anchor::Start, &(i + 1).to_string());
}

/// The base's ways over the floor, time as color.
pub(super) fn trajectories(set: &Dataset) -> Figure {
    let points = set.kicks.iter().flat_map(|k| k.path.iter().copied().chain([k.place]));
    let floor = Floor::around(points, FLOOR);
    let mut figure = floor.figure("paths of the base (color: time) and balls of the kicks");
    for kick in &set.kicks {
        let last = (kick.path.len() - 1).max(1) as f64;
        let mut from = kick.path.first().map(|p| floor.place(*p));
        for (t, point) in kick.path.iter().enumerate() {
            let to = floor.place(*point);
            if let Some(begin) = from
                && (begin[0] - to[0]).hypot(begin[1] - to[1]) >= APART
            {
                figure.line(vec![begin, to], 3, color_of(t as f64 / last));
                from = Some(to);
            }
        }
    }
    for (i, kick) in set.kicks.iter().enumerate() {
        mark(&mut figure, floor.place(kick.place), i);
    }
    let height = figure.size()[1];
    let (bar, steps) = (160, 40);
    for k in 0..steps {
        let x = 110 + bar * k / steps;
        figure.rect([x, height - 18], [bar / steps, 10], color_of(k as f64 / (steps - 1) as f64));
    }
    figure.text([100, height - 8], 14, Anchor::End, "begin");
    figure.text([120 + bar, height - 8], 14, Anchor::Start, "end of the clip");
    with_legend(set, &figure, place_text)
}

/// An arc's points, from one angle to another `[rad]`.
fn arc(radius: f64, [from, to]: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    const STEPS: u32 = 16;
    (0..=STEPS).map(move |k| {
        let (s, c) = (from + (to - from) * f64::from(k) / f64::from(STEPS)).sin_cos();
        [radius * c, radius * s]
    })
}

/// The regions of balls and the kicks' places.
pub(super) fn placement(set: &Dataset) -> Figure {
    let half = set.sector.angle_deg.to_radians();
    let sectors: Vec<([f64; 2], [f64; 2])> = set
        .kicks
        .iter()
        .map(|kick| {
            let [x, y] = kick.place;
            let (angle, radius) = (y.atan2(x), x.hypot(y));
            let radii = [(radius - set.sector.radius_m).max(0.0), radius + set.sector.radius_m];
            (radii, [angle - half, angle + half])
        })
        .collect();
    let outline = |(radii, angles): &([f64; 2], [f64; 2])| {
        let mut line: Vec<[f64; 2]> = arc(radii[1], *angles).collect();
        line.extend(arc(radii[0], [angles[1], angles[0]]));
        line.extend(line.first().copied());
        line
    };
    let floor = Floor::around(sectors.iter().flat_map(&outline), FLOOR);
    let Dataset { sector, .. } = set;
    let title = format!(
        "balls of each kick: {:.0} degrees and {:.2} m around its own",
        sector.angle_deg, sector.radius_m
    );
    let mut figure = floor.figure(&title);
    let [begin, end] = [[0.0, 0.0], [0.15, 0.0]].map(|p| floor.place(p));
    let placed = |line: Vec<[f64; 2]>| line.into_iter().map(|p| floor.place(p)).collect::<Vec<_>>();
    for (i, (radii, angles)) in sectors.iter().enumerate() {
        // Arcs two pixels apart and three wide fill the sector.
        let rings = ((radii[1] - radii[0]) * floor.scale / 2.0).ceil().max(1.0) as u32;
        for k in 0..=rings {
            let radius = radii[0] + (radii[1] - radii[0]) * f64::from(k) / f64::from(rings);
            figure.line(placed(arc(radius, *angles).collect()), 3, pale(color_of_kick(i)));
        }
    }
    for (i, sector) in sectors.iter().enumerate() {
        figure.line(placed(outline(sector)), 2, color_of_kick(i));
    }
    for (i, kick) in set.kicks.iter().enumerate() {
        mark(&mut figure, floor.place(kick.place), i);
    }
    figure.line(vec![begin, end], 4, INK);
    figure.disc(begin, 6.0, INK);
    with_legend(set, &figure, place_text)
}

/// Speed of the kicking foot over phase; a dot where it strikes.
pub(super) fn foot_speed(set: &Dataset) -> Figure {
    let mut series = Vec::new();
    for (i, kick) in set.kicks.iter().enumerate() {
        let last = (kick.foot_speed.len() - 1).max(1) as f64;
        let points: Vec<[f64; 2]> =
            kick.foot_speed.iter().enumerate().map(|(t, v)| [t as f64 / last, *v]).collect();
        series.push(Series { points, color: color_of_kick(i), dots: false });
    }
    for (i, kick) in set.kicks.iter().enumerate() {
        let last = kick.foot_speed.len() - 1;
        let strike = ((kick.strike_phase * last as f64).round() as usize).min(last);
        for color in [INK, color_of_kick(i)] {
            let points = vec![[kick.strike_phase, kick.foot_speed[strike]]];
            series.push(Series { points, color, dots: true });
        }
    }
    let chart = Chart {
        title: "speed of the kicking foot (dot: the strike)",
        x_label: "phase of the clip, 0 to 1",
        y_label: "speed [m/s]",
        logarithmic: false,
        series,
    };
    with_legend(set, &chart.draw(), |kick| {
        format!("({}) {:.1} m/s at {:.2}", kick.leg, kick.peak_foot_speed, kick.strike_phase)
    })
}

/// Which kick takes which place of the workspace, and how far its own place is.
pub(super) fn coverage(set: &Dataset) -> Figure {
    let coverage = &set.coverage;
    let grid = coverage.grid;
    let (x, y) = (grid.places(grid.x), grid.places(grid.y));
    let margin = HALF_CELL * grid.step;
    let corners = [0, 1].map(|k| {
        let out = if k == 0 { -margin } else { margin };
        [grid.x[k] + out, grid.y[k] + out]
    });
    let floor = Floor::around(set.kicks.iter().map(|kick| kick.place).chain(corners), FLOOR);
    let mut left = floor.figure("which kick takes which ball (frame: a hole, cross: record here)");
    // A kick that ends far away leaves little room for the grid.
    let side = ((grid.step * floor.scale).round() as i64 - 2).max(1);
    for cell in &coverage.cells {
        let at = floor.place([cell.place[0] + margin, cell.place[1] + margin]).map(|n| n.round() as i64);
        if cell.distance_m > coverage.reach_m {
            left.rect(at, [side, side], HOLE);
            if side > 6 {
                left.rect([at[0] + 3, at[1] + 3], [side - 6, side - 6], pale(color_of_kick(cell.kick)));
            }
        } else {
            left.rect(at, [side, side], pale(color_of_kick(cell.kick)));
        }
        let text = (cell.kick + 1).to_string();
        left.text([at[0] + side - 5, at[1] + side - 5], 14, Anchor::End, &text);
    }
    for (i, kick) in set.kicks.iter().enumerate() {
        mark(&mut left, floor.place(kick.place), i);
    }
    if let Some(next) = &coverage.next {
        let [px, py] = floor.place(next.ball);
        for (dx, dy) in [(12.0, 12.0), (12.0, -12.0)] {
            left.line(vec![[px - dx, py - dy], [px + dx, py + dy]], 5, HOLE);
        }
    }
    let heat = HeatMap {
        title: "distance to the nearest kick's ball [cm]".to_owned(),
        values: coverage
            .cells
            .chunks(y.len())
            .map(|row| row.iter().map(|c| Some(c.distance_m)).collect())
            .collect(),
        x,
        y,
        low: 0.0,
        high: 2.0 * coverage.reach_m,
        print: (100.0, 0),
    };
    let left = with_legend(set, &left, place_text);
    let right = heat.figure();
    let ([w, h], [rw, rh]) = (left.size(), right.size());
    let mut figure = Figure::new(w + rw, h.max(rh));
    figure.place([0, 0], &left);
    figure.place([w, 0], &right);
    figure
}

#[cfg(test)]
mod tests {
    use paid_motion::KickLeg;

    use super::*;
    use crate::dataset::{Coverage, Sector};
    use paid_eval::shooting::Grid;

    #[test]
    fn a_kick_that_ends_far_away_leaves_no_square_of_negative_size() {
        let kick = Kick {
            name: "far".to_owned(),
            leg: KickLeg::Right,
            place: [60.0, 0.0],
            strike_phase: 0.5,
            peak_foot_speed: 3.0,
            path: vec![[0.0; 2], [60.0, 0.0]],
            foot_speed: vec![0.0, 3.0],
        };
        let covered = Coverage::of(std::slice::from_ref(&kick), Grid::EFFECTIVE);
        let sector = Sector { angle_deg: 20.0, radius_m: 0.25 };
        let svg = coverage(&Dataset { kicks: vec![kick], sector, coverage: covered }).svg();
        assert!(!svg.contains("width=\"-") && !svg.contains("height=\"-"), "{svg}");
    }

    #[test]
    fn the_colors_of_a_paper_sized_set_differ() {
        let colors: Vec<Rgb> = (0..13).map(color_of_kick).collect();
        for (i, a) in colors.iter().enumerate() {
            for b in &colors[..i] {
                let apart: u32 = (0..3).map(|k| u32::from(a[k].abs_diff(b[k]))).sum();
                assert!(apart > 40, "{a:?} {b:?}");
            }
        }
        assert_eq!(pale([255, 55, 255]), [255, 205, 255]);
    }

    #[test]
    fn an_arc_keeps_its_distance_and_turns_left_with_growing_angles() {
        let points: Vec<[f64; 2]> = arc(2.0, [0.0, std::f64::consts::FRAC_PI_2]).collect();
        assert_eq!(points.len(), 17);
        assert!(points.iter().all(|[x, y]| (x.hypot(*y) - 2.0).abs() < 1e-12));
        assert!(points[0][1].abs() < 1e-12 && (points[16][1] - 2.0).abs() < 1e-12);
    }
}
