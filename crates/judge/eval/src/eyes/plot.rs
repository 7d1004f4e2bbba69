//! The course of one kick: where the ball was, where it was seen, where it was believed.

use paid_plot::{Anchor, Chart, Figure, Rgb, Series};

use super::KickLog;

const TRUTH: Rgb = [30, 30, 30];
const SEEN: Rgb = [30, 130, 60];
const OTHER: Rgb = [200, 40, 40];
const BELIEVED: Rgb = [40, 90, 200];
const REMEMBERED: Rgb = [230, 140, 20];
const LOST: Rgb = [170, 60, 170];

/// Ahead and to the left over time, in the frame of the trial's start as odometry had it then.
pub fn kick_chart(log: &KickLog) -> Figure {
    let end = log.steps.last().map_or(0.0, |step| step.time_s);
    let charts: Vec<Figure> = [("ahead of the start [m]", 0), ("left of the start [m]", 1)]
        .into_iter()
        .map(|(label, k)| {
            let truth = log.steps.iter().map(|step| [step.time_s, step.truth[k]]).collect::<Vec<_>>();
            // Detections of other things may be anywhere.
            let all = truth.iter().map(|p| p[1]);
            let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            let near = |v: f64| v > low - 1.0 && v < high + 1.0;
            let finds = |own: bool| {
                let of = log.finds.iter().filter(move |(_, place, of_own)| *of_own == own && near(place[k]));
                of.map(|(time_s, place, _)| [*time_s, place[k]]).collect::<Vec<_>>()
            };
            let believed = |state: &str| {
                let of = log.steps.iter().filter_map(|step| {
                    let (place, _, named) = step.believed?;
                    (named == state && near(place[k])).then_some([step.time_s, place[k]])
                });
                of.collect::<Vec<_>>()
            };
            let dots = |points: Vec<[f64; 2]>, color: Rgb| Series { points, color, dots: true };
            let mut series = vec![
                dots(believed("seen"), BELIEVED),
                dots(believed("remembered"), REMEMBERED),
                dots(believed("lost"), LOST),
                Series { points: truth, color: TRUTH, dots: false },
                dots(finds(true), SEEN),
                dots(finds(false), OTHER),
            ];
            for time_s in [Some(log.start_s), log.strike_s].into_iter().flatten().filter(|t| *t < end) {
                series.push(Series {
                    points: vec![[time_s, low], [time_s, high]],
                    color: [150; 3],
                    dots: false,
                });
            }
            Chart { title: "one kick", x_label: "time [s]", y_label: label, logarithmic: false, series }
                .draw()
        })
        .collect();
    let mut figure = Figure::tiled(&charts, 1);
    let legend = [
        ("truth", TRUTH),
        ("seen", SEEN),
        ("detected, not accepted", OTHER),
        ("believed: seen", BELIEVED),
        ("remembered", REMEMBERED),
        ("lost", LOST),
    ];
    for (k, (name, color)) in legend.into_iter().enumerate() {
        figure.colored_text(
            [400 + 170 * (k as i64 % 3), 22 + 18 * (k as i64 / 3)],
            14,
            Anchor::Start,
            color,
            name,
        );
    }
    figure
}
