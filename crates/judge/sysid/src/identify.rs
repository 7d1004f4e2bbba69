//! The whole identification: measurements in, parameters with confidence out.

use paid_lanes::Isa;
use paid_physics::{BallParams, Material, SceneConfig};
use serde::Serialize;

use crate::SysidError;
use crate::confidence::{Confidence, Verdict, judge};
use crate::csv::{Quantity, Run};
use crate::lab::{Lab, Launch, Start, engine_lab};
use crate::options::{Options, Parameters, Repeats, Starts, Unseen, parameters_of, with_parameters};
use crate::search::{Problem, Search, search, starts};
use crate::trial::{Trial, repeats, trials};

/// Initial step of a fit to one repeat, which begins at the common best, in units of the ranges.
const REPEAT_SCALE: f64 = 0.05;
/// Spacing of the drawn curves `[s]`.
const CURVE_S: f64 = 0.01;

/// A measured run and the simulated one.
#[derive(Clone, Debug, Serialize)]
pub struct Overlay {
    /// Label of the run.
    pub run: String,
    /// Initial height `[m]` or speed `[m/s]` given to the simulation.
    pub initial: f64,
    /// Compared samples: time `[s]`, measured, simulated `[m]`.
    pub samples: Vec<[f64; 3]>,
    /// The simulated curve: time `[s]`, value `[m]`.
    pub curve: Vec<[f64; 2]>,
}

/// The result.
#[derive(Clone, Debug, Serialize)]
pub struct Identification {
    /// The ball with the identified parameters.
    pub ball: BallParams,
    /// The ground that it was identified on, which is held.
    pub ground: Material,
    /// True if initial heights and speeds were corrected by the whole runs.
    pub starts_refined: bool,
    /// Loss of the best candidate `[m^2]`.
    pub loss: f64,
    /// Root mean square of measured less simulated heights `[m]`.
    pub drop_rms_m: Option<f64>,
    /// The same of the distances `[m]`.
    pub roll_rms_m: Option<f64>,
    /// What is known about each parameter.
    pub confidence: Confidence,
    /// Every search.
    pub searches: Vec<Search>,
    /// Parameters that fit each repeat alone (drop and roll of the same number), where there are several.
    pub repeats: Vec<Parameters>,
    /// Drops.
    pub drops: Vec<Overlay>,
    /// Rolls.
    pub rolls: Vec<Overlay>,
    /// Simulated experiments.
    pub rollouts: u64,
}

/// Identifies the ball's surface and damping from measured `drops` and `rolls` on the flat ground of `scene`. Of `ball`, mass,
/// radius and inertia are kept, and by default the parameters that the measurements do not show.
///
/// # Errors
/// If an option is out of range, nothing was measured, or the engine refuses the scene.
pub fn identify(
    drops: &[Run],
    rolls: &[Run],
    ball: &BallParams,
    scene: &SceneConfig,
    isa: Isa,
    options: &Options,
) -> Result<Identification, SysidError> {
    options.validate()?;
    if drops.is_empty() && rolls.is_empty() {
        return Err(SysidError::option("measurements", "at least one run", "none"));
    }
    let mut lab = engine_lab(isa, scene)?;
    let lab = lab.as_mut();
    let all = both(drops, rolls, options);
    let problem = Problem { ball: *ball, trials: all.iter().collect(), options };
    let begins = starts(&problem, lab);
    let searches = search(&problem, lab, &begins, options.scale);
    let best = searches
        .iter()
        .filter(|s| s.loss.is_finite())
        .min_by(|a, b| a.loss.total_cmp(&b.loss))
        .ok_or(SysidError::NoFit(options.generations))?;
    let (mut best, loss) = (best.best, best.loss);
    // As the engine understands it.
    best[0] = best[0].max(best[1]);
    let singles = repeat_fits(drops, rolls, ball, lab, options, &best);
    let optima: Vec<Parameters> = searches.iter().map(|s| s.best).collect();
    let mut confidence = judge(&problem, lab, &best, &optima, &singles);
    if options.unseen == Unseen::Kept {
        best = keep_unseen(&problem, lab, best, &mut confidence);
    }
    let refined = problem.refined(lab, &best);
    let ball = with_parameters(ball, &best);
    let drops = overlays(&refined, lab, &ball, Quantity::Height);
    let rolls = overlays(&refined, lab, &ball, Quantity::Distance);
    Ok(Identification {
        ball,
        ground: scene.ground,
        starts_refined: options.starts == Starts::Refined,
        loss,
        drop_rms_m: rms(&drops),
        roll_rms_m: rms(&rolls),
        confidence,
        searches,
        repeats: singles,
        drops,
        rolls,
        rollouts: lab.rollouts(),
    })
}

fn both(drops: &[Run], rolls: &[Run], options: &Options) -> Vec<Trial> {
    let mut all = trials(drops, Quantity::Height, options);
    all.extend(trials(rolls, Quantity::Distance, options));
    all
}

/// Parameters that fit each repeat alone, starting from the common best.
fn repeat_fits(
    drops: &[Run],
    rolls: &[Run],
    ball: &BallParams,
    lab: &mut dyn Lab,
    options: &Options,
    best: &Parameters,
) -> Vec<Parameters> {
    let (drops, rolls) = (repeats(drops), repeats(rolls));
    let count = drops.iter().chain(&rolls).map(Vec::len).max().unwrap_or(0);
    if count < 2 {
        return Vec::new();
    }
    let options = Options { repeats: Repeats::Joint, ..options.clone() };
    let of =
        |groups: &[Vec<Run>], i: usize| groups.iter().map(|g| g[i % g.len()].clone()).collect::<Vec<_>>();
    (0..count)
        .map(|i| {
            let one = both(&of(&drops, i), &of(&rolls, i), &options);
            let problem = Problem { ball: *ball, trials: one.iter().collect(), options: &options };
            search(&problem, lab, &[*best], REPEAT_SCALE)[0].best
        })
        .collect()
}

/// The best parameters with those that are not seen put back to the value of the problem's ball, as far as that fits as well.
fn keep_unseen(
    problem: &Problem<'_>,
    lab: &mut dyn Lab,
    best: Parameters,
    confidence: &mut Confidence,
) -> Parameters {
    let known = parameters_of(&problem.ball);
    let mut kept = best;
    for (i, e) in confidence.estimates.iter().enumerate().filter(|(_, e)| e.verdict == Verdict::Unseen) {
        kept[i] = known[i].clamp(e.flat[0], e.flat[1]);
    }
    kept[0] = kept[0].max(kept[1]);
    // Each alone fits as well; together they need not.
    let sums = problem.square_sums(lab, &[best, kept]);
    if sums[1].is_nan() || sums[1] - sums[0] > confidence.visible() {
        return best;
    }
    for (i, e) in confidence.estimates.iter_mut().enumerate().filter(|(_, e)| e.verdict == Verdict::Unseen) {
        e.kept = Some(kept[i]);
    }
    kept
}

/// Measured and simulated runs of one quantity.
fn overlays(trials: &[Trial], lab: &mut dyn Lab, ball: &BallParams, quantity: Quantity) -> Vec<Overlay> {
    let mut out = Vec::new();
    for trial in trials.iter().filter(|t| t.quantity == quantity) {
        let end = trial.times.last().copied().unwrap_or(0.0);
        let dense: Vec<f64> = (0..=(end / CURVE_S) as usize).map(|i| CURVE_S * i as f64).collect();
        let launch = |times| Launch { ball: *ball, start: trial.start, times };
        let [samples, curve] = [launch(&trial.times), launch(&dense)].map(|one| lab.run(&[one]).concat());
        let measured = trial.times.iter().zip(&trial.values).zip(samples);
        out.push(Overlay {
            run: trial.name.clone(),
            initial: match trial.start {
                Start::Drop { height_m } => height_m,
                Start::Roll { speed, .. } => speed,
            },
            samples: measured.map(|((t, m), s)| [*t, *m, s]).collect(),
            curve: dense.iter().zip(curve).map(|(t, v)| [*t, v]).collect(),
        });
    }
    out
}

fn rms(overlays: &[Overlay]) -> Option<f64> {
    let squares: Vec<f64> =
        overlays.iter().flat_map(|o| o.samples.iter().map(|[_, m, s]| (m - s).powi(2))).collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}
