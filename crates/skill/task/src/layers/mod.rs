//! TOML presets in layers: files over their bases, phases, `--set`. Every value knows where it comes from.
//!
//! ```
//! use paid_task::layers::Tree;
//!
//! let mut tree = Tree::parse("paper.toml", "[run]\nenvs = 4096\nseed = 1")?;
//! tree.lay(Tree::parse("mine.toml", "[run]\nenvs = 64")?);
//! assert_eq!(tree.origin("run.envs").to_string(), "mine.toml:2");
//! assert_eq!(tree.origin("run.seed").to_string(), "paper.toml:3");
//! # Ok::<(), paid_task::layers::LayerError>(())
//! ```

mod parse;
mod set;
mod surfaces;
mod typed;

use core::fmt;
use std::collections::BTreeMap;
use std::sync::Arc;

use thiserror::Error;
use toml::Value;

pub use typed::KeyError;

/// A preset text or an override that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{place}: {message}")]
pub struct LayerError {
    /// File and line, or the override as it was typed.
    pub place: String,
    /// Key, expected, found.
    pub message: String,
}

/// Where a value comes from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Origin {
    /// A line of a preset file.
    File {
        /// Path of the file, or the name of a built-in one.
        file: Arc<str>,
        /// Line, counted from 1.
        line: usize,
    },
    /// An override, `KEY=VALUE`.
    Set(String),
    /// No layer names it: the default in the code.
    Default,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { file, line } => write!(f, "{file}:{line}"),
            Self::Set(_) => write!(f, "--set"),
            Self::Default => write!(f, "default"),
        }
    }
}

/// Values of a preset, each with its origin. Keys are dotted; elements of arrays of tables go by index.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree(pub(crate) Node);

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Node {
    /// A value that is replaced as a whole.
    Leaf {
        value: Value,
        origin: Origin,
    },
    Table(BTreeMap<String, Node>),
    /// An array of tables.
    List(Vec<Node>),
}

impl Default for Tree {
    fn default() -> Self {
        Self(Node::Table(BTreeMap::new()))
    }
}

impl Tree {
    /// Puts `top` over this tree, key by key. A table that names another `kind` replaces the table below it as a whole, because the
    /// two kinds have different keys; everything else that `top` does not name stays. Elements of an array go by index: `[phases.0]` lies over
    /// the first one.
    pub fn lay(&mut self, top: Self) {
        lay(&mut self.0, top.0);
    }

    /// Takes the values that `top` names out of every element of the array at `key`: what `top` says holds in all phases.
    pub fn hold(&mut self, key: &str, top: &Self) {
        if let Some(Node::List(phases)) = self.0.at_mut(key) {
            phases.iter_mut().for_each(|phase| without(phase, &top.0));
        }
    }

    /// [`Tree::hold`] of one key.
    pub fn hold_key(&mut self, list: &str, key: &str) {
        let held = Node::Leaf { value: Value::Boolean(true), origin: Origin::Default };
        self.hold(list, &Self(held).under(key));
    }

    /// This tree below a key.
    pub(crate) fn under(self, key: &str) -> Self {
        key.rsplit('.').fold(self, |tree, part| Self(Node::Table([(part.to_owned(), tree.0)].into())))
    }

    /// Takes the subtree at a key out.
    pub fn take(&mut self, key: &str) -> Option<Self> {
        let (parent, name) = key.rsplit_once('.').unwrap_or(("", key));
        match self.0.at_mut(parent)? {
            Node::Table(table) => table.remove(name).map(Self),
            _ => None,
        }
    }

    /// A copy of the subtree at a key.
    pub fn subtree(&self, key: &str) -> Option<Self> {
        self.0.at(key).cloned().map(Self)
    }

    /// The origin of the value at a key, or of the first value below it.
    pub fn origin(&self, key: &str) -> Origin {
        self.0.at(key).and_then(Node::first_origin).cloned().unwrap_or(Origin::Default)
    }

    /// The value at a key.
    pub fn value(&self, key: &str) -> Option<Value> {
        self.0.at(key).map(Node::to_value)
    }

    /// True if there is a value or table at the key.
    pub fn contains(&self, key: &str) -> bool {
        self.0.at(key).is_some()
    }

    /// Keys, values and origins of all leaves, in the order of the keys.
    pub fn leaves(&self) -> Vec<(String, &Value, &Origin)> {
        let mut all = Vec::new();
        self.0.collect("", &mut all);
        all
    }
}

impl Node {
    pub(crate) fn at(&self, key: &str) -> Option<&Self> {
        let parts = key.split('.').filter(|part| !part.is_empty());
        parts.into_iter().try_fold(self, |node, part| match node {
            Self::Table(table) => table.get(part),
            Self::List(items) => items.get(part.parse::<usize>().ok()?),
            Self::Leaf { .. } => None,
        })
    }

    pub(crate) fn at_mut(&mut self, key: &str) -> Option<&mut Self> {
        let parts = key.split('.').filter(|part| !part.is_empty());
        parts.into_iter().try_fold(self, |node, part| match node {
            Self::Table(table) => table.get_mut(part),
            Self::List(items) => items.get_mut(part.parse::<usize>().ok()?),
            Self::Leaf { .. } => None,
        })
    }

    fn first_origin(&self) -> Option<&Origin> {
        match self {
            Self::Leaf { origin, .. } => Some(origin),
            Self::Table(table) => table.values().filter_map(Self::first_origin).min(),
            Self::List(items) => items.iter().filter_map(Self::first_origin).min(),
        }
    }

    pub(crate) fn to_value(&self) -> Value {
        match self {
            Self::Leaf { value, .. } => value.clone(),
            Self::Table(table) => {
                Value::Table(table.iter().map(|(key, node)| (key.clone(), node.to_value())).collect())
            }
            Self::List(items) => Value::Array(items.iter().map(Self::to_value).collect()),
        }
    }

    fn collect<'a>(&'a self, path: &str, all: &mut Vec<(String, &'a Value, &'a Origin)>) {
        match self {
            Self::Leaf { value, origin } => all.push((path.to_owned(), value, origin)),
            Self::Table(table) => table.iter().for_each(|(key, node)| node.collect(&join(path, key), all)),
            Self::List(items) => {
                for (k, node) in items.iter().enumerate() {
                    node.collect(&join(path, &k.to_string()), all);
                }
            }
        }
    }

    fn kind(&self) -> Option<&Value> {
        match self {
            Self::Table(table) => match table.get("kind") {
                Some(Self::Leaf { value, .. }) => Some(value),
                _ => None,
            },
            _ => None,
        }
    }
}

fn lay(bottom: &mut Node, top: Node) {
    let same_kind = top.kind().is_none_or(|kind| bottom.kind() == Some(kind));
    match (bottom, top) {
        (Node::Table(below), Node::Table(top)) if same_kind => {
            for (key, node) in top {
                match below.get_mut(&key) {
                    Some(old) => lay(old, node),
                    None => drop(below.insert(key, node)),
                }
            }
        }
        (Node::List(items), Node::Table(top)) if top.keys().all(|key| place_in(items, key).is_some()) => {
            for (key, node) in top {
                if let Some(item) = place_in(items, &key) {
                    lay(&mut items[item], node);
                }
            }
        }
        (bottom, top) => *bottom = top,
    }
}

/// The element that a key names.
fn place_in(items: &[Node], key: &str) -> Option<usize> {
    key.parse().ok().filter(|item| *item < items.len())
}

fn without(node: &mut Node, top: &Node) {
    let (Node::Table(table), Node::Table(top)) = (node, top) else { return };
    for (key, above) in top {
        match (table.get_mut(key), above) {
            (Some(below @ Node::Table(_)), Node::Table(_)) => without(below, above),
            _ => drop(table.remove(key)),
        }
    }
}

/// `; did you mean 'x'?`, or nothing.
pub(crate) fn did_you_mean(best: Option<&str>) -> String {
    best.map_or_else(String::new, |best| format!("; did you mean '{best}'?"))
}

/// Two dotted keys as one.
pub fn join(path: &str, part: &str) -> String {
    if path.is_empty() { part.to_owned() } else { format!("{path}.{part}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(name: &str, text: &str) -> Tree {
        Tree::parse(name, text).expect("valid TOML")
    }

    #[test]
    fn a_table_that_sets_one_key_keeps_the_values_and_origins_of_the_others() {
        let mut bottom =
            tree("bottom", "[rewards]\nbody_pos = { weight = 1.0,\n sigma = 0.3, exclude_feet = true }");
        bottom.lay(tree("top", "[rewards]\n\nbody_pos = { weight = 2.0 }"));
        assert_eq!(bottom.value("rewards.body_pos.weight"), Some(Value::Float(2.0)));
        assert_eq!(bottom.value("rewards.body_pos.exclude_feet"), Some(Value::Boolean(true)));
        let origins =
            ["weight", "sigma"].map(|key| bottom.origin(&format!("rewards.body_pos.{key}")).to_string());
        assert_eq!(origins, ["top:3", "bottom:3"]);
    }

    #[test]
    fn a_table_of_another_kind_replaces_the_one_below() {
        let mut bottom = tree("bottom", "terrain = { kind = 'plane', x = 1 }");
        bottom.lay(tree("top", "terrain = { kind = 'rough', y = 2 }"));
        let keys: Vec<_> = bottom.leaves().into_iter().map(|(key, ..)| key).collect();
        assert_eq!(keys, ["terrain.kind", "terrain.y"]);
    }

    #[test]
    fn a_table_of_indices_lies_over_the_elements_of_an_array() {
        let below = "[[phases]]\nfrom = 0.2\na = { x = 1 }\n[[phases]]\nfrom = 0.5";
        let mut bottom = tree("bottom", below);
        bottom.lay(tree("top", "[phases.0]\nfrom = 0.3\na = { y = 2 }\n[phases.1]\nb = 4"));
        let found = ["phases.0.from", "phases.0.a.x", "phases.0.a.y", "phases.1.from", "phases.1.b"]
            .map(|key| bottom.value(key).map_or_else(String::new, |value| value.to_string()));
        assert_eq!(found, ["0.3", "1", "2", "0.5", "4"]);
        // There is no third element: the table replaces the array, and the type refuses it.
        bottom.lay(tree("top", "[phases.2]\nfrom = 0.9"));
        assert_eq!(bottom.value("phases.0.from"), None);
    }

    #[test]
    fn what_the_top_names_is_taken_out_of_the_phases() {
        let mut bottom = tree("bottom", "[[phases]]\nfrom = 0.5\na = { x = 1, y = 2 }\nb = 3");
        bottom.hold("phases", &tree("top", "a = { x = 9 }\nb = 8"));
        let keys: Vec<_> = bottom.leaves().into_iter().map(|(key, ..)| key).collect();
        assert_eq!(keys, ["phases.0.a.y", "phases.0.from"]);
    }
}
