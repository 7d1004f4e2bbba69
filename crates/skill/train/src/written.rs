//! Presets that a program wrote: those of checkpoints, policies and run folders. The program may have been an earlier or a later one, so
//! that keys which this one does not know are left out where the file turns them off.

use paid_task::layers::{KeyError, Tree, join};
use toml::Value;

use crate::{RunPreset, TrainError};

/// This program, as files name their writer.
const PROGRAM: &str = concat!("paid ", env!("CARGO_PKG_VERSION"));
/// Beginning of the first line of a preset that a program wrote.
const WRITTEN_BY: &str = "# Written by ";

/// Removed keys whose value for "off" is not 0, false or empty: the key is off in a file where each of these keys has this value.
/// A removed term with a weight needs no entry.
const FORMERLY_OFF: [(&str, &[(&str, &str)]); 3] = [
    ("task.exploration", &[("task.exploration.near_strike", "1.0")]),
    ("task.observations.critic_told_truth", &[("task.observations.critic_told_truth", "true")]),
    (
        "task.observations.perception",
        &[
            ("task.observations.perception.gaussian", "false"),
            ("task.observations.perception.blind_zone", "false"),
            ("task.observations.perception.visible_band", "false"),
            ("task.observations.perception.latency_s", "[0.0, 0.0]"),
            ("task.observations.perception.frame_s", "0.0"),
            ("task.observations.perception.dropout", "0.0"),
        ],
    ),
];

/// `text`, a resolved preset, with its writer in the first line.
pub(crate) fn signed(text: &str) -> String {
    format!("{WRITTEN_BY}{PROGRAM}.\n{text}")
}

/// The program that wrote a preset.
fn writer(text: &str) -> &str {
    let line = text.lines().next().and_then(|line| line.strip_prefix(WRITTEN_BY));
    line.map_or("an earlier version", |writer| writer.trim_end_matches('.'))
}

/// The part of a written preset that this program knows.
///
/// # Errors
/// If the rest is not turned off: key, value, the file's writer, and what to do.
pub(crate) fn known_part(place: &str, text: &str) -> Result<Tree, TrainError> {
    let mut tree = Tree::parse(place, text)?;
    // Made when it is needed, which is seldom.
    let mut stages = Vec::new();
    while let Some(key) = unknown_key(&tree) {
        if stages.is_empty() {
            stages = in_all_phases(&tree);
        }
        if let Some(stage) = stages.iter().find(|stage| !is_off(stage, &key)) {
            let value = stage.value(&key).map_or_else(String::new, |value| value.to_string());
            let message = format!(
                "{key} = {value}: this program ({PROGRAM}) has no such key, and the file, written by {}, does not turn it off; use the \
                 program that wrote the file (for a term of another crate: one that is built with that crate), or train again",
                writer(text)
            );
            return Err(TrainError::Preset { place: place.to_owned(), message });
        }
        tree.take(&key);
        for phase in 0..stages.len() - 1 {
            tree.take(&join(&format!("phases.{phase}"), &key));
        }
    }
    Ok(tree)
}

/// The first key that the preset or one of its phases has and this program does not know, as it is called outside of phases.
fn unknown_key(tree: &Tree) -> Option<String> {
    let error = match tree.typed::<RunPreset>() {
        Ok(preset) => preset.check_phases().err()?,
        Err(error) => error,
    };
    error.is_unknown_key().then(|| outside_of_phases(&error))
}

fn outside_of_phases(error: &KeyError) -> String {
    let inside = error.key.strip_prefix("phases.").and_then(|key| key.split_once('.'));
    inside.map_or(error.key.as_str(), |(_, key)| key).to_owned()
}

/// What holds before the first phase, and in each phase.
fn in_all_phases(tree: &Tree) -> Vec<Tree> {
    let mut stage = tree.clone();
    stage.take("phases");
    let mut stages = vec![stage.clone()];
    for phase in 0.. {
        let Some(phase) = tree.subtree(&format!("phases.{phase}")) else { break };
        stage.lay(phase);
        stages.push(stage.clone());
    }
    stages
}

/// True if a key that this program does not know says nothing.
fn is_off(tree: &Tree, key: &str) -> bool {
    let weightless =
        |table: &str| tree.value(&join(table, "weight")).is_some_and(|weight| is_nothing(&weight));
    let above = key.match_indices('.').map(|(end, _)| &key[..end]);
    if above.chain([key]).any(weightless) || tree.value(key).is_none_or(|value| is_nothing(&value)) {
        return true;
    }
    let holds = |(key, off): &(&str, &str)| tree.value(key).is_some_and(|value| value.to_string() == *off);
    FORMERLY_OFF.iter().any(|(former, off)| *former == key && off.iter().all(holds))
}

/// Zero, false, empty, or a list or table of such values.
fn is_nothing(value: &Value) -> bool {
    match value {
        Value::Boolean(on) => !on,
        Value::Integer(number) => *number == 0,
        Value::Float(number) => *number == 0.0,
        Value::String(text) => text.is_empty(),
        Value::Array(values) => values.iter().all(is_nothing),
        Value::Table(table) => table.values().all(is_nothing),
        Value::Datetime(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn preset() -> String {
        RunPreset::resolve("stage2", &[]).expect("built in").to_toml().expect("writes")
    }

    fn with(text: &str, table: &str, lines: &str) -> String {
        let changed = text.replacen(&format!("[{table}]\n"), &format!("[{table}]\n{lines}\n"), 1);
        assert_ne!(changed, text);
        changed
    }

    #[test]
    fn keys_of_another_program_that_a_file_turns_off_are_left_out() {
        let text = preset();
        let known = RunPreset::from_resolved("x", &text, &[]).expect("reads");
        for (table, off) in [
            ("task.rewards", "wave = { weight = 0.0, hand_m = 0.3 }"),
            ("task.rewards.fall", "hard_m = 0.3"),
            ("task.observations.noise", "wind = 0.0"),
            ("run", "wind = { on = false, speed_m_s = [0.0, 0.0], names = [], of = \"\" }"),
        ] {
            let read = RunPreset::from_resolved("x", &with(&text, table, off), &[]);
            assert_eq!(read.expect(off), known, "{off}");
        }
    }

    #[test]
    fn a_key_of_another_program_that_is_on_is_refused_with_value_writer_and_a_way_out() {
        let text = with(&preset(), "task.rewards", "wave = { weight = -0.5, hand_m = 0.3 }");
        let refused = |text: &str| RunPreset::from_resolved("x", text, &[]).expect_err("on").to_string();
        assert_eq!(
            refused(&text.replacen(PROGRAM, "paid 7.0", 1)),
            format!(
                "preset x: task.rewards.wave = {{ hand_m = 0.3, weight = -0.5 }}: this program ({PROGRAM}) has no such key, and the \
                 file, written by paid 7.0, does not turn it off; use the program that wrote the file (for a term of another crate: one \
                 that is built with that crate), or train again"
            )
        );
        let unsigned = text.split_once('\n').expect("lines").1;
        assert!(refused(unsigned).contains("written by an earlier version"), "{}", refused(unsigned));
    }

    #[test]
    fn a_key_of_another_program_counts_in_every_phase() {
        let phased = |then: &str| {
            let text = with(&preset(), "task.rewards", "wave = { weight = 0.0, hand_m = 0.3 }");
            let phase = format!("[[phases]]\nfrom = 0.99\ntask.rewards.wave.{then}\n\n[run]\n");
            RunPreset::from_resolved("x", &text.replacen("[run]\n", &phase, 1), &[])
        };
        phased("hand_m = 0.2").expect("no weight in any phase");
        let error = phased("weight = 1.0").expect_err("on").to_string();
        assert!(error.contains("task.rewards.wave = { hand_m = 0.3, weight = 1.0 }"), "{error}");
    }
}
