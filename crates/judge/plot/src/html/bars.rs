//! Shares as bars.

use std::fmt::Write;

use super::begin_chart;
use crate::escape;

/// A share with its interval, or a published one without.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// Whose it is.
    pub name: String,
    /// From 0 to 1.
    pub share: f64,
    /// 95% interval.
    pub interval: Option<[f64; 2]>,
    /// True for this policy.
    pub own: bool,
}

/// Width of the names, of the bars and of the numbers in pixels.
const WIDTHS: [f64; 3] = [170.0, 420.0, 190.0];
/// Height of a row in pixels.
const ROW: f64 = 28.0;

/// Shares between 0 and 1 as bars, each with its interval.
pub fn bars(title: &str, bars: &[Bar]) -> String {
    let [names, long, numbers] = WIDTHS;
    let (width, height) = (names + long + numbers, ROW * (bars.len() + 1) as f64 + 18.0);
    let x = |share: f64| names + long * share.clamp(0.0, 1.0);
    let mut out = begin_chart(width, height, title);
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
        // The longest label, "100.0% (100.0 to 100.0)", takes 170 pixels of the typeface.
        assert!(svg.contains("viewBox=\"0 0 780 "), "{svg}");
    }
}
