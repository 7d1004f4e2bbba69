//! Ball-placement curriculum: balls begin near their motion's own place and spread while the robot hits them.

use serde::{Deserialize, Serialize};

use crate::preset::BallPlacement;

/// How far the balls have spread. The trainer advances it and hands it to every shard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BallCurriculum {
    /// Progress from `ball.spread_from` (0) to the places that were drawn (1).
    pub progress: f32,
}

impl BallCurriculum {
    /// Lets the balls spread by a step if in an iteration this share of the episodes sent the ball toward the goal.
    pub fn advance(&mut self, on_target: f64, preset: &BallPlacement) {
        if on_target >= preset.spread_at {
            self.progress = (self.progress + 1.0 / preset.spread_iterations.max(1) as f32).min(1.0);
        }
    }

    /// Share of a ball's displacement from its motion's nominal place that is applied now.
    pub fn reach(&self, preset: &BallPlacement) -> f64 {
        preset.spread_from + (1.0 - preset.spread_from) * f64::from(self.progress)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TaskPreset;

    #[test]
    fn balls_spread_while_they_are_hit_and_stay_where_they_are_while_not() {
        let stage2 = TaskPreset::builtin("paper_stage2").expect("a preset").ball;
        let preset = BallPlacement { spread_from: 0.2, spread_at: 0.5, spread_iterations: 4, ..stage2 };
        let mut curriculum = BallCurriculum::default();
        let reach: Vec<f64> = [0.6, 0.4, 0.5, 0.9, 1.0, 1.0]
            .iter()
            .map(|&hits| {
                curriculum.advance(hits, &preset);
                curriculum.reach(&preset)
            })
            .collect();
        for (found, expected) in reach.iter().zip([0.4, 0.4, 0.6, 0.8, 1.0, 1.0]) {
            assert!((found - expected).abs() < 1e-6, "{reach:?}");
        }
    }
}
