//! The report of an evaluation with onboard perception.

use std::fmt::Write;

use paid_lanes::stats::mean;
use paid_plot::{Table, number};
use serde::Serialize;

use super::{Cause, EyesOptions, EyesOutcome};
use crate::metrics::statistics::Share;
use crate::shooting::ShootingReport;

/// The shots, and what the eyes made of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EyesReport {
    /// The shots.
    #[serde(flatten)]
    pub shooting: ShootingReport,
    /// The eyes.
    pub eyes: EyesOptions,
    /// Shots whose ball was in view at the start.
    pub in_view: EyesTotals,
    /// The others.
    pub out_of_view: EyesTotals,
    /// What the eyes made of every shot, in the order of the trials.
    pub seen: Vec<EyesOutcome>,
}

/// Shares of some shots.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EyesTotals {
    /// Goals.
    pub success: Share,
    /// Misses by cause, in the order of [`Cause::ALL`].
    pub causes: [usize; 4],
    /// Mean distance of the believed ball from its place when the motion was chosen `[m]`.
    pub start_error_m: Option<f64>,
    /// The same 0.2 s before the strike, seen from the torso `[m]`.
    pub strike_error_m: Option<f64>,
    /// The part due to odometry since the last image of the ball `[m]`.
    pub odometry_error_m: Option<f64>,
    /// Share of the images with a quarter or more of the ball in which it was detected.
    pub found: Share,
    /// False detections per 1000 images.
    pub false_per_1000: f64,
    /// Steps at which odometry did not track.
    pub untracked_steps: usize,
    /// Processor time of a shot `[s]`.
    pub cpu_s: Option<f64>,
    /// Of it the simulation of the sensors `[s]`.
    pub sensors_cpu_s: Option<f64>,
    /// Of it the pipeline `[s]`.
    pub sight_cpu_s: Option<f64>,
}

impl EyesTotals {
    fn of(shots: &[(bool, &EyesOutcome)]) -> Self {
        let all = || shots.iter().map(|(_, eyes)| *eyes);
        let sum = |of: fn(&EyesOutcome) -> usize| all().map(of).sum::<usize>();
        let with_ball = sum(|eyes| eyes.with_ball);
        Self {
            success: Share::of(shots.iter().map(|(goal, _)| *goal)),
            causes: Cause::ALL.map(|cause| all().filter(|eyes| eyes.cause == Some(cause)).count()),
            start_error_m: mean(all().filter_map(|eyes| eyes.start_error_m)),
            strike_error_m: mean(all().filter_map(|eyes| eyes.strike_error_m)),
            odometry_error_m: mean(all().filter_map(|eyes| eyes.odometry_error_m)),
            found: Share::new(sum(|eyes| eyes.found).min(with_ball), with_ball),
            false_per_1000: 1000.0 * sum(|eyes| eyes.false_finds) as f64
                / (sum(|eyes| eyes.pictures) as f64).max(1.0),
            untracked_steps: sum(|eyes| eyes.untracked_steps),
            cpu_s: mean(all().map(|eyes| eyes.cpu_s)),
            sensors_cpu_s: mean(all().map(|eyes| eyes.sensors_cpu_s)),
            sight_cpu_s: mean(all().map(|eyes| eyes.sight_cpu_s)),
        }
    }
}

impl EyesReport {
    pub(super) fn new(shooting: ShootingReport, eyes: EyesOptions, seen: Vec<EyesOutcome>) -> Self {
        let totals = |in_view: bool| {
            let shots = shooting.trials.iter().zip(&seen);
            let shots = shots.filter(|(_, eyes)| eyes.in_view_at_start == in_view);
            EyesTotals::of(&shots.map(|(outcome, eyes)| (outcome.goal, eyes)).collect::<Vec<_>>())
        };
        let (in_view, out_of_view) = (totals(true), totals(false));
        Self { shooting, eyes, in_view, out_of_view, seen }
    }

    /// The shots' table, then the eyes'.
    pub fn table(&self) -> String {
        let mut out = self.shooting.table();
        let _ = writeln!(
            out,
            "\nonboard perception: shots by whether the whole ball is in the image at the start\n"
        );
        let mut table = Table::new(&["figure", "in view", "not in view"]);
        let both = [&self.in_view, &self.out_of_view];
        let mut row = |name: &str, value: &dyn Fn(&EyesTotals) -> String| {
            let [a, b] = both.map(value);
            table.row([name.to_owned(), a, b]);
        };
        let share = |s: Share| {
            format!(
                "{:.1}% ({} of {}; {:.0} to {:.0}%)",
                100.0 * s.share,
                s.count,
                s.trials,
                100.0 * s.low,
                100.0 * s.high
            )
        };
        let cm = |v: Option<f64>| v.map_or("-".to_owned(), |v| format!("{:.1} cm", 100.0 * v));
        let seconds = |v: Option<f64>| v.map_or("-".to_owned(), |v| format!("{} s", number(v, 2)));
        row("success", &|t| share(t.success));
        for (k, cause) in Cause::ALL.into_iter().enumerate() {
            row(&format!("missed: {}", cause.words()), &|t| t.causes[k].to_string());
        }
        row("ball position at the start, mean error", &|t| cm(t.start_error_m));
        row("0.2 s before the strike, seen from the torso", &|t| cm(t.strike_error_m));
        row("of it odometry since the last image", &|t| cm(t.odometry_error_m));
        row("images of the ball in which it was detected", &|t| share(t.found));
        row("false detections per 1000 images", &|t| number(t.false_per_1000, 1));
        row("steps at which odometry did not track", &|t| t.untracked_steps.to_string());
        row("processor time per shot", &|t| seconds(t.cpu_s));
        row("of it the sensors' simulation", &|t| seconds(t.sensors_cpu_s));
        row("of it the pipeline", &|t| seconds(t.sight_cpu_s));
        let _ = writeln!(out, "{table}");
        out
    }

    /// One line per detection of a ball: what `paid perceive fit` reads.
    pub fn sightings_csv(&self) -> String {
        let mut out =
            String::from("trial,distance_m,speed_m_s,age_s,error_along_m,error_across_m,shown,own\n");
        for (trial, eyes) in self.seen.iter().enumerate() {
            for s in &eyes.sightings {
                let _ = writeln!(
                    out,
                    "{trial},{:.4},{:.4},{:.4},{:.5},{:.5},{:.3},{}",
                    s.distance_m, s.speed_m_s, s.age_s, s.error_m[0], s.error_m[1], s.shown, s.own
                );
            }
        }
        out
    }
}
