//! Diagrams of an identification: the loss over the generations, and measured runs under simulated ones.

use paid_sysid::Identification;
use paid_sysid::identify::Overlay;

use paid_plot::{Chart, Figure, Rgb, Series};

const FAINT: Rgb = [150, 165, 190];
/// One color per run.
const RUNS: [Rgb; 6] =
    [[31, 105, 180], [220, 95, 20], [40, 145, 60], [150, 70, 165], [180, 30, 50], [90, 90, 90]];

/// The best loss so far of every search; the best search is dark.
pub fn loss(found: &Identification) -> Figure {
    let best = found.searches.iter().map(|s| s.loss).fold(f64::INFINITY, f64::min);
    let mut searches: Vec<_> = found.searches.iter().collect();
    // The best is drawn last, over the others.
    searches.sort_by(|a, b| b.loss.total_cmp(&a.loss));
    let line = |s: &&paid_sysid::search::Search| Series {
        points: (1..).zip(&s.curve).map(|(g, l)| [f64::from(g), l.max(1e-12).log10()]).collect(),
        color: if s.loss <= best { RUNS[4] } else { FAINT },
        dots: false,
    };
    Chart {
        title: "loss of each search",
        x_label: "generation",
        y_label: "loss [m2]",
        logarithmic: true,
        series: searches.iter().map(line).collect(),
    }
    .draw()
}

/// Measured samples (dots) and simulated curves (lines), one color per run.
pub fn overlay(title: &str, y_label: &str, runs: &[Overlay]) -> Figure {
    let mut series = Vec::new();
    for (i, run) in runs.iter().enumerate() {
        let color = RUNS[i % RUNS.len()];
        series.push(Series { points: run.curve.clone(), color, dots: false });
        let dots = run.samples.iter().map(|[t, measured, _]| [*t, *measured]).collect();
        series.push(Series { points: dots, color, dots: true });
    }
    Chart { title, x_label: "time [s]", y_label, logarithmic: false, series }.draw()
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_plot::SIZE;

    #[test]
    fn dots_and_lines_are_where_the_data_are() {
        let run = Overlay {
            run: "1".into(),
            initial: 1.0,
            samples: vec![[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
            curve: vec![[0.0, 0.0], [1.0, 0.0]],
        };
        let figure = overlay("T", "Y", &[run]);
        assert_eq!(figure.size(), SIZE);
        let svg = figure.svg();
        assert_eq!(svg.matches("<circle").count(), 2, "{svg}");
        let image = figure.canvas();
        let colored = |x0: usize, y0: usize, x1: usize, y1: usize| {
            (y0..y1).any(|y| (x0..x1).any(|x| image.get(x, y) == RUNS[0]))
        };
        let [w, h] = SIZE.map(|n| n as usize);
        assert!(colored(w * 3 / 4, 40, w, h / 4), "the second dot is at the top right");
        assert!(colored(w / 3, h * 3 / 4, w / 2, h), "the line is at the bottom");
        assert!(!colored(w / 3, 40, w / 2, h / 2), "nothing elsewhere");
    }
}
