//! Boxes that a network found, before and after the choice among those that overlap.

use crate::PixelBox;

/// A box with its score, in the network's input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    /// The box `[px of the input]`.
    pub outline: PixelBox,
    /// 0 to 1.
    pub score: f64,
    /// Which of the network's cells it comes from.
    pub index: usize,
}

/// Keeps the best of those that overlap by more than `iou`, best first.
pub(super) fn suppress(mut candidates: Vec<Candidate>, iou: f64, most: usize) -> Vec<Candidate> {
    candidates.retain(|c| {
        c.score.is_finite()
            && c.outline.min.iter().chain(&c.outline.max).all(|v| v.is_finite())
            && c.outline.area() > 0.0
    });
    // Equal scores stay in the network's order: the same image gives the same boxes.
    candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut kept: Vec<Candidate> = Vec::new();
    for candidate in candidates {
        if kept.len() == most {
            break;
        }
        if kept.iter().all(|k| k.outline.iou(&candidate.outline) <= iou) {
            kept.push(candidate);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(x: f64, score: f64, index: usize) -> Candidate {
        Candidate { outline: PixelBox { min: [x, 0.0], max: [x + 10.0, 10.0] }, score, index }
    }

    #[test]
    fn the_best_of_overlapping_boxes_stays() {
        // Overlaps: 0 and 2 by 8/12, 2 and 6 by 6/14, 0 and 6 by 4/16.
        let found = vec![
            candidate(0.0, 0.6, 0),
            candidate(2.0, 0.9, 1),
            candidate(6.0, 0.5, 2),
            candidate(40.0, 0.7, 3),
        ];
        let kept: Vec<usize> = suppress(found, 0.45, 9).iter().map(|c| c.index).collect();
        assert_eq!(kept, [1, 3, 2]);
    }

    #[test]
    fn numbers_that_are_none_and_empty_boxes_are_dropped() {
        let mut broken = candidate(0.0, f64::NAN, 0);
        broken.outline.min[0] = 0.0;
        let mut turned = candidate(0.0, 0.9, 1);
        turned.outline.max[0] = -5.0;
        let mut endless = candidate(0.0, 0.9, 2);
        endless.outline.max[1] = f64::INFINITY;
        let kept = suppress(vec![broken, turned, endless, candidate(0.0, 0.5, 3)], 0.45, 9);
        assert_eq!(kept.len(), 1);
        assert_eq!(kept[0].index, 3);
    }
}
