//! `speed.svg`: training and physics next to other programs, as bars.

use std::fmt::Write;

/// A bar: who, on what, how many a second, whether it is this program.
type Bar = (&'static str, &'static str, f64, bool);

/// Training samples per second. The first three were measured here (`docs/src`, "Measured"), the others are published:
/// Isaac Lab's benchmark page (docs.nvidia.com/isaaclab, version 2.1) and a user's report in mjlab's issue 1056 (3.87 s an
/// iteration, counted as mjlab's default of 4096 environments and 24 steps).
const TRAINING: [Bar; 5] = [
    ("PAiD in Rust, following kicks", "2 cores, Xeon with AMX", 173_000.0, true),
    ("PAiD in Rust, following kicks", "2 cores, EPYC Zen 4", 109_000.0, true),
    ("MuJoCo and PyTorch, same sizes", "2 cores, Xeon with AMX", 9_570.0, false),
    ("Isaac Lab, G1 on rough ground*", "RTX 4090, Ryzen 9 7950X", 82_000.0, false),
    ("mjlab, motion tracking**", "RTX 4070 Ti", 25_000.0, false),
];

/// Physics steps per second, measured here on one core of an EPYC (Zen 4) with `paid bench physics`.
const PHYSICS: [Bar; 3] = [
    ("PAiD in Rust", "robot and ball", 1_510_000.0, true),
    ("MuJoCo 3.17.0", "the same soles", 20_900.0, false),
    ("MuJoCo 3.17.0", "the vendor's feet", 13_800.0, false),
];

const NOTES: [&str; 4] = [
    "Measured here, except * and **, which are published for other tasks: compare the order of magnitude.",
    "MuJoCo and PyTorch: networks of the same sizes, 1920 environments, a reward of few terms.",
    "* Velocity-Rough-G1, 4096 environments, with training: NVIDIA's Isaac Lab 2.1 benchmarks.",
    "** A user's 3.87 s an iteration (mjlab issue 1056), if it had the default 4096 x 24 samples.",
];

const WIDTH: u32 = 860;
const ROW: u32 = 26;
/// Where bars begin, and the longest.
const LEFT: u32 = 440;
const LONGEST: f64 = 330.0;

/// The picture.
pub fn svg() -> String {
    let mut body = String::new();
    let mut y = 30;
    panel(&mut body, &mut y, "Training samples per second", &TRAINING);
    panel(&mut body, &mut y, "Physics steps per second, one core of an EPYC Zen 4", &PHYSICS);
    for note in NOTES {
        line(&mut body, (20, y), "s", note);
        y += 17;
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{y}\" viewBox=\"0 0 {WIDTH} {y}\" \
         font-family=\"sans-serif\" font-size=\"14\" fill=\"#1f2328\">\n\
         <style>.s {{ font-size: 12px; fill: #59636e }} .t {{ font-size: 16px; font-weight: bold }}</style>\n\
         <rect width=\"{WIDTH}\" height=\"{y}\" fill=\"#ffffff\"/>\n{body}</svg>\n"
    )
}

fn line(body: &mut String, (x, y): (u32, u32), class: &str, text: &str) {
    // Writing to a string does not fail.
    let _ = writeln!(body, "<text x=\"{x}\" y=\"{y}\" class=\"{class}\">{text}</text>");
}

/// Draws a title and bars from `y` on, and moves `y` below them.
fn panel(body: &mut String, y: &mut u32, title: &str, bars: &[Bar]) {
    line(body, (20, *y), "t", title);
    *y += ROW;
    let most = bars.iter().fold(0.0, |most: f64, bar| most.max(bar.2));
    for (who, machine, speed, ours) in bars {
        let width = (LONGEST * speed / most).max(1.0);
        let color = if *ours { "#1a7f37" } else { "#8c959f" };
        line(body, (20, *y), "", who);
        line(body, (255, *y), "s", machine);
        let top = *y - 14;
        let _ = writeln!(
            body,
            "<rect x=\"{LEFT}\" y=\"{top}\" width=\"{width:.1}\" height=\"18\" fill=\"{color}\"/>"
        );
        line(body, (LEFT + width as u32 + 8, *y), "", &thousands(*speed));
        *y += ROW;
    }
    *y += 14;
}

/// A whole number with commas.
fn thousands(number: f64) -> String {
    let digits = format!("{number:.0}");
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_commas() {
        assert_eq!([109_000.0, 25.0, 1_510_000.0].map(thousands), ["109,000", "25", "1,510,000"]);
    }

    #[test]
    fn the_committed_picture_is_this_one() {
        assert_eq!(include_str!("../../../docs/src/pictures/speed.svg"), svg());
    }
}
