//! How the policies of a comparison learned: one diagram with a line for each run.

use std::path::PathBuf;

use paid_eval::EvalError;
use paid_eval::curves::Curves;
use paid_plot::{Anchor, Chart, Figure, Rgb, Series};

/// Colors of the lines, in the order of the plan.
const COLORS: [Rgb; 8] = [
    [31, 119, 180],
    [214, 39, 40],
    [44, 160, 44],
    [255, 127, 14],
    [148, 103, 189],
    [140, 86, 75],
    [23, 190, 207],
    [127, 127, 127],
];
/// Height of a line of the legend in pixels.
const LINE: i64 = 24;

/// A line of the diagram.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// What the legend calls it.
    pub name: String,
    /// Folders of its stages, in order.
    pub stages: Vec<PathBuf>,
}

/// Shots on target of the episodes in training, over the samples of all stages. There is none in Stage I, where the line lies at zero.
///
/// # Errors
/// If a log cannot be read.
pub fn figure(courses: &[Course]) -> Result<Figure, EvalError> {
    let mut series = Vec::new();
    for (course, color) in courses.iter().zip(COLORS.into_iter().cycle()) {
        let (mut points, mut before) = (Vec::new(), 0.0);
        for stage in &course.stages {
            let curves = Curves::read(stage)?;
            let path = ["metrics", "kick/on_target"];
            points
                .extend(curves.series(&path, color).points.into_iter().map(|[x, y]| [before + x, 100.0 * y]));
            before += curves.samples() * 1e-6;
        }
        series.push(Series { points, color, dots: false });
    }
    let chart = Chart {
        title: "shots on target in training (built-in engine)",
        x_label: "samples [million]",
        y_label: "[% of episodes]",
        logarithmic: false,
        series,
    };
    let diagram = chart.draw();
    let [width, height] = diagram.size();
    let rows = i64::try_from(courses.len()).unwrap_or(i64::MAX / LINE - 1);
    let mut figure = Figure::new(width, height + LINE * (rows + 1));
    figure.place([0, 0], &diagram);
    for (k, (course, color)) in (0_i64..).zip(courses.iter().zip(COLORS.into_iter().cycle())) {
        let y = height + LINE * k + LINE / 2;
        figure.line(vec![[90.0, y as f64], [130.0, y as f64]], 3, color);
        figure.text([140, y + 5], 14, Anchor::Start, &course.name);
    }
    Ok(figure)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stages_of_a_course_follow_each_other() {
        let folder = tempfile::tempdir().expect("a folder");
        let stage = |name: &str, shares: &[f64]| {
            let run = folder.path().join(name);
            std::fs::create_dir(&run).expect("made");
            let line = |(k, share): (usize, &f64)| {
                let samples = 1_000_000 * (k + 1);
                format!(
                    "{{\"iteration\":{0},\"samples\":{samples},\"metrics\":{{\"kick/on_target\":{share}}}}}\n",
                    k + 1
                )
            };
            let lines: String = shares.iter().enumerate().map(line).collect();
            std::fs::write(run.join("metrics.jsonl"), lines).expect("written");
            run
        };
        let stages = vec![stage("one", &[0.0, 0.0]), stage("two", &[0.25, 0.5])];
        let name = "Ours & <theirs>".to_owned();
        let svg = figure(&[Course { name, stages }]).expect("drawn").svg();
        assert!(svg.contains("Ours &amp; &lt;theirs&gt;") && svg.contains("shots on target"), "{svg}");
        // Samples go to 4 million: the second stage begins where the first one ended.
        assert!(svg.contains(">4.0<"), "{svg}");
        let absent = Course { name: String::new(), stages: vec![folder.path().join("absent")] };
        assert!(figure(&[absent]).expect_err("absent").to_string().contains("absent"));
    }
}
