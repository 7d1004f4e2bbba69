//! Means, medians and quantiles of plain numbers: the one definition of each.

/// The mean; `None` of nothing.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.into_iter().fold((0.0, 0), |(s, n), v| (s + v, n + 1));
    (n > 0).then(|| sum / f64::from(n))
}

/// The middle of the values, the mean of the two middle ones of an even number; `None` of nothing. Their order changes.
pub fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let (middle, odd) = (values.len() / 2, values.len() % 2 == 1);
    let (below, at, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let at = *at;
    if odd {
        return Some(at);
    }
    let before = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some(0.5 * (before + at))
}

/// The value nearest to this share, 0 to 1, of the way from the least to the greatest, the upper one of two; `None` of nothing. It is one of
/// the values: of an even number, a half gives the upper one of the two in the middle. Sorts them.
pub fn quantile(values: &mut [f64], share: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    values.get((share * last as f64).round() as usize).copied()
}

/// The first bin of a histogram up to which there is this share of all counts, 0 to 1; `None` while nothing is counted.
pub fn quantile_of_counts(counts: &[u64], share: f64) -> Option<usize> {
    let all: u64 = counts.iter().sum();
    let wanted = ((share * all as f64).ceil() as u64).max(1);
    let mut seen = 0;
    counts.iter().position(|count| {
        seen += count;
        seen >= wanted
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_has_no_mean_no_median_and_no_quantile() {
        assert_eq!((mean([]), median(&mut []), quantile(&mut [], 0.5)), (None, None, None));
        assert_eq!(mean([1.0, 2.0, 6.0]), Some(3.0));
    }

    #[test]
    fn the_median_of_an_even_number_lies_between_and_its_quantile_is_a_value() {
        let mut even = [4.0, 1.0, 3.0, 10.0];
        assert_eq!(median(&mut even), Some(3.5));
        assert_eq!(quantile(&mut even, 0.5), Some(4.0));
        let mut odd = [5.0, 1.0, 2.0];
        assert_eq!((median(&mut odd), quantile(&mut odd, 0.5)), (Some(2.0), Some(2.0)));
    }

    #[test]
    fn quantiles_go_from_the_least_to_the_greatest() {
        let mut values: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        let at = [0.0, 0.25, 0.95, 1.0].map(|share| quantile(&mut values, share));
        assert_eq!(at, [0.0, 25.0, 95.0, 100.0].map(Some));
    }
}
