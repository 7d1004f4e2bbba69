//! One iteration in numbers: a line of `metrics.jsonl`, the scalars of TensorBoard, a line in the terminal.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

/// Named numbers in a fixed order; a JSON object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Named(pub Vec<(String, f64)>);

impl Named {
    /// The number of that name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(n, _)| n == name).map(|(_, value)| *value)
    }
    /// True without any.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
    /// Appends a number.
    pub fn push(&mut self, name: impl Into<String>, value: f64) {
        self.0.push((name.into(), value));
    }
}

impl Serialize for Named {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

/// Optimizer figures of one iteration, means over its minibatches.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LossRecord {
    /// Clipped value loss.
    pub value_function: f64,
    /// PPO's surrogate loss.
    pub surrogate: f64,
    /// Entropy of the action distribution `[nat]`.
    pub entropy: f64,
    /// Learning rate after the iteration.
    pub learning_rate: f64,
    /// Mirror symmetry loss, before its weight; not written where it is off.
    #[serde(skip_serializing_if = "is_zero")]
    pub mirror: f64,
    /// Imitation loss, before its weight; not written without a teacher.
    #[serde(skip_serializing_if = "is_zero")]
    pub teacher: f64,
    /// KL divergence of the new policy from the old `[nat]`.
    pub kl: f64,
    /// Gradient norm before clipping.
    pub gradient_norm: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// Everything that is reported about an iteration.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Record {
    /// `stage1` or `stage2`.
    pub stage: String,
    /// Iterations done, this one included.
    pub iteration: u64,
    /// Iterations of the whole stage; 0 if only time limits it.
    pub iterations: u64,
    /// Environment steps done in the stage, this iteration included.
    pub samples: u64,
    /// What computed the products of hidden layers: `f32`, or a bfloat16 kernel ([`paid_learn::Learner::products`]).
    pub products: String,
    /// Training time of the stage so far, earlier starts included `[s]`.
    pub elapsed_s: f64,
    /// Time left to the end of this start, estimated `[s]`.
    pub eta_s: f64,
    /// Samples of the iteration over its duration `[1/s]`.
    pub samples_per_s: f64,
    /// Duration of the rollout `[s]`.
    pub collect_s: f64,
    /// Duration of the update `[s]`.
    pub learn_s: f64,
    /// Episodes that ended in this iteration.
    pub episodes: u64,
    /// Mean return of the last 100 or more ended episodes.
    pub mean_reward: f64,
    /// Mean length of the same episodes `[control steps]`.
    pub mean_episode_length: f64,
    /// Optimizer figures.
    pub loss: LossRecord,
    /// Mean standard deviation of the actions.
    pub mean_noise_std: f64,
    /// Mean of each weighted reward term `[1/s]`.
    pub rewards: Named,
    /// Share of the ended episodes by cause.
    pub terminations: Named,
    /// Tracking errors, kick statistics and other figures of the task.
    pub metrics: Named,
    /// Scores of an evaluation, in the iterations after which there was one.
    #[serde(skip_serializing_if = "Named::is_empty")]
    pub judge: Named,
    /// Environments that were reset because a number was not finite, in this iteration.
    pub nan_resets: u64,
    /// Observations and rewards that were not finite and were replaced by zero, in this iteration.
    pub nan_samples: u64,
    /// Minibatches that were skipped because a gradient was not finite, in this iteration.
    pub nan_minibatches: u64,
}

impl Record {
    /// The record as TensorBoard scalars under rsl_rl's tag names.
    pub fn scalars(&self) -> Vec<(String, f64)> {
        let mut tags: Vec<(String, f64)> = [
            ("Loss/value_function", self.loss.value_function),
            ("Loss/surrogate", self.loss.surrogate),
            ("Loss/entropy", self.loss.entropy),
            ("Loss/learning_rate", self.loss.learning_rate),
            ("Loss/kl", self.loss.kl),
            ("Loss/gradient_norm", self.loss.gradient_norm),
            ("Policy/mean_noise_std", self.mean_noise_std),
            ("Perf/total_fps", self.samples_per_s),
            ("Perf/collection time", self.collect_s),
            ("Perf/learning_time", self.learn_s),
            ("Train/mean_reward", self.mean_reward),
            ("Train/mean_episode_length", self.mean_episode_length),
            ("Train/samples", self.samples as f64),
            ("Train/nan_resets", self.nan_resets as f64),
            ("Train/nan_samples", self.nan_samples as f64),
            ("Train/nan_minibatches", self.nan_minibatches as f64),
        ]
        .map(|(tag, value)| (tag.to_owned(), value))
        .into();
        if self.loss.mirror != 0.0 {
            tags.push(("Loss/symmetry".to_owned(), self.loss.mirror));
        }
        if self.loss.teacher != 0.0 {
            tags.push(("Loss/teacher".to_owned(), self.loss.teacher));
        }
        for (prefix, named) in [
            ("Episode_Reward", &self.rewards),
            ("Episode_Termination", &self.terminations),
            ("Metrics", &self.metrics),
            ("judge", &self.judge),
        ] {
            tags.extend(named.0.iter().map(|(name, value)| (format!("{prefix}/{name}"), *value)));
        }
        tags
    }

    /// The record as a block of text for a terminal.
    pub fn text(&self) -> String {
        use core::fmt::Write;
        let mut out = String::new();
        let of = if self.iterations > 0 { format!("/{}", self.iterations) } else { String::new() };
        // Writing into a String cannot fail.
        let _ = writeln!(
            out,
            "{} iteration {}{of}  {:.2} M samples  {:.0} samples/s  collect {:.3} s  learn {:.3} s ({})  elapsed {}  ETA {}",
            self.stage,
            self.iteration,
            self.samples as f64 / 1e6,
            self.samples_per_s,
            self.collect_s,
            self.learn_s,
            self.products,
            duration(self.elapsed_s),
            duration(self.eta_s),
        );
        let _ = writeln!(
            out,
            "  reward {:.3}  episode {:.1} steps  episodes {}  value {:.4}  surrogate {:.4}  entropy {:.2}  \
             std {:.3}  lr {:.1e}  kl {:.4}",
            self.mean_reward,
            self.mean_episode_length,
            self.episodes,
            self.loss.value_function,
            self.loss.surrogate,
            self.loss.entropy,
            self.mean_noise_std,
            self.loss.learning_rate,
            self.loss.kl,
        );
        for (title, named) in [
            ("rewards", &self.rewards),
            ("ends", &self.terminations),
            ("metrics", &self.metrics),
            ("judge", &self.judge),
        ] {
            if title == "judge" && named.is_empty() {
                continue;
            }
            let cells: Vec<String> =
                named.0.iter().map(|(name, value)| format!("{name} {}", short(*value))).collect();
            let mut line = format!("  {title}:");
            for cell in cells {
                if line.len() + cell.len() > 118 {
                    let _ = writeln!(out, "{line}");
                    line = "   ".to_owned();
                }
                line.push_str("  ");
                line.push_str(&cell);
            }
            let _ = writeln!(out, "{line}");
        }
        if self.nan_resets + self.nan_samples + self.nan_minibatches > 0 {
            let _ = writeln!(
                out,
                "  not finite: {} environments reset, {} samples cleared, {} minibatches skipped",
                self.nan_resets, self.nan_samples, self.nan_minibatches
            );
        }
        out
    }
}

/// A number with about four significant digits.
fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        x if x >= 1000.0 => format!("{value:.0}"),
        x if x >= 10.0 => format!("{value:.2}"),
        x if x >= 0.001 => format!("{value:.4}"),
        _ => format!("{value:.1e}"),
    }
}

/// Seconds as `h:mm:ss` or `m:ss`.
fn duration(seconds: f64) -> String {
    let s = seconds.max(0.0).round() as u64;
    if s >= 3600 {
        format!("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
    } else {
        format!("{}:{:02}", s / 60, s % 60)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record() -> Record {
        Record {
            stage: "stage1".to_owned(),
            iteration: 3,
            rewards: Named(vec![("anchor_pos".to_owned(), 0.25)]),
            terminations: Named(vec![("time_out".to_owned(), 0.5)]),
            metrics: Named(vec![("mpjpe_mm".to_owned(), 30.0)]),
            ..Record::default()
        }
    }

    #[test]
    fn scalars_carry_the_names_that_rsl_rl_uses() {
        let tags = record().scalars();
        for tag in [
            "Loss/value_function",
            "Loss/surrogate",
            "Loss/entropy",
            "Loss/learning_rate",
            "Policy/mean_noise_std",
            "Perf/total_fps",
            "Perf/collection time",
            "Perf/learning_time",
            "Train/mean_reward",
            "Train/mean_episode_length",
            "Episode_Reward/anchor_pos",
            "Episode_Termination/time_out",
            "Metrics/mpjpe_mm",
        ] {
            assert!(tags.iter().any(|(t, _)| t == tag), "{tag}");
        }
    }

    #[test]
    fn a_json_line_keeps_terms_as_an_object() {
        let line = serde_json::to_string(&record()).expect("json");
        let value: serde_json::Value = serde_json::from_str(&line).expect("json");
        assert_eq!(value["rewards"]["anchor_pos"], 0.25);
        assert_eq!(value["iteration"], 3);
        assert!(!line.contains('\n'));
    }

    #[test]
    fn scores_are_written_only_where_there_were_any() {
        let mut judged = record();
        judged.judge.push("mujoco_goal", 0.75);
        assert!(judged.scalars().contains(&("judge/mujoco_goal".to_owned(), 0.75)));
        assert!(serde_json::to_string(&judged).expect("json").contains(r#""judge":{"mujoco_goal":0.75}"#));
        assert!(judged.text().contains("judge:  mujoco_goal 0.75"), "{}", judged.text());
        let plain = record();
        assert!(!serde_json::to_string(&plain).expect("json").contains("judge"));
        assert!(!plain.text().contains("judge"));
    }

    #[test]
    fn text_names_every_term() {
        let text = record().text();
        for word in ["anchor_pos 0.25", "time_out 0.5", "mpjpe_mm 30.00", "ETA 0:00"] {
            assert!(text.contains(word), "{word} in {text}");
        }
        assert_eq!(duration(3725.0), "1:02:05");
    }
}
