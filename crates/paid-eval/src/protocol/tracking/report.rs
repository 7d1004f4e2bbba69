//! Figures of a tracking evaluation, per run, clip and set.

use serde::Serialize;

use super::TrackingOptions;
use crate::engine::EngineFacts;
use crate::episodes::Arena;
use crate::metrics::statistics::{Share, mean};
use crate::metrics::tracking::TrackingErrors;
use crate::picture::Bars;
use crate::table::{Table, number};

/// A row of the paper's comparison (table "Comparison of motion tracking performance").
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PaperRow {
    /// Set of motions.
    pub set: &'static str,
    /// Method.
    pub method: &'static str,
    /// [mm].
    pub mpjpe_mm: f64,
    /// [mm].
    pub g_mpjpe_mm: f64,
    /// [mm/frame].
    pub velocity_error_mm: f64,
    /// AUJ.
    pub auj: f64,
}

const fn row(set: &'static str, method: &'static str, figures: [f64; 4]) -> PaperRow {
    let [mpjpe_mm, g_mpjpe_mm, velocity_error_mm, auj] = figures;
    PaperRow { set, method, mpjpe_mm, g_mpjpe_mm, velocity_error_mm, auj }
}

/// The paper's rows.
pub const PAPER_ROWS: [PaperRow; 10] = [
    row("standard", "GMT", [59.77, 195.79, 3.99, 0.0217]),
    row("standard", "Any2Track", [104.20, 468.56, 8.18, 0.1043]),
    row("standard", "TWIST2", [30.06, 161.96, 4.40, 0.0158]),
    row("standard", "BeyondMimic", [25.26, 104.41, 3.06, 0.0283]),
    row("standard", "PAiD (paper)", [27.75, 213.38, 3.75, 0.0129]),
    row("stylized", "GMT", [64.22, 376.45, 6.30, 0.0107]),
    row("stylized", "Any2Track", [172.23, 675.63, 11.58, 0.5420]),
    row("stylized", "TWIST2", [41.09, 318.93, 6.98, 0.0216]),
    row("stylized", "BeyondMimic", [39.13, 162.39, 4.26, 0.0161]),
    row("stylized", "PAiD (paper)", [62.01, 230.36, 5.04, 0.0444]),
];

/// One run of one motion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunScore {
    /// Motion index.
    pub motion: usize,
    /// True without reset noise.
    pub exact: bool,
    /// True if the motion was followed to its end.
    pub completed: bool,
    /// True if the robot lay at any time.
    pub fell: bool,
    /// Frames seen, the first included.
    pub frames: usize,
    /// Errors over these frames.
    pub errors: TrackingErrors,
    /// Time-averaged peak link jerk [m/frame^3].
    pub jerk: f64,
    /// The same of the reference over these frames.
    pub reference_jerk: f64,
    /// Displacement of the anchor, x forward and y left in its first heading [m].
    pub displacement: [f64; 2],
    /// Its projection on the motion's, as a share.
    pub displacement_share: f64,
    /// Largest speed of the kicking foot's centre of mass [m/s].
    pub foot_speed: f64,
    /// As a share of the motion's.
    pub foot_speed_share: f64,
    /// Rise of the kicking foot from its lowest to its highest point [m].
    pub lift_m: f64,
    /// As a share of the motion's.
    pub lift_share: f64,
}

/// Means over some runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MeanScore {
    /// Errors.
    pub errors: TrackingErrors,
    /// Time-averaged peak link jerk [m/frame^3].
    pub jerk: f64,
    /// The same of the reference.
    pub reference_jerk: f64,
    /// Share of the motion's displacement.
    pub displacement_share: f64,
    /// Peak speed of the kicking foot [m/s].
    pub foot_speed: f64,
    /// As a share of the motion's.
    pub foot_speed_share: f64,
    /// Share of the motion's lift.
    pub lift_share: f64,
}

impl MeanScore {
    fn of(runs: &[&RunScore]) -> Self {
        let m = |f: fn(&RunScore) -> f64| mean(runs.iter().map(|r| f(r))).unwrap_or(0.0);
        Self {
            errors: TrackingErrors {
                mpjpe_mm: m(|r| r.errors.mpjpe_mm),
                g_mpjpe_mm: m(|r| r.errors.g_mpjpe_mm),
                velocity_error_mm: m(|r| r.errors.velocity_error_mm),
            },
            jerk: m(|r| r.jerk),
            reference_jerk: m(|r| r.reference_jerk),
            displacement_share: m(|r| r.displacement_share),
            foot_speed: m(|r| r.foot_speed),
            foot_speed_share: m(|r| r.foot_speed_share),
            lift_share: m(|r| r.lift_share),
        }
    }

    /// AUJ: deviation of the jerk from the reference's.
    pub fn auj(&self) -> f64 {
        (self.jerk - self.reference_jerk).abs()
    }
}

/// A clip.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClipScore {
    /// Name.
    pub name: String,
    /// Set.
    pub set: String,
    /// True if the exact start was followed to the end.
    pub exact_completed: bool,
    /// The exact start.
    pub exact: MeanScore,
    /// Perturbed starts followed to the end.
    pub perturbed_completed: Share,
    /// All starts in which the robot fell.
    pub falls: usize,
    /// Means over the perturbed starts.
    pub perturbed: MeanScore,
}

/// A set of clips.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SetScore {
    /// Name of the set, or `all`.
    pub set: String,
    /// Clips.
    pub clips: usize,
    /// Exact starts followed to the end.
    pub exact_completed: Share,
    /// Perturbed starts followed to the end.
    pub perturbed_completed: Share,
    /// Means over the exact starts.
    pub exact: MeanScore,
    /// AUJ of the exact starts: of the means over the set, as the paper defines it.
    pub exact_auj: f64,
    /// Means over the perturbed starts.
    pub perturbed: MeanScore,
    /// Starts in which the robot fell.
    pub falls: usize,
}

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrackingReport {
    /// Who simulated.
    pub engine: EngineFacts,
    /// Whether the limits of training ended runs, or only falls.
    pub limits: bool,
    /// Sets in order of first appearance, then all clips together.
    pub sets: Vec<SetScore>,
    /// Clips in library order.
    pub clips: Vec<ClipScore>,
    /// The paper's rows.
    pub paper: Vec<PaperRow>,
    /// Every run.
    pub runs: Vec<RunScore>,
}

impl TrackingReport {
    pub(super) fn new(arena: &Arena, options: &TrackingOptions, runs: Vec<RunScore>) -> Self {
        let sets = &options.sets;
        let pick = |f: &dyn Fn(&RunScore) -> bool| runs.iter().filter(|r| f(r)).collect::<Vec<_>>();
        let done = |runs: &[&RunScore]| Share::of(runs.iter().map(|r| r.completed));
        let clips = (0..arena.library.len())
            .map(|motion| {
                let exact = pick(&|r| r.motion == motion && r.exact);
                let perturbed = pick(&|r| r.motion == motion && !r.exact);
                ClipScore {
                    name: arena.library.facts()[motion].name.clone(),
                    set: sets[motion].clone(),
                    exact_completed: exact.iter().all(|r| r.completed),
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
                exact_auj: exact_mean.auj(),
                exact: exact_mean,
                perturbed: MeanScore::of(&perturbed),
                falls: exact.iter().chain(&perturbed).filter(|r| r.fell).count(),
            }
        };
        let mut scores: Vec<SetScore> = names.iter().map(|name| score(name, &|m| sets[m] == *name)).collect();
        if names.len() > 1 {
            scores.push(score("all", &|_| true));
        }
        let engine = arena.engine.facts(&arena.preset);
        Self { engine, limits: options.limits, sets: scores, clips, paper: PAPER_ROWS.to_vec(), runs }
    }

    /// Errors of every clip, of the exact and of the perturbed starts.
    pub fn error_bars(&self) -> Bars {
        let of = |f: fn(&MeanScore) -> f64| {
            let pair = |c: &ClipScore| [f(&c.exact), f(&c.perturbed)];
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
                if c.exact_completed { "yes".into() } else { "no".into() },
                number(c.exact.errors.mpjpe_mm, 1),
                number(c.exact.errors.g_mpjpe_mm, 1),
                number(c.exact.errors.velocity_error_mm, 2),
                percent(c.exact.displacement_share),
                number(c.exact.foot_speed, 2),
                percent(c.exact.foot_speed_share),
                percent(c.exact.lift_share),
                number(c.exact.auj(), 4),
                format!("{}/{}", c.perturbed_completed.count, c.perturbed_completed.trials),
                number(c.perturbed.errors.mpjpe_mm, 1),
                number(c.perturbed.errors.g_mpjpe_mm, 1),
                c.falls.to_string(),
            ]);
        }
        let mut sets = Table::new(&["set", "method", "completed", "mpjpe", "g-mpjpe", "vel", "auj"]);
        for s in &self.sets {
            for (label, done, m) in
                [("exact", s.exact_completed, &s.exact), ("perturbed", s.perturbed_completed, &s.perturbed)]
            {
                sets.row([
                    s.set.clone(),
                    format!("this policy, {label}"),
                    format!("{}/{}", done.count, done.trials),
                    number(m.errors.mpjpe_mm, 2),
                    number(m.errors.g_mpjpe_mm, 2),
                    number(m.errors.velocity_error_mm, 2),
                    number(m.auj(), 4),
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
        let engine = &self.engine;
        format!(
            "{} ({} ms steps, {}); runs end {}\n\n{clips}\nmpjpe, g-mpjpe [mm], vel [mm/frame]; walked, speed, lift: shares of the clip's displacement, peak \
             kicking-foot speed and lift; exact start, then starts with reset noise.\n\n{sets}",
            engine.name,
            1e3 * engine.physics_dt_s,
            engine.surfaces,
            if self.limits { "at the limits of training" } else { "at a fall only" }
        )
    }
}

fn percent(share: f64) -> String {
    format!("{:.0}%", 100.0 * share)
}
