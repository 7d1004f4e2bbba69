//! Every value of a run preset and where it comes from: `paid train --explain`.

use core::fmt;

use paid_task::layers::{Origin, Tree};
use serde::ser::{SerializeMap, SerializeStruct};
use serde::{Serialize, Serializer};
use toml::Value;

use crate::{Resolved, TrainError};

/// All values of a preset, in the order of its types.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// The preset's files, its own first, its base after it.
    pub files: Vec<String>,
    /// Fraction of the run after which each phase begins.
    pub phases: Vec<f64>,
    /// One row per key.
    pub rows: Vec<Row>,
}

/// A key, its value, and its values in the phases.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Dotted key.
    pub key: String,
    /// The value at the start of the run.
    pub value: Value,
    /// Where it comes from.
    pub origin: Origin,
    /// Index of a phase, the value it sets, and where that comes from.
    pub later: Vec<(usize, Value, Origin)>,
}

impl Explanation {
    /// Explains a preset.
    ///
    /// # Errors
    /// If a value has no TOML form.
    pub fn of(resolved: &Resolved) -> Result<Self, TrainError> {
        let (preset, origins) = (&resolved.preset, &resolved.origins);
        // A struct writes its keys in the order of its fields, and the lines of the text keep it.
        let text = Tree::parse("", &preset.to_toml()?)?;
        let mut keys: Vec<(Origin, String, Value)> = text
            .leaves()
            .into_iter()
            .filter(|(key, ..)| !key.starts_with("phases"))
            .map(|(key, value, line)| (line.clone(), key, value.clone()))
            .collect();
        keys.sort_by(|a, b| a.0.cmp(&b.0));
        let later = |key: &str| {
            (0..preset.phases.len())
                .filter_map(|k| {
                    let place = format!("phases.{k}.{key}");
                    Some((k, origins.value(&place)?, origins.origin(&place)))
                })
                .collect()
        };
        let rows = keys.into_iter().map(|(_, key, value)| {
            let (origin, later) = (origins.origin(&key), later(&key));
            Row { key, value, origin, later }
        });
        Ok(Self {
            files: resolved.files.clone(),
            phases: preset.phases.iter().map(|phase| phase.from).collect(),
            rows: rows.collect(),
        })
    }
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "# {}", self.files.join(", over "))?;
        let names = self.rows.iter().map(|row| row.key.rsplit_once('.').map_or(&*row.key, |(_, name)| name));
        let width = names.map(str::len).max().unwrap_or(0);
        let cell = |value: &Value| format!("{:<28}", value.to_string());
        let mut group = "";
        for row in &self.rows {
            let (table, name) = row.key.rsplit_once('.').unwrap_or(("", &row.key));
            if table != group {
                writeln!(f, "\n[{table}]")?;
                group = table;
            }
            writeln!(f, "{name:<width$} = {}  # {}", cell(&row.value), row.origin)?;
            for (phase, value, origin) in &row.later {
                let from = format!("from {}%", (self.phases[*phase] * 1000.0).round() / 10.0);
                writeln!(f, "{from:>width$} : {}  # {origin}", cell(value))?;
            }
        }
        Ok(())
    }
}

/// An origin as JSON.
struct Whence<'a>(&'a Origin);

impl Serialize for Whence<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        match self.0 {
            Origin::File { file, line } => {
                map.serialize_entry("file", &**file)?;
                map.serialize_entry("line", line)?;
            }
            Origin::Set(text) => map.serialize_entry("set", text)?,
            Origin::Default => map.serialize_entry("default", &true)?,
        }
        map.end()
    }
}

impl Serialize for Row {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Later<'a> {
            phase: usize,
            value: &'a Value,
            origin: Whence<'a>,
        }
        let later: Vec<Later<'_>> = self
            .later
            .iter()
            .map(|(phase, value, origin)| Later { phase: *phase, value, origin: Whence(origin) })
            .collect();
        let mut row = serializer.serialize_struct("Row", 4)?;
        row.serialize_field("key", &self.key)?;
        row.serialize_field("value", &self.value)?;
        row.serialize_field("origin", &Whence(&self.origin))?;
        row.serialize_field("phases", &later)?;
        row.end()
    }
}

impl Serialize for Explanation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut all = serializer.serialize_struct("Explanation", 3)?;
        all.serialize_field("files", &self.files)?;
        all.serialize_field("phases_from", &self.phases)?;
        all.serialize_field("values", &self.rows)?;
        all.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn explained(name: &str, sets: &[&str]) -> Explanation {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        Explanation::of(&Resolved::load(name, &sets, "").expect("resolves")).expect("explains")
    }

    fn row<'a>(explanation: &'a Explanation, key: &str) -> &'a Row {
        explanation.rows.iter().find(|row| row.key == key).expect(key)
    }

    #[test]
    fn every_value_names_its_file_phase_override_or_default() {
        let all = explained("recurrent", &["run.envs=64", "run.shards=4"]);
        assert_eq!(all.files, ["recurrent.toml", "stage2.toml", "paper_stage2.toml"]);
        let origin = |key: &str| row(&all, key).origin.to_string();
        assert_eq!(origin("run.envs"), "--set");
        assert!(origin("learn.actor.kind").starts_with("recurrent.toml:"));
        assert!(origin("run.average_last").starts_with("stage2.toml:"));
        assert!(origin("task.rewards.body_pos.exclude_feet").starts_with("paper_stage2.toml:"));
        assert!(origin("task.ball_params.mass_kg").starts_with("surfaces/hard.toml:"));
        assert_eq!(origin("learn.actor.activation"), "default");
        let anchor = row(&all, "task.rewards.anchor_pos.weight");
        let [(0, value, origin)] = &anchor.later[..] else { panic!("{anchor:?}") };
        assert_eq!((value.to_string().as_str(), all.phases[0]), ("0.0", 0.3));
        assert!(origin.to_string().starts_with("stage2.toml:"));
    }

    #[test]
    fn the_text_groups_values_and_the_json_holds_the_same_rows() {
        let all = explained("stage1", &[]);
        let text = all.to_string();
        assert!(text.starts_with("# stage1.toml, over paper_stage1.toml\n"), "{text}");
        assert_eq!(text.matches("[task.rewards.body_pos]").count(), 1);
        assert!(text.contains("from 60% : 26.0"), "{text}");
        let json = serde_json::to_value(&all).expect("JSON");
        let rows = json["values"].as_array().expect("rows");
        assert_eq!(rows.len(), all.rows.len());
        let envs = rows.iter().find(|row| row["key"] == "run.envs").expect("there");
        assert_eq!((&envs["value"], &envs["origin"]["file"]), (&1920.into(), &"stage1.toml".into()));
    }
}
