//! From a tree to a typed preset and back.

use paid_robot::names::nearest;
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;
use toml::Value;

use super::{LayerError, Node, Origin, Tree, did_you_mean, join};

/// A value that a preset cannot have.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}", if key.is_empty() { message.clone() } else { format!("{key}: {message}") })]
pub struct KeyError {
    /// The dotted key; empty if it is not known.
    pub key: String,
    /// Expected and found.
    pub message: String,
}

/// Beginning of the message of a key that the type does not have.
const UNKNOWN: &str = "unknown key";

impl KeyError {
    /// True if the type has no such key.
    pub fn is_unknown_key(&self) -> bool {
        self.message.starts_with(UNKNOWN)
    }
}

impl Tree {
    /// The tree as a typed preset.
    ///
    /// # Errors
    /// Key, expected and found.
    pub fn typed<T: DeserializeOwned>(&self) -> Result<T, KeyError> {
        T::deserialize(self.0.to_value()).map_err(|error| key_error(&error))
    }

    /// Adds what the type has beyond the tree, so that defaults can be seen and overridden, and gives every value its type.
    ///
    /// # Errors
    /// If the value has no TOML form.
    pub fn fill<T: Serialize>(&mut self, typed: &T) -> Result<(), toml::ser::Error> {
        fill(&mut self.0, Value::try_from(typed)?);
        Ok(())
    }

    /// An error of a key, with the place that its value comes from; `file` stands for a value that no layer names.
    pub fn locate(&self, error: KeyError, file: &str) -> LayerError {
        let mut key = error.key.as_str();
        let origin = loop {
            match self.0.at(key).map(|_| self.origin(key)) {
                Some(origin @ (Origin::File { .. } | Origin::Set(_))) if !key.is_empty() => {
                    break Some(origin);
                }
                _ => match key.rsplit_once('.') {
                    Some((parent, _)) => key = parent,
                    None => break None,
                },
            }
        };
        let place = match origin {
            Some(Origin::Set(text)) => format!("--set {text}"),
            Some(origin) => origin.to_string(),
            None => file.to_owned(),
        };
        LayerError { place, message: error.to_string() }
    }
}

/// The values of `typed` with the origins of `node`.
fn fill(node: &mut Node, typed: Value) {
    match (node, typed) {
        (Node::Table(table), Value::Table(typed)) => {
            for (key, value) in typed {
                match table.get_mut(&key) {
                    Some(node) => fill(node, value),
                    None => drop(table.insert(key, Node::of(value, &Origin::Default))),
                }
            }
        }
        (Node::List(items), Value::Array(typed)) if items.len() == typed.len() => {
            items.iter_mut().zip(typed).for_each(|(node, value)| fill(node, value));
        }
        (Node::Leaf { value: old, .. }, value) => *old = value,
        (node, value) => *node = Node::of(value, &Origin::Default),
    }
}

/// What serde says, as key and message. It names unknown and missing fields in its text only.
fn key_error(error: &toml::de::Error) -> KeyError {
    let text = error.to_string();
    let mut key = text
        .lines()
        .find_map(|line| line.strip_prefix("in `")?.strip_suffix('`'))
        .unwrap_or_default()
        .to_owned();
    let message = error.message();
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let message = if let (true, Some((name, expected))) =
        (message.starts_with("unknown field"), quoted.split_first())
    {
        let best = nearest(name, expected).map(|best| join(&key, best));
        let table = key.rsplit('.').next().unwrap_or_default();
        let of_terms = ["rewards", "terminations", "noise"].contains(&table);
        let note = if of_terms {
            " If another crate adds this term, build the program with that crate."
        } else {
            ""
        };
        key = join(&key, name);
        let list = if expected.is_empty() { "none".to_owned() } else { expected.join(", ") };
        let hint = best.map_or_else(|| ".".to_owned(), |best| did_you_mean(Some(&best)));
        format!("{UNKNOWN}{hint}{note} Known here: {list}")
    } else if let (true, Some(name)) = (message.starts_with("missing field"), quoted.first()) {
        key = join(&key, name);
        "expected a value, found none".to_owned()
    } else {
        message.to_owned()
    };
    KeyError { key, message }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Run {
        envs: usize,
        #[serde(default)]
        share: f64,
    }

    #[derive(Debug, Serialize, Deserialize)]
    struct Preset {
        run: Run,
    }

    fn refused(text: &str) -> String {
        let tree = Tree::parse("x.toml", text).expect("valid TOML");
        let error = tree.typed::<Preset>().expect_err("refused");
        tree.locate(error, "x.toml").to_string()
    }

    #[test]
    fn a_wrong_value_is_reported_with_file_line_expected_and_found() {
        let text = refused("\n[run]\nenvs = \"many\"");
        assert_eq!(text, "x.toml:3: run.envs: invalid type: string \"many\", expected usize");
        assert_eq!(refused("[run]\nshare = 0.5"), "x.toml:2: run.envs: expected a value, found none");
    }

    #[test]
    fn an_unknown_key_is_reported_with_its_line_and_the_nearest_key() {
        let text = refused("[run]\nenvs = 1\nshape = 0.5");
        assert_eq!(
            text,
            "x.toml:3: run.shape: unknown key; did you mean 'run.share'? Known here: envs, share"
        );
    }

    #[test]
    fn defaults_are_filled_in_and_integers_become_floats() {
        let mut tree = Tree::parse("x.toml", "[run]\nenvs = 1").expect("valid TOML");
        let preset: Preset = tree.typed().expect("fits");
        tree.fill(&preset).expect("writes");
        assert_eq!(
            (tree.value("run.share"), tree.origin("run.share")),
            (Some(Value::Float(0.0)), Origin::Default)
        );
        assert_eq!(tree.origin("run.envs").to_string(), "x.toml:2");
        tree.set("run.share=1", "").expect("a default can be overridden");
        assert_eq!(tree.typed::<Preset>().expect("fits").run.share, 1.0);
    }
}
