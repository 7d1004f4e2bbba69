//! What the seeds of an entry have in common: the mean of their shares and its interval.

use super::report::Row;
use super::score::Shots;
use crate::ablation::Count;
use crate::metrics::statistics::mean;
use crate::table::{Table, number};

/// The 97.5% quantiles of Student's t distribution with 1, 2, ... degrees of freedom.
const T: [f64; 9] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262];
/// The same with many.
const T_MANY: f64 = 1.96;

/// Mean of at least two values and half of its 95% interval, by Student's t distribution; `None` of fewer.
fn interval(values: &[f64]) -> Option<[f64; 2]> {
    if values.len() < 2 {
        return None;
    }
    let n = values.len() as f64;
    let center = mean(values.iter().copied())?;
    let variance = values.iter().map(|x| (x - center) * (x - center)).sum::<f64>() / (n - 1.0);
    let t = T.get(values.len() - 2).copied().unwrap_or(T_MANY);
    Some([center, t * (variance / n).sqrt()])
}

/// Goals of every entry that was trained with several seeds; `None` without such an entry.
pub(super) fn table(rows: &[Row]) -> Option<Table> {
    let mut table =
        Table::new(&["mean over seeds [95% of the mean]", "knowledge", "seeds", "static", "rolling"]);
    let mut any = false;
    let mut done: Vec<&str> = Vec::new();
    for row in rows {
        let of_entry: Vec<&Row> = rows.iter().filter(|r| r.name == row.name && r.seed.is_some()).collect();
        if of_entry.len() < 2 || done.contains(&row.name.as_str()) {
            continue;
        }
        done.push(&row.name);
        for (k, judgment) in row.scores.judgments.iter().enumerate() {
            let share = |count: &Count| 100.0 * count.count as f64 / count.trials.max(1) as f64;
            let text = |shots: fn(&super::Judgment) -> &Shots| {
                let shares: Vec<f64> = of_entry
                    .iter()
                    .filter_map(|row| row.scores.judgments.get(k))
                    .map(|judgment| share(&shots(judgment).goals))
                    .collect();
                interval(&shares).map_or("-".to_owned(), |[center, half]| {
                    let ends = [(center - half).max(0.0), (center + half).min(100.0)];
                    format!("{}% [{}, {}]", number(center, 1), number(ends[0], 1), number(ends[1], 1))
                })
            };
            table.row([
                row.name.clone(),
                format!("{:?}", judgment.knowledge).to_lowercase(),
                of_entry.len().to_string(),
                text(|judgment| &judgment.fixed),
                text(|judgment| &judgment.rolling),
            ]);
            any = true;
        }
    }
    any.then_some(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_two_seeds_is_wide() {
        // 70 and 74: mean 72, deviation sqrt(8), over sqrt(2) is 2.
        let [center, half] = interval(&[70.0, 74.0]).expect("two");
        assert!((center - 72.0).abs() < 1e-12 && (half - 25.412).abs() < 1e-9, "{center} {half}");
        assert_eq!(interval(&[70.0]), None);
        // 1, 2, 3: deviation 1.
        let [_, half] = interval(&[1.0, 2.0, 3.0]).expect("three");
        assert!((half - 4.303 / 3.0_f64.sqrt()).abs() < 1e-12, "{half}");
    }
}
