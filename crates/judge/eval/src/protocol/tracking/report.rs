//! Figures of a tracking evaluation, per run, clip and set.

use paid_lanes::stats::mean;
use paid_plot::Bars;
use paid_plot::{Table, number};
use serde::Serialize;

use super::TrackingOptions;
use super::score::{BodyScore, ClipScore, MeanScore, PAPER_ROWS, PaperRow, RunScore, SetScore};
use crate::engine::EngineFacts;
use crate::episodes::EvalSetup;
use crate::metrics::statistics::Share;

/// The set of all clips.
const ALL: &str = "all";

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrackingReport {
    /// Who simulated.
    pub engine: EngineFacts,
    /// Whether the limits of training ended runs, or only falls.
    pub limits: bool,
    /// Runs that were planned; a stopped evaluation has fewer.
    pub planned: usize,
    /// Sets in order of first appearance, then all clips together.
    pub sets: Vec<SetScore>,
    /// Clips in library order.
    pub clips: Vec<ClipScore>,
    /// Tracked bodies, the root first: where the error is.
    pub bodies: Vec<BodyScore>,
    /// The paper's rows.
    pub paper: Vec<PaperRow>,
    /// Every run.
    pub runs: Vec<RunScore>,
}

impl TrackingReport {
    pub(super) fn new(setup: &EvalSetup, options: &TrackingOptions, runs: Vec<RunScore>) -> Self {
        let sets = &options.sets;
        let pick = |f: &dyn Fn(&RunScore) -> bool| runs.iter().filter(|r| f(r)).collect::<Vec<_>>();
        let done = |runs: &[&RunScore]| Share::of(runs.iter().map(|r| r.completed));
        let clips = (0..setup.library.len())
            .map(|motion| {
                let exact = pick(&|r| r.motion == motion && r.exact);
                let perturbed = pick(&|r| r.motion == motion && !r.exact);
                ClipScore {
                    name: setup.library.facts()[motion].name.clone(),
                    set: sets[motion].clone(),
                    exact_completed: exact.first().map(|r| r.completed),
                    exact: MeanScore::of(&exact),
                    perturbed_completed: done(&perturbed),
                    falls: exact.iter().chain(&perturbed).filter(|r| r.fell).count(),
                    perturbed: MeanScore::of(&perturbed),
                }
            })
            .collect();
        let mut names: Vec<&str> = Vec::new();
        for set in sets {
            if !names.contains(&set.as_str()) {
                names.push(set);
            }
        }
        let score = |name: &str, member: &dyn Fn(usize) -> bool| {
            let exact = pick(&|r| r.exact && member(r.motion));
            let perturbed = pick(&|r| !r.exact && member(r.motion));
            let exact_mean = MeanScore::of(&exact);
            SetScore {
                set: name.to_owned(),
                clips: (0..sets.len()).filter(|m| member(*m)).count(),
                exact_completed: done(&exact),
                perturbed_completed: done(&perturbed),
                exact_auj: exact_mean.map(|m| m.auj()),
                exact: exact_mean,
                perturbed: MeanScore::of(&perturbed),
                falls: exact.iter().chain(&perturbed).filter(|r| r.fell).count(),
            }
        };
        let mut scores: Vec<SetScore> = names.iter().map(|name| score(name, &|m| sets[m] == *name)).collect();
        if names.len() > 1 {
            scores.push(score(ALL, &|_| true));
        }
        let body = |(k, name): (usize, &String)| BodyScore {
            body: name.clone(),
            error_mm: scores
                .iter()
                .map(|s| {
                    let member = |r: &&RunScore| r.exact && (s.set == ALL || sets[r.motion] == s.set);
                    mean(runs.iter().filter(member).map(|r| r.body_errors_mm[k]))
                })
                .collect(),
        };
        let bodies = setup.spec.tracked_bodies.iter().enumerate().map(body).collect();
        let engine = setup.engine.facts(&setup.preset);
        Self {
            bodies,
            engine,
            limits: options.limits,
            planned: setup.library.len() * (1 + options.starts),
            sets: scores,
            clips,
            paper: PAPER_ROWS.to_vec(),
            runs,
        }
    }

    /// Errors of every clip, of the exact and of the perturbed starts; no bar where there were none.
    pub fn error_bars(&self) -> Bars {
        let of = |f: fn(&MeanScore) -> f64| {
            let pair = |c: &ClipScore| [c.exact.as_ref().map(f), c.perturbed.as_ref().map(f)];
            self.clips.iter().map(pair).collect()
        };
        Bars {
            labels: self.clips.iter().map(|c| c.name.clone()).collect(),
            series: ["exact start", "starts with reset noise"],
            panels: vec![
                ("MPJPE [mm]".to_owned(), of(|m| m.errors.mpjpe_mm)),
                ("G-MPJPE [mm]".to_owned(), of(|m| m.errors.g_mpjpe_mm)),
                ("root velocity error [mm/frame]".to_owned(), of(|m| m.errors.velocity_error_mm)),
            ],
        }
    }

    /// The report as text.
    pub fn table(&self) -> String {
        let mut clips = Table::new(&[
            "clip",
            "set",
            "done",
            "mpjpe",
            "g-mpjpe",
            "vel",
            "walked",
            "foot m/s",
            "speed",
            "lift",
            "auj",
            "perturbed done",
            "mpjpe",
            "g-mpjpe",
            "falls",
        ]);
        for c in &self.clips {
            clips.row([
                c.name.clone(),
                c.set.clone(),
                c.exact_completed.map_or("-", |done| if done { "yes" } else { "no" }).to_owned(),
                cell(c.exact, 1, |m| m.errors.mpjpe_mm),
                cell(c.exact, 1, |m| m.errors.g_mpjpe_mm),
                cell(c.exact, 2, |m| m.errors.velocity_error_mm),
                percent(c.exact, |m| m.displacement_share),
                cell(c.exact, 2, |m| m.foot_speed),
                percent(c.exact, |m| m.foot_speed_share),
                percent(c.exact, |m| m.lift_share),
                cell(c.exact, 4, MeanScore::auj),
                format!("{}/{}", c.perturbed_completed.count, c.perturbed_completed.trials),
                cell(c.perturbed, 1, |m| m.errors.mpjpe_mm),
                cell(c.perturbed, 1, |m| m.errors.g_mpjpe_mm),
                c.falls.to_string(),
            ]);
        }
        let mut sets = Table::new(&["set", "method", "completed", "mpjpe", "g-mpjpe", "vel", "auj"]);
        for s in &self.sets {
            for (label, done, m) in
                [("exact", s.exact_completed, s.exact), ("perturbed", s.perturbed_completed, s.perturbed)]
            {
                if m.is_none() {
                    continue;
                }
                sets.row([
                    s.set.clone(),
                    format!("this policy, {label}"),
                    format!("{}/{}", done.count, done.trials),
                    cell(m, 2, |m| m.errors.mpjpe_mm),
                    cell(m, 2, |m| m.errors.g_mpjpe_mm),
                    cell(m, 2, |m| m.errors.velocity_error_mm),
                    cell(m, 4, MeanScore::auj),
                ]);
            }
            for p in self.paper.iter().filter(|p| p.set == s.set) {
                sets.row([
                    p.set.to_owned(),
                    format!("{} [paper, MuJoCo]", p.method),
                    String::new(),
                    number(p.mpjpe_mm, 2),
                    number(p.g_mpjpe_mm, 2),
                    number(p.velocity_error_mm, 2),
                    number(p.auj, 4),
                ]);
            }
        }
        let mut heads = vec!["body"];
        heads.extend(self.sets.iter().map(|s| s.set.as_str()));
        let mut bodies = Table::new(&heads);
        for b in &self.bodies {
            let errors = b.error_mm.iter().map(|e| e.map_or("-".to_owned(), |e| number(e, 1)));
            bodies.row(std::iter::once(b.body.clone()).chain(errors));
        }
        let engine = &self.engine;
        let stopped = if self.runs.len() < self.planned {
            format!("stopped: {} of {} runs\n", self.runs.len(), self.planned)
        } else {
            String::new()
        };
        format!(
            "{} ({} ms steps, {}); runs end {}{}\n{stopped}\n{clips}\nmpjpe, g-mpjpe [mm], vel [mm/frame]; walked, speed, lift: shares of the clip's displacement, peak \
             kicking-foot speed and lift; exact start, then starts with reset noise.\n\n{sets}\nmean error of each body \
             relative to the root, exact starts [mm]\n\n{bodies}",
            engine.name,
            1e3 * engine.physics_dt_s,
            engine.surfaces,
            if self.limits { "at the limits of training" } else { "at a fall only" },
            engine.knowledge_text()
        )
    }
}

/// A figure of a mean, or a dash.
fn cell(mean: Option<MeanScore>, digits: usize, figure: fn(&MeanScore) -> f64) -> String {
    mean.map_or("-".to_owned(), |m| number(figure(&m), digits))
}

/// A share of a mean in percent, or a dash.
fn percent(mean: Option<MeanScore>, share: fn(&MeanScore) -> f64) -> String {
    mean.map_or("-".to_owned(), |m| format!("{:.0}%", 100.0 * share(&m)))
}
