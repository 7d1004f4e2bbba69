//! Charts that only the page has, as SVG in its own colors and typeface.

use std::fmt::Write;

use crate::picture::escape;

/// A share with its interval, or one that somebody else has published without.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bar {
    pub name: String,
    pub share: f64,
    /// 95% interval.
    pub interval: Option<[f64; 2]>,
    /// True for this policy.
    pub own: bool,
}

/// Width of the names, of the bars and of the numbers in pixels.
const WIDTHS: [f64; 3] = [170.0, 420.0, 150.0];
/// Height of a row in pixels.
const ROW: f64 = 28.0;

/// Shares between 0 and 1 as bars, each with its interval.
pub(super) fn bars(title: &str, bars: &[Bar]) -> String {
    let [names, long, numbers] = WIDTHS;
    let (width, height) = (names + long + numbers, ROW * (bars.len() + 1) as f64 + 18.0);
    let x = |share: f64| names + long * share.clamp(0.0, 1.0);
    let mut out = begin(width, height, title);
    let bottom = ROW * bars.len() as f64 + 4.0;
    for tick in 0..=4 {
        let at = x(0.25 * f64::from(tick));
        let _ = writeln!(
            out,
            "<line class=\"grid\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"0\" y2=\"{bottom:.1}\"/>\
             <text class=\"tick\" x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}%</text>",
            bottom + 16.0,
            25 * tick
        );
    }
    for (row, bar) in bars.iter().enumerate() {
        let y = ROW * row as f64 + 6.0;
        let class = if bar.own { "own" } else { "other" };
        let text = bar.interval.map_or(format!("{:.1}%", 100.0 * bar.share), |[low, high]| {
            format!("{:.1}% ({:.1} to {:.1})", 100.0 * bar.share, 100.0 * low, 100.0 * high)
        });
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\
             <rect class=\"{class}\" x=\"{names}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"16\" rx=\"2\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\">{text}</text>",
            names - 10.0,
            y + 13.0,
            escape(&bar.name),
            x(bar.share) - names,
            names + long + 12.0,
            y + 13.0
        );
        if let Some([low, high]) = bar.interval {
            let (low, high, middle) = (x(low), x(high), y + 8.0);
            let _ = writeln!(
                out,
                "<path class=\"whisker\" d=\"M{low:.1} {:.1}v8M{low:.1} {middle:.1}H{high:.1}M{high:.1} {:.1}v8\"/>",
                middle - 4.0,
                middle - 4.0
            );
        }
    }
    let _ = writeln!(
        out,
        "<text class=\"axis\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">goals of all shots</text></svg>",
        names + 0.5 * long,
        height - 2.0
    );
    out
}

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
    // The robot's left is the picture's left.
    let x = |lateral: f64| margin + (SIDE_M - lateral) / (2.0 * SIDE_M) * (width - 2.0 * margin);
    let mut out = begin(width, height, "where balls crossed the goal's plane");
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
         get there</text></svg>",
        margin + 46.0,
        0.5 * width,
        height - 8.0
    );
    out
}

fn begin(width: f64, height: f64, title: &str) -> String {
    format!(
        "<svg class=\"chart\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\">\
         <title>{}</title>\n",
        escape(title)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_is_as_long_as_its_share_and_its_whiskers_stand_at_the_interval() {
        let own = Bar { name: "a < b".into(), share: 0.5, interval: Some([0.25, 0.75]), own: true };
        let svg = bars("t", &[own]);
        // Names take 170 pixels, the bars 420.
        assert!(svg.contains("class=\"own\" x=\"170\" y=\"6.0\" width=\"210.0\""), "{svg}");
        assert!(svg.contains("M275.0 10.0v8M275.0 14.0H485.0M485.0"), "{svg}");
        assert!(svg.contains("a &lt; b") && svg.contains("50.0% (25.0 to 75.0)"), "{svg}");
    }

    #[test]
    fn balls_are_counted_where_they_crossed_and_left_is_left() {
        let svg = mouth(&[0.05, 0.02, -1.33, 9.0], 3, 1.0);
        assert!(
            svg.contains("2 of 4 between 0.0 and 0.1 m") && svg.contains("3 shots did not get there"),
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
