//! The training run of the published policy `paid13`, to compare others with: by samples, so that the machine does not matter.

use std::collections::VecDeque;
use std::fmt;
use std::sync::LazyLock;

/// Samples over which figures are averaged before they are compared `[million]`, at least; and as a share of the samples so far.
const WINDOW: f64 = 0.5;
const WINDOW_SHARE: f64 = 0.05;
/// A row of the table is one iteration, which varies: this many on either side are averaged with it.
const NEIGHBORS: usize = 4;
/// Fewer samples say nothing `[million]`.
const FIRST: f64 = 3.0;

/// The log of one stage of the published run: some 200 of its iterations.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishedRun {
    columns: Vec<String>,
    /// Samples `[million]`, and one value for each column; NaN where the log has none.
    rows: Vec<(f64, Vec<f64>)>,
}

impl PublishedRun {
    /// The stage of that name: `stage1` or `stage2`, the presets of `paid train`. Others have nothing to be compared with.
    pub fn of(stage: &str) -> Option<&'static Self> {
        static RUNS: LazyLock<[PublishedRun; 2]> = LazyLock::new(|| {
            [include_str!("../published/stage1.csv"), include_str!("../published/stage2.csv")]
                .map(PublishedRun::parse)
        });
        let index = ["stage1", "stage2"].iter().position(|name| *name == stage)?;
        Some(&RUNS[index])
    }

    /// From a table whose second column is `samples`.
    fn parse(text: &str) -> Self {
        let mut lines = text.lines().map(|line| line.split(','));
        let columns = lines.next().into_iter().flatten().skip(2).map(str::to_owned).collect();
        let number = |cell: &str| cell.parse().unwrap_or(f64::NAN);
        let row = |cells: Vec<f64>| Some((1e-6 * cells.get(1)?, cells.get(2..)?.to_vec()));
        Self { columns, rows: lines.filter_map(|cells| row(cells.map(number).collect())).collect() }
    }

    /// A figure over millions of samples, by the path of its keys in a [`crate::Record`]: each point of a long table is the mean of its neighbors. Empty if the table
    /// does not have it.
    pub fn points(&self, path: &[&str]) -> Vec<[f64; 2]> {
        let all = self.values(path);
        // Scores by MuJoCo are ten in a run: they stay as they are.
        let side = NEIGHBORS.min(all.len() / 40);
        let near = |k: usize| &all[k.saturating_sub(side)..all.len().min(k + side + 1)];
        (0..all.len()).map(|k| [0, 1].map(|i| mean(near(k).iter().map(|p| p[i])))).collect()
    }

    /// A figure as the table has it.
    fn values(&self, path: &[&str]) -> Vec<[f64; 2]> {
        let name = path.join("/");
        let Some(column) = self.columns.iter().position(|c| *c == name) else { return Vec::new() };
        let points = self.rows.iter().map(|(samples, values)| [*samples, values[column]]);
        points.filter(|[_, value]| value.is_finite()).collect()
    }

    /// Samples at its end `[million]`.
    pub fn samples(&self) -> f64 {
        self.rows.last().map_or(0.0, |(samples, _)| *samples)
    }

    /// A figure about when a run with `samples` `[million]` is averaged; `None` after its end.
    fn mean_at(&self, path: &[&str], samples: f64) -> Option<f64> {
        let middle = 0.5 * (window_start(samples) + samples);
        let mut points = self.values(path);
        points.sort_by(|a, b| (a[0] - middle).abs().total_cmp(&(b[0] - middle).abs()));
        points.truncate(2 * NEIGHBORS + 1);
        (middle <= self.samples() && !points.is_empty()).then(|| mean(points.iter().map(|p| p[1])))
    }
}

fn window_start(samples: f64) -> f64 {
    samples - WINDOW.max(WINDOW_SHARE * samples)
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// How a run stands next to the published one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// Better.
    Ahead,
    /// Within what seeds and machines differ by.
    OnCourse,
    /// Worse; it may still catch up.
    Behind,
    /// So far off that it will not catch up.
    Lost,
}

impl fmt::Display for Standing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ahead => "ahead",
            Self::OnCourse => "on course",
            Self::Behind => "behind",
            Self::Lost => "lost",
        })
    }
}

/// The figure that decides in a stage.
struct Measure {
    name: &'static str,
    path: [&'static str; 2],
    /// How far a run is off, from its value and the published one: 0 is equal, positive is worse.
    off: fn(f64, f64) -> f64,
    /// Up to here it is ahead, on course, behind.
    limits: [f64; 3],
    /// What to look at if it is behind or lost.
    advice: &'static str,
}

/// The limits come from a second run of the published course, which was 5% off in Stage I, 0.1 below in Stage II's first phase and 0.15 to
/// 0.2 later, and ended 12 points lower in MuJoCo.
const MEASURES: [(&str, Measure); 2] = [
    (
        "stage1",
        Measure {
            name: "error of the bodies [m]",
            path: ["metrics", "error_body_pos"],
            off: |value, published| value / published - 1.0,
            limits: [-0.1, 0.25, 0.6],
            advice: "do the clips pass 'paid motion check'? Are they longer or harder than kicks?",
        },
    ),
    (
        "stage2",
        Measure {
            name: "shots on target [share]",
            path: ["metrics", "kick/on_target"],
            off: |value, published| published - value,
            limits: [-0.07, 0.12, 0.3],
            advice: "did Stage I end on course?",
        },
    ),
];

/// A run's figure next to that of the published run at as many samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// What is compared, with its unit.
    pub name: &'static str,
    /// Of the run, a mean over its last samples.
    pub value: f64,
    /// Of the published run.
    pub published: f64,
    /// Samples `[million]`.
    pub samples: f64,
    /// The verdict.
    pub standing: Standing,
    advice: &'static str,
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, value, published, samples, standing, advice } = self;
        write!(f, "{standing}: {name} {value:.3}, paid13 had {published:.3} after {samples:.0} M samples")?;
        match standing {
            Standing::Behind | Standing::Lost => write!(f, ". {advice}"),
            _ => Ok(()),
        }
    }
}

/// Compares a run with the published one while it trains.
#[derive(Clone, Debug, Default)]
pub struct Comparer {
    /// Samples `[million]` and the figure that decides, of the last iterations.
    recent: VecDeque<[f64; 2]>,
}

impl Comparer {
    /// Takes an iteration of a stage: its samples so far, and its metrics by name. Returns how the run stands; `None` in a stage without a
    /// published run, before the first three million samples, and after the published run's end.
    pub fn take(
        &mut self,
        stage: &str,
        samples: u64,
        metric: impl FnOnce(&str) -> Option<f64>,
    ) -> Option<Comparison> {
        let (_, measure) = MEASURES.iter().find(|(name, _)| *name == stage)?;
        let samples = 1e-6 * samples as f64;
        if self.recent.back().is_some_and(|[last, _]| *last > samples) {
            self.recent.clear();
        }
        self.recent.push_back([samples, metric(measure.path[1])?]);
        while self.recent.front().is_some_and(|[first, _]| *first < window_start(samples)) {
            self.recent.pop_front();
        }
        if samples < FIRST {
            return None;
        }
        let value = mean(self.recent.iter().map(|[_, value]| *value));
        let published = PublishedRun::of(stage)?.mean_at(&measure.path, samples)?;
        let off = (measure.off)(value, published);
        let [ahead, on_course, behind] = measure.limits;
        let standing = match off {
            _ if off <= ahead => Standing::Ahead,
            _ if off <= on_course => Standing::OnCourse,
            _ if off <= behind => Standing::Behind,
            _ => Standing::Lost,
        };
        Some(Comparison { name: measure.name, value, published, samples, standing, advice: measure.advice })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn take(comparer: &mut Comparer, stage: &str, millions: f64, value: f64) -> Option<Comparison> {
        comparer.take(stage, (1e6 * millions) as u64, |_| Some(value))
    }

    #[test]
    fn a_table_is_read_by_the_keys_of_a_record() {
        let run = PublishedRun::parse(
            "iteration,samples,mean_reward,metrics/kick/contact\n1,500000,2.5,\n9,4000000,3,0.5\n",
        );
        // Too few to be averaged.
        assert_eq!(run.points(&["mean_reward"]), [[0.5, 2.5], [4.0, 3.0]]);
        assert_eq!(run.points(&["metrics", "kick/contact"]), [[4.0, 0.5]]);
        assert!(run.points(&["absent"]).is_empty());
        assert_eq!((run.samples(), run.mean_at(&["mean_reward"], 4.2)), (4.0, Some(2.75)));
        assert_eq!(run.mean_at(&["mean_reward"], 5.0), None);
    }

    #[test]
    fn both_stages_have_the_figures_that_are_compared() {
        for (stage, measure) in &MEASURES {
            let run = PublishedRun::of(stage).expect("a published stage");
            // There is something to compare with all along.
            for samples in [3.0, 8.0, 40.0, 100.0, run.samples()] {
                assert!(run.mean_at(&measure.path, samples).is_some(), "{stage} at {samples}");
            }
            assert!((149.0..160.0).contains(&run.samples()), "{stage}: {}", run.samples());
        }
        assert!(PublishedRun::of("paper_stage1").is_none());
    }

    #[test]
    fn a_point_of_a_long_table_is_the_mean_of_its_neighbors() {
        let rows: String = (1..=80).map(|i| format!("{i},{i}000000,{i}\n")).collect();
        let run = PublishedRun::parse(&format!("iteration,samples,mean_reward\n{rows}"));
        let points = run.points(&["mean_reward"]);
        // Two on either side, fewer at the ends.
        assert_eq!((points[0], points[1], points[79]), ([2.0, 2.0], [2.5, 2.5], [79.0, 79.0]));
        assert_eq!((points.len(), points[40]), (80, [41.0, 41.0]));
    }

    #[test]
    fn a_run_is_ahead_on_course_behind_or_lost() {
        for (stage, name, values) in [
            ("stage1", "error_body_pos", [0.5, 1.0, 1.5, 2.0]),
            ("stage2", "kick/on_target", [1.2, 0.95, 0.75, 0.1]),
        ] {
            let path = ["metrics", name];
            let published = PublishedRun::of(stage).and_then(|run| run.mean_at(&path, 40.0)).expect("there");
            let standings = values.map(|factor| {
                let found = take(&mut Comparer::default(), stage, 40.0, factor * published);
                found.expect("compared").standing
            });
            let expected = [Standing::Ahead, Standing::OnCourse, Standing::Behind, Standing::Lost];
            assert_eq!(standings, expected, "{stage}");
        }
    }

    #[test]
    fn the_last_samples_are_averaged_and_the_first_say_nothing() {
        let mut comparer = Comparer::default();
        let mut at = |stage: &str, millions: f64, value: f64| take(&mut comparer, stage, millions, value);
        assert_eq!(at("stage2", 1.0, 0.9), None);
        // At 40 million the last two million count.
        for (millions, value) in [(37.0, 0.0), (38.5, 0.2), (39.0, 0.3)] {
            at("stage2", millions, value);
        }
        let found = at("stage2", 40.0, 0.4).expect("compared");
        assert!((found.value - 0.3).abs() < 1e-12, "{found:?}");
        let text = found.to_string();
        assert!(text.starts_with("lost: shots on target [share] 0.300, paid13 had 0."), "{text}");
        assert!(text.contains("Stage I"), "{text}");
        // A resumed run begins again.
        let found = at("stage2", 38.0, 0.5).expect("compared");
        assert!((found.value - 0.5).abs() < 1e-12, "{found:?}");
        assert_eq!(at("stage3", 40.0, 0.5), None);
        assert_eq!(at("stage2", 400.0, 0.5), None);
    }
}
