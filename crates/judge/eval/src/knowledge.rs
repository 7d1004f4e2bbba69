//! What a policy was given of ball and goal when it was scored. A score means little without it.

use std::fmt;

use paid_task::TaskPreset;
use paid_task::preset::EyesPreset;
use serde::Serialize;

/// What a policy was given of ball and goal. Its [`Knowledge::name`] is stated with every score.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "name", rename_all = "snake_case")]
pub enum Knowledge {
    /// Ball and goal positions straight from the simulator: exact, current, never lost. The motion is chosen by them too.
    Truth {
        /// The simulator's ball velocity is given as well: the policy, and the choice of the motion, use the position where a rolling ball will
        /// be at the strike.
        ball_velocity: bool,
    },
    /// The estimates of simulated camera, odometry and ball tracker. The motion is chosen by them too.
    Perceived {
        /// The policy is given the position where the tracker expects a rolling ball at the strike.
        ball_velocity: bool,
        /// Eyes and odometry, in words.
        eyes: Vec<String>,
    },
    /// The estimates of the whole pipeline from rendered images and simulated sensors. The motion is chosen by them too.
    Eyes {
        /// As for [`Knowledge::Perceived`].
        ball_velocity: bool,
        /// Camera, detector and odometry, in words.
        eyes: Vec<String>,
    },
}

/// The paper's own figures: its policy is given the ball's position, not its velocity, and is recurrent.
pub const PAPER: &str = "ball position, no velocity, recurrent policy";
/// The same for a column.
pub const PAPER_SHORT: &str = "position, memory";

impl Knowledge {
    /// What an evaluation in `task` gives the policy.
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
        let ball_velocity = task.predicts_ball();
        if task.perceives() {
            return Self::Perceived { ball_velocity, eyes: eyes(&task.eyes) };
        }
        Self::Truth { ball_velocity }
    }

    /// One word: `truth`, `perceived` or `eyes`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Truth { .. } => "truth",
            Self::Perceived { .. } => "perceived",
            Self::Eyes { .. } => "eyes",
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
            Self::Perceived { ball_velocity, eyes } => write!(
                f,
                "perceived (the tracker's {}, from {}; the motion is chosen by the same estimates)",
                what(*ball_velocity),
                eyes.join(", ")
            ),
            Self::Eyes { ball_velocity, eyes } => write!(
                f,
                "eyes (the tracker's {}, from {}; the motion is chosen by the same estimates)",
                what(*ball_velocity),
                eyes.join(", ")
            ),
        }
    }
}

/// Numbers of a range in words.
fn range([lo, hi]: [f64; 2]) -> String {
    if lo == hi { format!("{lo}") } else { format!("{lo} to {hi}") }
}

/// Eyes and odometry in words.
fn eyes(p: &EyesPreset) -> Vec<String> {
    let camera = &p.camera;
    let mut words = vec![
        format!("{} images/s of {} x {} degrees", range(p.rate_hz), camera.across_deg, camera.upright_deg),
        format!("{} s old", range(p.latency_s)),
        format!("noise {} m + {:.2}% of the distance + speed/{}", p.c_min, 100.0 / p.c_dist, p.c_vel),
    ];
    if p.noise_scale != [1.0; 2] {
        words.push(format!("scaled by {} unknown to the tracker", range(p.noise_scale)));
    }
    if p.dropout[1] > 0.0 {
        words.push(format!("{}% of them without a detection", range(p.dropout.map(|share| 100.0 * share))));
    }
    if p.false_share > 0.0 {
        words.push(format!("{}% false detections", 100.0 * p.false_share));
    }
    let o = &p.odometry;
    words.push(format!(
        "odometry off by {} m, drifting {} m/s and {} deg/s",
        range(o.offset_m),
        range(o.drift_m_s),
        range(o.heading_drift_deg_s)
    ));
    if p.decay_scale != [1.0; 2] {
        words.push(format!("rolling decay known to a factor of {}", range(p.decay_scale)));
    }
    words.push(format!("{} images before the start", p.first_look));
    words
}

#[cfg(test)]
mod tests {
    use paid_policy::observation::ObservationId;
    use paid_task::preset::KnowledgeMode;

    use super::*;

    /// Shows the policy the ball where it will be at the strike.
    fn predict(task: &mut TaskPreset) {
        for term in &mut task.observations.policy {
            if *term == ObservationId::BallPos {
                *term = ObservationId::BallAtStrike;
            }
        }
        assert!(task.predicts_ball());
    }

    #[test]
    fn truth_is_the_usual_knowledge_and_says_whether_the_velocity_is_known() {
        let mut task = TaskPreset::builtin("paper_stage2").expect("built in");
        let text = Knowledge::of(&task).to_string();
        assert_eq!(text, "truth (the simulator's ball position, no velocity)");
        predict(&mut task);
        let text = Knowledge::of(&task).to_string();
        assert_eq!(text, "truth (the simulator's ball position and velocity)");
    }

    #[test]
    fn the_eyes_are_told_in_words() {
        let task = TaskPreset::builtin("paper_stage2").expect("built in");
        let mut task = task.with_knowledge(KnowledgeMode::Perceived);
        predict(&mut task);
        task.eyes.noise_scale = [2.0; 2];
        task.eyes.latency_s = [0.06, 0.1];
        let knowledge = Knowledge::of(&task);
        let text = knowledge.to_string();
        assert_eq!(knowledge.name(), "perceived");
        for words in [
            "perceived (the tracker's ball position and velocity, from 30 images/s of 69 x 42 degrees",
            "0.06 to 0.1 s old",
            "noise 0.01 m + 1.00% of the distance + speed/16.7, scaled by 2 unknown to the tracker",
            "5% of them without a detection",
            "1% false detections",
            "odometry off by 0.01 m, drifting 0.01 m/s and 0.23 deg/s",
            "the motion is chosen by the same estimates",
        ] {
            assert!(text.contains(words), "{words}: {text}");
        }
        let json = serde_json::to_value(&knowledge).expect("plain data");
        assert_eq!(json["name"], "perceived");
    }
}
