//! Where balls crossed the goal's plane.

use std::fmt::Write;

use paid_plot::html::begin_chart;

/// Width of a bin of [`mouth`] `[m]`.
const BIN_M: f64 = 0.1;
/// Balls farther to the side than this count in the outermost bins `[m]`.
const SIDE_M: f64 = 2.5;

/// Where balls crossed the goal's plane, `laterals` left of its middle `[m]`, and how many did not get there.
pub(super) fn mouth(laterals: &[f64], short: usize, half_width: f64) -> String {
    let bins = (2.0 * SIDE_M / BIN_M).round() as usize;
    let mut counts = vec![0_usize; bins];
    for lateral in laterals {
        let bin = ((lateral + SIDE_M) / BIN_M).floor().clamp(0.0, (bins - 1) as f64);
        counts[bin as usize] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(0).max(1);
    let (width, tall, margin) = (640.0, 170.0, 44.0);
    let height = tall + 62.0;
    // The robot's left is the plot's left.
    let x = |lateral: f64| margin + (SIDE_M - lateral) / (2.0 * SIDE_M) * (width - 2.0 * margin);
    let mut out = begin_chart(width, height, "where balls crossed the goal's plane");
    for (k, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let left = (k as f64 + 1.0) * BIN_M - SIDE_M;
        let middle = left - 0.5 * BIN_M;
        let class = if middle.abs() < half_width { "goal" } else { "miss" };
        let high = (tall - 12.0) * *count as f64 / most as f64;
        let _ = writeln!(
            out,
            "<rect class=\"{class}\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{high:.1}\"><title>{count} of {} between \
             {:.1} and {:.1} m</title></rect>",
            x(left) + 0.5,
            tall - high,
            x(left - BIN_M) - x(left) - 1.0,
            laterals.len(),
            left - BIN_M,
            left
        );
    }
    for post in [half_width, -half_width] {
        let at = x(post);
        let _ = writeln!(out, "<line class=\"post\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"0\" y2=\"{tall}\"/>");
    }
    let _ = writeln!(
        out,
        "<line class=\"ground\" x1=\"{margin}\" x2=\"{:.1}\" y1=\"{tall}\" y2=\"{tall}\"/>",
        width - margin
    );
    for meter in -2..=2 {
        let at = x(f64::from(meter));
        let _ = writeln!(
            out,
            "<text class=\"tick\" x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{meter}</text>",
            tall + 18.0
        );
    }
    let _ = writeln!(
        out,
        "<text class=\"tick\" x=\"{:.1}\" y=\"12\" text-anchor=\"end\">{most} balls</text>\
         <text class=\"axis\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">left of the goal's middle [m]; {short} shots did not \
         reach it</text></svg>",
        margin + 46.0,
        0.5 * width,
        height - 8.0
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_are_counted_where_they_crossed_and_left_is_left() {
        let svg = mouth(&[0.05, 0.02, -1.33, 9.0], 3, 1.0);
        assert!(
            svg.contains("2 of 4 between 0.0 and 0.1 m") && svg.contains("3 shots did not reach it"),
            "{svg}"
        );
        assert!(
            svg.contains("1 of 4 between -1.4 and -1.3 m") && svg.contains("1 of 4 between 2.4 and 2.5 m")
        );
        let at = |text: &str| {
            let before = &svg[..svg.find(text).expect("a bar")];
            let x = before.rfind(" x=\"").expect("a place");
            before[x + 4..].split('"').next().expect("a number").parse::<f64>().expect("a number")
        };
        assert!(at("between 2.4") < at("between 0.0") && at("between 0.0") < at("between -1.4"));
        assert_eq!((svg.matches("class=\"goal\"").count(), svg.matches("class=\"miss\"").count()), (1, 2));
    }
}
