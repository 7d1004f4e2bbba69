//! What the seeds of an entry have in common: the mean of their shares and its interval.

use std::f64::consts::FRAC_PI_2;

use paid_eval::metrics::statistics::Share;
use paid_lanes::stats::mean;
use paid_plot::{Table, number};

use super::Judgment;
use super::report::Row;
use super::score::Shots;
use crate::compare::Count;

/// The 97.5% quantile of Student's t distribution with `freedom` degrees of freedom, at least one, to nine digits.
fn student_t(freedom: usize) -> f64 {
    let (mut low, mut high) = (1.9, 12.8);
    while high - low > 1e-9 * low {
        let middle = f64::midpoint(low, high);
        if within(middle, freedom) < 0.95 {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

/// The probability that Student's t lies between `-t` and `t` (Abramowitz and Stegun, "Handbook of Mathematical Functions", 26.7.3 and 26.7.4).
fn within(t: f64, freedom: usize) -> f64 {
    let angle = (t / (freedom as f64).sqrt()).atan();
    let (sin, cos) = angle.sin_cos();
    // The sum of cos^k with the products of (k - 1) / k before them; k is odd for an odd number of degrees of freedom, and even for an even one.
    let odd = freedom % 2;
    let (mut term, mut sum) = if odd == 1 { (cos, 0.0) } else { (1.0, 0.0) };
    for k in (odd..freedom.saturating_sub(1)).step_by(2) {
        sum += term;
        term *= (k + 1) as f64 / (k + 2) as f64 * cos * cos;
    }
    if odd == 1 { (angle + sin * sum) / FRAC_PI_2 } else { sin * sum }
}

/// What the seeds of all entries say of how much seeds differ. Shares are compared by their angle, `asin(sqrt(share))`: near 0 and 1 there is less
/// room to differ, and the angle allows for it, as it does for the binomial variance (M. S. Bartlett, "The use of transformations", 1947).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Between {
    /// Squared deviations from the mean angle of their entry, summed, in rad^2.
    squares: f64,
    /// Degrees of freedom: an entry's number of seeds less one, summed.
    freedom: usize,
}

impl Between {
    /// Of entries, each with a count for each of its seeds.
    fn of(entries: &[Vec<Count>]) -> Self {
        let mut all = Self::default();
        for counts in entries {
            let Some(center) = mean(counts.iter().map(angle)) else { continue };
            all.squares += counts.iter().map(|count| (angle(count) - center).powi(2)).sum::<f64>();
            all.freedom += counts.len() - 1;
        }
        all
    }

    /// Mean share over the seeds of an entry and the ends of its 95% interval: Student's of the angle, and at least the binomial one of all trials
    /// together (Wilson's). `None` without seeds, or if no entry has several.
    fn interval(&self, counts: &[Count]) -> Option<[f64; 3]> {
        let center = mean(counts.iter().map(Count::share))?;
        let turned = mean(counts.iter().map(angle))?;
        if self.freedom == 0 {
            return None;
        }
        let variance = self.squares / self.freedom as f64;
        let half = student_t(self.freedom) * (variance / counts.len() as f64).sqrt();
        let [low, high] =
            [turned - half, turned + half].map(|angle| angle.clamp(0.0, FRAC_PI_2).sin().powi(2));
        let sum = |of: fn(&Count) -> usize| counts.iter().map(of).sum();
        let binomial = Share::new(sum(|count| count.count), sum(|count| count.trials));
        Some([center, low.min(binomial.low), high.max(binomial.high)])
    }
}

/// In rad, 0 to pi / 2.
fn angle(count: &Count) -> f64 {
    count.share().sqrt().asin()
}

/// The rows of every entry that was trained with several seeds, in the order of the table.
fn entries(rows: &[Row]) -> Vec<Vec<&Row>> {
    let mut entries: Vec<Vec<&Row>> = Vec::new();
    for row in rows.iter().filter(|row| row.seed.is_some()) {
        match entries.iter_mut().find(|entry| entry[0].name == row.name) {
            Some(entry) => entry.push(row),
            None => entries.push(vec![row]),
        }
    }
    entries.retain(|entry| entry.len() > 1);
    entries
}

/// Goals of every entry that was trained with several seeds, and what the intervals are; `None` without such an entry.
pub(super) fn table(rows: &[Row]) -> Option<String> {
    let entries = entries(rows);
    let mut table =
        Table::new(&["mean over seeds [95% of the mean]", "knowledge", "seeds", "static", "rolling"]);
    let kinds: [fn(&Judgment) -> &Shots; 2] = [|judgment| &judgment.fixed, |judgment| &judgment.rolling];
    // Goals of an entry's seeds with the k-th knowledge.
    let counts = |entry: &[&Row], k: usize, kind: fn(&Judgment) -> &Shots| -> Vec<Count> {
        entry.iter().filter_map(|row| row.scores.judgments.get(k)).map(|j| kind(j).goals).collect()
    };
    let mut freedom = 0;
    for entry in &entries {
        for (k, judgment) in entry[0].scores.judgments.iter().enumerate() {
            let texts = kinds.map(|kind| {
                let all: Vec<Vec<Count>> = entries.iter().map(|entry| counts(entry, k, kind)).collect();
                let between = Between::of(&all);
                freedom = between.freedom;
                between.interval(&counts(entry, k, kind)).map_or("-".to_owned(), |interval| {
                    let [center, low, high] = interval.map(|share| number(100.0 * share, 1));
                    format!("{center}% [{low}, {high}]")
                })
            });
            let [fixed, rolling] = texts;
            table.row([
                entry[0].name.clone(),
                format!("{:?}", judgment.knowledge).to_lowercase(),
                entry.len().to_string(),
                fixed,
                rolling,
            ]);
        }
    }
    let degrees = if freedom == 1 { "degree" } else { "degrees" };
    (freedom > 0).then(|| {
        format!(
            "{table}The interval is Student's with {freedom} {degrees} of freedom, of asin(sqrt(share)): the variance between seeds is pooled over all\n\
             entries with several. It is at least Wilson's of all shots of the entry's seeds.\n"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries by the goals of their seeds, of 100 shots each.
    fn of(entries: &[&[usize]]) -> Vec<Vec<Count>> {
        let count = |goals: &usize| Count::of((0..100).map(|k| k < *goals));
        entries.iter().map(|goals| goals.iter().map(count).collect()).collect()
    }

    fn close(found: [f64; 3], expected: [f64; 3]) {
        let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-4, "{found:?} {expected:?}");
    }

    #[test]
    fn the_quantile_is_that_of_the_published_tables_for_any_number_of_seeds() {
        for (freedom, t) in [
            (1, 12.7062),
            (2, 4.3027),
            (3, 3.1824),
            (9, 2.2622),
            (10, 2.2281),
            (11, 2.2010),
            (20, 2.0860),
            (30, 2.0423),
            (100, 1.9840),
            (1_000_000, 1.9600),
        ] {
            assert!((student_t(freedom) - t).abs() < 6e-5, "{freedom}: {}", student_t(freedom));
        }
    }

    #[test]
    fn the_interval_of_two_seeds_alone_is_wide() {
        let entries = of(&[&[70, 74]]);
        // Angles 0.991157 and 1.035726, mean 1.013441, deviation 0.0222845 sqrt(2), over sqrt(2) is 0.0222845; times 12.706 is 0.283146.
        // sin^2(0.730295), sin^2(1.296588).
        let interval = Between::of(&entries).interval(&entries[0]).expect("two");
        close(interval, [0.72, 0.445_01, 0.926_68]);
        assert_eq!(Between::of(&of(&[&[70]])).interval(&of(&[&[70]])[0]), None);
        assert_eq!(Between::default().interval(&[]), None);
    }

    #[test]
    fn entries_with_several_seeds_share_what_they_know_of_their_difference() {
        let entries = of(&[&[70, 74], &[20, 24, 28], &[50]]);
        let between = Between::of(&entries);
        // Angles 0.991157 and 1.035726: 0.000993. Angles 0.463648, 0.511973 and 0.557599: 0.004415. 1 and 2 degrees of freedom; one seed alone
        // says nothing.
        assert_eq!(between.freedom, 3);
        assert!((between.squares - 0.005_408).abs() < 1e-6, "{between:?}");
        // sqrt(0.005408 / 3 / 2) = 0.030021, times 3.182 is 0.095529, about 1.013441.
        close(between.interval(&entries[0]).expect("two"), [0.72, 0.630_97, 0.801_46]);
        // sqrt(0.005408 / 3 / 3) = 0.024512, times 3.182 is 0.077999, about 0.511073.
        close(between.interval(&entries[1]).expect("three"), [0.24, 0.176_12, 0.308_68]);
    }

    #[test]
    fn an_entry_near_all_goals_is_not_said_to_differ_as_one_that_has_room_to() {
        let entries = of(&[&[80, 90], &[98, 99]]);
        let [wide, narrow] = [0, 1].map(|k| Between::of(&entries).interval(&entries[k]).expect("two"));
        // Both have angles -+0.225015, about 1.178097 and 1.449764; the latter ends at pi / 2.
        close(wide, [0.85, 0.664_56, 0.972_14]);
        close(narrow, [0.985, 0.884_96, 1.0]);
    }

    #[test]
    fn seeds_that_scored_the_same_have_the_interval_of_their_shots() {
        let entries = of(&[&[10, 10]]);
        // Wilson's of 20 in 200: z^2 = 3.8415, center 0.109604 / 1.019207, half 0.042672 / 1.019207.
        close(Between::of(&entries).interval(&entries[0]).expect("two"), [0.1, 0.065_67, 0.149_41]);
        let none = of(&[&[0, 0]]);
        let [center, low, high] = Between::of(&none).interval(&none[0]).expect("two");
        // 3.8415 / 203.8415.
        close([center, low, high], [0.0, 0.0, 0.018_85]);
    }
}
