//! Whether a network's numbers are those of its kind: what is shaped like a detector's output may be something else.

use super::Kind;
use crate::PixelBox;

/// Rounding of a score beyond 0 and 1.
const ROUNDING: f32 = 1e-3;
/// Score from which a box must make sense by itself.
const CERTAIN: f32 = 0.25;
/// A certain box is at most this many times as large as the input; any box, and its distance from the input, is below the second.
const LARGEST: [f64; 2] = [4.0, 16.0];

/// Checks the first output of a network of this kind with this input `[px]`.
///
/// # Errors
/// Which numbers, expected, found.
pub(super) fn check(kind: Kind, size: [usize; 2], output: &[f32]) -> Result<(), [String; 3]> {
    if let Some(at) = output.iter().position(|x| !x.is_finite()) {
        return Err(["output".to_owned(), "finite numbers".to_owned(), format!("{} at {at}", output[at])]);
    }
    let cells = super::kind::cells(size);
    match kind {
        Kind::Own => Ok(()),
        Kind::YoloV8 { classes, .. } => (0..cells).try_for_each(|cell| {
            let at = |row: usize| output[row * cells + cell];
            let outline =
                PixelBox::around([f64::from(at(0)), f64::from(at(1))], [f64::from(at(2)), f64::from(at(3))]);
            let best = scores((4..4 + classes).map(at))?;
            place(&outline, best >= CERTAIN, size)
        }),
        Kind::YoloX { classes } => {
            super::decode::grid(size).zip(output.chunks_exact(5 + classes)).try_for_each(|(cell, row)| {
                let best = scores(row[5..].iter().copied())? * scores(row[4..5].iter().copied())?;
                place(&super::decode::yolo_x_box(cell, row), best >= CERTAIN, size)
            })
        }
    }
}

/// The largest of a cell's scores.
fn scores(scores: impl Iterator<Item = f32>) -> Result<f32, [String; 3]> {
    let mut best = 0.0_f32;
    for score in scores {
        if !(-ROUNDING..=1.0 + ROUNDING).contains(&score) {
            let found = format!("{score}: key points, angles, logits or another order of the output");
            return Err(["scores".to_owned(), "numbers from 0 to 1".to_owned(), found]);
        }
        best = best.max(score);
    }
    Ok(best)
}

/// Whether a box can be one.
fn place(outline: &PixelBox, certain: bool, [width, height]: [usize; 2]) -> Result<(), [String; 3]> {
    let side = width.max(height) as f64;
    let ([w, h], middle) = (outline.size(), outline.middle());
    let sound = if certain {
        w.min(h) >= 0.0
            && w.max(h) >= 1.0
            && w.max(h) <= LARGEST[0] * side
            && outline.clipped(width, height).area() > 0.0
    } else {
        w.max(h) <= LARGEST[1] * side && middle.iter().all(|x| x.abs() <= LARGEST[1] * side)
    };
    if sound {
        return Ok(());
    }
    let [w, h, x, y] = [w, h, middle[0], middle[1]].map(|pixels| match pixels {
        _ if pixels.abs() < 1e5 => format!("{pixels:.1}"),
        _ => format!("{pixels:.1e}"),
    });
    let expected = format!("boxes in the input of {width} x {height} pixels");
    let found = format!(
        "one of {w} x {h} at ({x}, {y}): decoded twice or not at all, transposed, or in shares of the input"
    );
    Err(["boxes".to_owned(), expected, found])
}
