//! `--set KEY=VALUE`: one value of a preset, replaced by its dotted key.

use std::path::Path;

use paid_robot::names::nearest;
use toml::{Table, Value};

use super::{LayerError, Node, Origin, Tree, did_you_mean, join};

impl Tree {
    /// Replaces the value at a dotted key: `set("task.rewards.action_rate.weight=-0.05", "")`. The key is below `prefix`.
    ///
    /// The key must exist (elements of arrays go by index) and the new value must have the old one's type; an integer is taken where
    /// a float is expected, and a bare word where a string is. Returns the full key.
    ///
    /// # Errors
    /// If the text is not `KEY=VALUE`, the key does not exist (with the nearest key that does) or the type differs.
    pub fn set(&mut self, text: &str, prefix: &str) -> Result<String, LayerError> {
        let fail = |message: String| LayerError { place: format!("--set {text}"), message };
        let syntax = || fail("expected KEY=VALUE, such as rewards.action_rate.weight=-0.05".to_owned());
        let (key, raw) = text.split_once('=').ok_or_else(syntax)?;
        let (key, raw) = (key.trim(), raw.trim());
        if key.is_empty() {
            return Err(syntax());
        }
        let full = if prefix.is_empty() { key.to_owned() } else { join(prefix, key) };
        let value = parse_value(raw);
        let found = value.to_string();
        let origin = Origin::Set(text.to_owned());
        let wrong = |kind: &str| fail(format!("'{key}': expected {kind}, found {found}"));
        match self.0.place(&full) {
            None => return Err(fail(self.unknown(key, prefix))),
            Some((Node::Leaf { value: old, origin: whose }, index)) => {
                let old = match index {
                    None => old,
                    Some(index) => &mut old[index],
                };
                *old = convert(old, value).ok_or_else(|| wrong(old.type_str()))?;
                *whose = origin;
            }
            Some((node, _)) => match (&*node, &value) {
                // What is given lies over a table, and takes the place of an array.
                (Node::Table(_), Value::Table(_)) | (Node::List(_), Value::Array(_)) => {
                    self.lay(Self(Node::of(value, &origin)).under(&full));
                }
                // The name of a surface.
                (Node::Table(_), Value::String(_)) if full.ends_with("ball_params") => {
                    *node = Node::of(value, &origin);
                }
                (Node::Table(_), _) => return Err(wrong("table")),
                _ => return Err(wrong("array")),
            },
        }
        self.expand_surfaces(Path::new(""))?;
        Ok(full)
    }

    /// What is wrong with a key that does not exist.
    fn unknown(&self, key: &str, prefix: &str) -> String {
        let mut keys = Vec::new();
        if let Some(node) = self.0.at(prefix) {
            keys_below(node, "", &mut keys);
        }
        let mut path = String::new();
        for part in key.split('.') {
            path = join(&path, part);
            if !keys.contains(&path) {
                break;
            }
        }
        let best = nearest(key, &keys);
        format!("unknown key '{path}'{}", did_you_mean(best))
    }
}

impl Node {
    /// The node at a key, and the index of an element if the key ends with one of a plain array.
    fn place(&mut self, key: &str) -> Option<(&mut Self, Option<usize>)> {
        if self.at(key).is_some() {
            return self.at_mut(key).map(|node| (node, None));
        }
        let (array, index) = key.rsplit_once('.')?;
        let index = index.parse::<usize>().ok()?;
        match self.at_mut(array)? {
            Self::Leaf { value: Value::Array(items), .. } if index >= items.len() => None,
            node @ Self::Leaf { value: Value::Array(_), .. } => Some((node, Some(index))),
            _ => None,
        }
    }
}

fn keys_below(node: &Node, path: &str, keys: &mut Vec<String>) {
    if let Node::Table(table) = node {
        for (name, inner) in table {
            let path = join(path, name);
            keys_below(inner, &path, keys);
            keys.push(path);
        }
    }
}

/// TOML if it parses, else the text itself as a string.
fn parse_value(raw: &str) -> Value {
    toml::from_str::<Table>(&format!("value = {raw}"))
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
            new.into_iter().map(|value| convert(first, value)).collect::<Option<Vec<_>>>().map(Value::Array)
        }
        (old, new) if old.same_type(&new) => Some(new),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn preset() -> Tree {
        let text =
            "[rewards.action_rate]\nweight = -0.1\n[goal]\ncenter = [5.0, 0.0]\nname = \"x\"\non = true";
        Tree::parse("x.toml", text).expect("valid TOML")
    }

    #[test]
    fn a_value_is_replaced_and_keeps_its_type() {
        let mut p = preset();
        for (text, key, expected) in [
            ("rewards.action_rate.weight=-1", "rewards.action_rate.weight", "-1.0"),
            ("goal.center=[4, 0.5]", "goal.center", "[4.0, 0.5]"),
            ("goal.center.0 = 3", "goal.center", "[3.0, 0.5]"),
            ("goal.name=word", "goal.name", "\"word\""),
        ] {
            p.set(text, "").expect("applies");
            assert_eq!(p.value(key).expect("there").to_string(), expected);
            assert_eq!(p.origin(key), Origin::Set(text.to_owned()));
        }
        p.set("action_rate={weight=2.0}", "rewards").expect("applies below a prefix");
        assert_eq!(p.value("rewards.action_rate.weight"), Some(Value::Float(2.0)));
    }

    #[test]
    fn a_misspelled_key_gets_a_suggestion() {
        let error = preset().set("rewards.action_rat.weight=1", "").expect_err("unknown");
        assert_eq!(error.place, "--set rewards.action_rat.weight=1");
        assert_eq!(
            error.message,
            "unknown key 'rewards.action_rat'; did you mean 'rewards.action_rate.weight'?"
        );
    }

    #[test]
    fn another_type_is_refused() {
        let error = preset().set("goal.on=3", "").expect_err("wrong type");
        assert_eq!(error.message, "'goal.on': expected boolean, found 3");
        let error = preset().set("goal=3", "").expect_err("a table").message;
        assert_eq!(error, "'goal': expected table, found 3");
        let error = preset().set("goal.on", "").expect_err("no value").message;
        assert!(error.starts_with("expected KEY=VALUE"), "{error}");
    }
}
