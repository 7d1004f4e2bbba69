//! What a policy knew of ball and goal when it was scored. A score means little without it.

use std::fmt;

use paid_task::TaskPreset;
use paid_task::preset::PerceptionPreset;
use serde::Serialize;

/// What a policy knew of ball and goal. Its [`Knowledge::name`] stands beside every score.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "name", rename_all = "snake_case")]
pub enum Knowledge {
    /// Ball and goal positions straight from the simulator: exact, current, never lost. The motion is chosen by them too.
    Truth {
        /// The simulator's ball velocity is known as well: the policy, and the choice of the motion, are told where a rolling ball will
        /// be at the strike.
        ball_velocity: bool,
    },
    /// The simulator's positions with the perception errors of the task preset. The motion is still chosen by the exact ball.
    Noisy {
        /// As for [`Knowledge::Truth`].
        ball_velocity: bool,
        /// Every error, in words.
        errors: Vec<String>,
    },
}

/// The paper's own figures: its policy sees where the ball is, is not told how it moves, and has a memory (recurrent).
pub const PAPER: &str = "ball position, no velocity, recurrent policy";
/// The same for a column.
pub const PAPER_SHORT: &str = "position, memory";

impl Knowledge {
    /// What an evaluation in `task` tells the policy.
    ///
    /// ```
    /// use paid_eval::knowledge::Knowledge;
    /// use paid_task::TaskPreset;
    ///
    /// let task = TaskPreset::builtin("paper_stage2")?;
    /// assert_eq!(Knowledge::of(&task).name(), "truth");
    /// # Ok::<(), paid_task::TaskError>(())
    /// ```
    pub fn of(task: &TaskPreset) -> Self {
        let ball_velocity = task.observations.lead_ball;
        let perception = &task.observations.perception;
        let errors = if perception.in_evaluation { errors(perception, ball_velocity) } else { Vec::new() };
        if errors.is_empty() { Self::Truth { ball_velocity } } else { Self::Noisy { ball_velocity, errors } }
    }

    /// One word: `truth` or `noisy`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Truth { .. } => "truth",
            Self::Noisy { .. } => "noisy",
        }
    }
}

impl fmt::Display for Knowledge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = |velocity: bool| {
            if velocity { "ball position and velocity" } else { "ball position, no velocity" }
        };
        match self {
            Self::Truth { ball_velocity } => {
                write!(f, "truth (the simulator's {})", what(*ball_velocity))
            }
            Self::Noisy { ball_velocity, errors } => write!(
                f,
                "noisy (the simulator's {}, with errors: {}; the motion is chosen by the exact ball)",
                what(*ball_velocity),
                errors.join(", ")
            ),
        }
    }
}

/// The errors of a perception preset in words; none for a perfect one.
fn errors(perception: &PerceptionPreset, ball_velocity: bool) -> Vec<String> {
    let p = perception;
    let mut words = Vec::new();
    if p.gaussian {
        words.push("Gaussian position noise".to_owned());
        if ball_velocity {
            words.push(format!("Gaussian velocity noise {} m/s", p.ball_velocity_m_s));
        }
    }
    if p.blind_zone {
        words.push("blind outside a distance band".to_owned());
    }
    let [lo, hi] = p.latency_s;
    if hi > 0.0 {
        words.push(if lo == hi {
            format!("positions {hi} s old")
        } else {
            format!("positions {lo} to {hi} s old")
        });
    }
    if p.frame_s > 0.0 {
        words.push(format!("a picture every {} s", p.frame_s));
    }
    if p.dropout > 0.0 {
        words.push(format!("{}% of pictures without the object", 100.0 * p.dropout));
    }
    if p.visible_band {
        words.push("seen only inside the camera's picture".to_owned());
    }
    // Only positions are late, held or lost.
    if ball_velocity && !words.is_empty() && !p.gaussian {
        words.push("velocity exact".to_owned());
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_is_the_usual_knowledge_and_says_whether_the_velocity_is_known() {
        let mut task = TaskPreset::builtin("paper_stage2").expect("built in");
        task.observations.lead_ball = false;
        let text = Knowledge::of(&task).to_string();
        assert_eq!(text, "truth (the simulator's ball position, no velocity)");
        task.observations.lead_ball = true;
        let text = Knowledge::of(&task).to_string();
        assert_eq!(text, "truth (the simulator's ball position and velocity)");
        // Errors that end with training are no part of an evaluation.
        task.observations.perception.gaussian = true;
        task.observations.perception.in_evaluation = false;
        assert_eq!(Knowledge::of(&task).name(), "truth");
    }

    #[test]
    fn errors_in_an_evaluation_are_all_named() {
        let mut task = TaskPreset::builtin("paper_stage2").expect("built in");
        task.observations.lead_ball = true;
        let p = &mut task.observations.perception;
        (p.in_evaluation, p.gaussian, p.blind_zone) = (true, false, false);
        (p.latency_s, p.frame_s, p.dropout, p.visible_band) = ([0.06; 2], 0.033, 0.1, true);
        let text = Knowledge::of(&task).to_string();
        for word in [
            "noisy",
            "0.06 s old",
            "a picture every 0.033 s",
            "10% of pictures",
            "camera",
            "velocity exact",
            "exact ball",
        ] {
            assert!(text.contains(word), "{word}: {text}");
        }
        task.observations.perception.gaussian = true;
        let text = Knowledge::of(&task).to_string();
        assert!(
            text.contains("Gaussian velocity noise 0.03 m/s") && !text.contains("velocity exact"),
            "{text}"
        );
        // Nothing errs: in_evaluation alone changes nothing.
        let p = &mut task.observations.perception;
        (p.gaussian, p.latency_s, p.frame_s, p.dropout, p.visible_band) = (false, [0.0; 2], 0.0, 0.0, false);
        assert_eq!(Knowledge::of(&task).name(), "truth");
    }
}
