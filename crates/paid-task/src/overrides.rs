//! `--set a.b=c`: one value of a preset replaced by its dotted key, for any preset struct.

use thiserror::Error;
use toml::Value;

/// An override that cannot be applied.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum OverrideError {
    /// No `=`.
    #[error("'{0}': expected KEY=VALUE, such as rewards.action_rate.weight=-0.05")]
    Syntax(String),
    /// The key is not in the preset.
    #[error("unknown key '{key}'{}", suggestion.as_ref().map_or(String::new(), |s| format!("; did you mean '{s}'?")))]
    UnknownKey {
        /// The dotted key up to the first unknown part.
        key: String,
        /// The nearest existing key.
        suggestion: Option<String>,
    },
    /// The value has another type than the preset's.
    #[error("'{key}': expected {expected}, found {found}")]
    Type {
        /// The dotted key.
        key: String,
        /// Type in the preset.
        expected: &'static str,
        /// What was given.
        found: String,
    },
}

/// Replaces the value at a dotted key: `apply_override(&mut preset, "rewards.action_rate.weight=-0.05")`.
///
/// The key must exist (array elements by index) and the new value must have the old one's type; an integer is taken where
/// a float is expected, and a bare word where a string is.
///
/// # Errors
/// If the text is not `KEY=VALUE`, the key does not exist (with the nearest existing key) or the type differs.
pub fn apply_override(preset: &mut Value, text: &str) -> Result<(), OverrideError> {
    let (key, raw) = text.split_once('=').ok_or_else(|| OverrideError::Syntax(text.to_owned()))?;
    let (key, raw) = (key.trim(), raw.trim());
    if key.is_empty() {
        return Err(OverrideError::Syntax(text.to_owned()));
    }
    let root = preset.clone();
    let mut place = preset;
    let mut path = String::new();
    for part in key.split('.') {
        let unknown =
            || OverrideError::UnknownKey { key: join(&path, part), suggestion: nearest(&root, key) };
        place = match place {
            Value::Table(table) => table.get_mut(part).ok_or_else(unknown)?,
            Value::Array(items) => {
                let index = part.parse::<usize>().map_err(|_| unknown())?;
                items.get_mut(index).ok_or_else(unknown)?
            }
            _ => return Err(unknown()),
        };
        path = join(&path, part);
    }
    let value = parse_value(raw);
    let found = value.to_string();
    match convert(place, value) {
        Some(value) => {
            *place = value;
            Ok(())
        }
        None => Err(OverrideError::Type { key: path, expected: place.type_str(), found }),
    }
}

fn join(path: &str, part: &str) -> String {
    if path.is_empty() { part.to_owned() } else { format!("{path}.{part}") }
}

/// TOML if it parses, else the text itself as a string.
fn parse_value(raw: &str) -> Value {
    toml::from_str::<toml::Table>(&format!("value = {raw}"))
        .ok()
        .and_then(|mut table| if table.len() == 1 { table.remove("value") } else { None })
        .unwrap_or_else(|| Value::String(raw.to_owned()))
}

/// `new` as the type of `old`.
fn convert(old: &Value, new: Value) -> Option<Value> {
    match (old, new) {
        (Value::Float(_), Value::Integer(i)) => Some(Value::Float(i as f64)),
        (Value::Array(old), Value::Array(new)) => {
            let Some(first) = old.first() else { return Some(Value::Array(new)) };
            new.into_iter().map(|v| convert(first, v)).collect::<Option<Vec<_>>>().map(Value::Array)
        }
        (old, new) if old.same_type(&new) => Some(new),
        _ => None,
    }
}

/// The existing dotted key with the smallest edit distance, if it is near enough to be what was meant.
fn nearest(root: &Value, key: &str) -> Option<String> {
    let mut keys = Vec::new();
    collect_keys(root, "", &mut keys);
    let best = keys.into_iter().map(|k| (distance(&k, key), k)).min()?;
    (best.0 <= 2 + key.len() / 3).then_some(best.1)
}

fn collect_keys(value: &Value, path: &str, keys: &mut Vec<String>) {
    if let Value::Table(table) = value {
        for (name, inner) in table {
            let path = join(path, name);
            collect_keys(inner, &path, keys);
            keys.push(path);
        }
    }
}

/// Edit distance (insertions, deletions, replacements).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replace = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn preset() -> Value {
        toml::from_str(
            "[rewards.action_rate]\nweight = -0.1\n[goal]\ncenter = [5.0, 0.0]\nname = \"x\"\non = true",
        )
        .expect("valid TOML")
    }

    #[test]
    fn a_value_is_replaced_and_keeps_its_type() {
        let mut p = preset();
        apply_override(&mut p, "rewards.action_rate.weight=-1").expect("applies");
        assert_eq!(p["rewards"]["action_rate"]["weight"], Value::Float(-1.0));
        apply_override(&mut p, "goal.center=[4, 0.5]").expect("applies");
        assert_eq!(p["goal"]["center"], Value::Array(vec![Value::Float(4.0), Value::Float(0.5)]));
        apply_override(&mut p, "goal.center.0 = 3").expect("applies");
        assert_eq!(p["goal"]["center"][0], Value::Float(3.0));
        apply_override(&mut p, "goal.name=word").expect("applies");
        assert_eq!(p["goal"]["name"], Value::String("word".into()));
    }

    #[test]
    fn a_misspelt_key_gets_a_suggestion() {
        let error = apply_override(&mut preset(), "rewards.action_rat.weight=1").expect_err("unknown");
        assert_eq!(
            error.to_string(),
            "unknown key 'rewards.action_rat'; did you mean 'rewards.action_rate.weight'?"
        );
    }

    #[test]
    fn another_type_is_refused() {
        let error = apply_override(&mut preset(), "goal.on=3").expect_err("wrong type");
        assert_eq!(error.to_string(), "'goal.on': expected boolean, found 3");
        assert!(matches!(apply_override(&mut preset(), "goal.on"), Err(OverrideError::Syntax(_))));
    }
}
