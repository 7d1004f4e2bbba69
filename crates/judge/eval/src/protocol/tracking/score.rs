//! Figures of runs, clips and sets, and the paper's.

use paid_lanes::stats::mean;
use serde::{Deserialize, Serialize};

use crate::metrics::statistics::Share;
use crate::metrics::tracking::TrackingErrors;

/// A row of the paper's comparison (table "Comparison of motion tracking performance").
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PaperRow {
    /// Set of motions.
    pub set: &'static str,
    /// Method.
    pub method: &'static str,
    /// `[mm]`.
    pub mpjpe_mm: f64,
    /// `[mm]`.
    pub g_mpjpe_mm: f64,
    /// `[mm/frame]`.
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Mean error of each tracked body relative to the root `[mm]`; the mean over bodies is `errors.mpjpe_mm`.
    pub body_errors_mm: Vec<f64>,
    /// Time-averaged peak link jerk `[m/frame^3]`.
    pub jerk: f64,
    /// The same of the reference over these frames.
    pub reference_jerk: f64,
    /// Displacement of the anchor, x forward and y left in its first heading `[m]`.
    pub displacement: [f64; 2],
    /// Its projection on the motion's, as a share.
    pub displacement_share: f64,
    /// Largest speed of the kicking foot's center of mass `[m/s]`.
    pub foot_speed: f64,
    /// As a share of the motion's.
    pub foot_speed_share: f64,
    /// Rise of the kicking foot from its lowest to its highest point `[m]`.
    pub lift_m: f64,
    /// As a share of the motion's.
    pub lift_share: f64,
}

/// Means over some runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MeanScore {
    /// Errors.
    pub errors: TrackingErrors,
    /// Time-averaged peak link jerk `[m/frame^3]`.
    pub jerk: f64,
    /// The same of the reference.
    pub reference_jerk: f64,
    /// Share of the motion's displacement.
    pub displacement_share: f64,
    /// Peak speed of the kicking foot `[m/s]`.
    pub foot_speed: f64,
    /// As a share of the motion's.
    pub foot_speed_share: f64,
    /// Share of the motion's lift.
    pub lift_share: f64,
}

impl MeanScore {
    /// Means, `None` of no runs.
    pub(super) fn of(runs: &[&RunScore]) -> Option<Self> {
        let m = |f: fn(&RunScore) -> f64| mean(runs.iter().map(|r| f(r))).unwrap_or(0.0);
        (!runs.is_empty()).then(|| Self {
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
        })
    }

    /// AUJ: deviation of the jerk from the reference's.
    pub fn auj(&self) -> f64 {
        (self.jerk - self.reference_jerk).abs()
    }
}

/// A tracked body over the exact starts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyScore {
    /// Name.
    pub body: String,
    /// Mean error relative to the root `[mm]`, in the order of the report's sets; `None` where a set has no exact start.
    pub error_mm: Vec<Option<f64>>,
}

/// A clip.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClipScore {
    /// Name.
    pub name: String,
    /// Set.
    pub set: String,
    /// True if the exact start was followed to the end; `None` if a stopped evaluation did not get to it.
    pub exact_completed: Option<bool>,
    /// The exact start.
    pub exact: Option<MeanScore>,
    /// Perturbed starts followed to the end.
    pub perturbed_completed: Share,
    /// All starts in which the robot fell.
    pub falls: usize,
    /// Means over the perturbed starts, if there were any.
    pub perturbed: Option<MeanScore>,
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
    /// Means over the exact starts, if there were any.
    pub exact: Option<MeanScore>,
    /// AUJ of the exact starts: of the means over the set, as the paper defines it.
    pub exact_auj: Option<f64>,
    /// Means over the perturbed starts, if there were any.
    pub perturbed: Option<MeanScore>,
    /// Starts in which the robot fell.
    pub falls: usize,
}
