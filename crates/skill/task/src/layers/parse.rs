//! TOML text as a tree whose leaves know their lines.

use std::sync::Arc;

use serde::Serialize;
use toml::Value;
use toml::de::{DeTable, DeValue};

use super::{LayerError, Node, Origin, Tree};

impl Tree {
    /// Parses the text of a preset; `file` is for origins and errors.
    ///
    /// # Errors
    /// File, line and what the parser expected.
    pub fn parse(file: &str, text: &str) -> Result<Self, LayerError> {
        let fail = |error: &toml::de::Error| LayerError {
            place: match error.span() {
                Some(span) => format!("{file}:{}", line_of(text, span.start)),
                None => file.to_owned(),
            },
            message: error.message().to_owned(),
        };
        let table = text.parse::<toml::Table>().map_err(|error| fail(&error))?;
        let spans = DeTable::parse(text).map_err(|error| fail(&error))?;
        let name: Arc<str> = file.into();
        let line = |at: usize| Origin::File { file: Arc::clone(&name), line: line_of(text, at) };
        Ok(Self(Node::located(Value::Table(table), &DeValue::Table(spans.into_inner()), &line, 0)))
    }

    /// A value as a tree that no layer names.
    ///
    /// # Errors
    /// If the value has no TOML form.
    pub fn of<T: Serialize>(value: &T) -> Result<Self, toml::ser::Error> {
        Value::try_from(value).map(|value| Self(Node::of(value, &Origin::Default)))
    }
}

impl Node {
    /// A value of one origin.
    pub(crate) fn of(value: Value, origin: &Origin) -> Self {
        match value {
            Value::Table(table) => {
                Self::Table(table.into_iter().map(|(key, value)| (key, Self::of(value, origin))).collect())
            }
            Value::Array(items) if is_list(&items) => {
                Self::List(items.into_iter().map(|item| Self::of(item, origin)).collect())
            }
            value => Self::Leaf { value, origin: origin.clone() },
        }
    }

    /// A value whose key begins at byte `at`, with the spans of what is in it.
    fn located(value: Value, spans: &DeValue<'_>, line: &dyn Fn(usize) -> Origin, at: usize) -> Self {
        match (value, spans) {
            (Value::Table(table), DeValue::Table(spans)) => Self::Table(
                table
                    .into_iter()
                    .map(|(key, value)| match spans.get_key_value(key.as_str()) {
                        Some((name, inner)) => {
                            let node = Self::located(value, inner.get_ref(), line, name.span().start);
                            (key, node)
                        }
                        None => (key, Self::of(value, &line(at))),
                    })
                    .collect(),
            ),
            (Value::Array(items), DeValue::Array(spans)) if is_list(&items) => Self::List(
                items
                    .into_iter()
                    .zip(spans.iter())
                    .map(|(item, span)| Self::located(item, span.get_ref(), line, span.span().start))
                    .collect(),
            ),
            (value, _) => Self::of(value, &line(at)),
        }
    }
}

/// True for an array of tables; an empty array is a value.
fn is_list(items: &[Value]) -> bool {
    !items.is_empty() && items.iter().all(Value::is_table)
}

fn line_of(text: &str, at: usize) -> usize {
    1 + text.as_bytes()[..at.min(text.len())].iter().filter(|&&byte| byte == b'\n').count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_leaf_knows_its_line_in_every_form_of_toml() {
        let text = "a.b = 1\n[c]\nd = { e = 2,\n  f = [\n 3, 4] }\n[[g]]\nh = 5\n[[g]]\n[g.i]\nj = 6\n";
        let tree = Tree::parse("x.toml", text).expect("valid");
        let found: Vec<String> =
            tree.leaves().iter().map(|(key, value, origin)| format!("{key}={value} {origin}")).collect();
        let expected = [
            "a.b=1 x.toml:1",
            "c.d.e=2 x.toml:3",
            "c.d.f=[3, 4] x.toml:4",
            "g.0.h=5 x.toml:7",
            "g.1.i.j=6 x.toml:10",
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_syntax_error_names_file_and_line() {
        let error = Tree::parse("x.toml", "a = 1\nb =").expect_err("no value").to_string();
        assert!(error.starts_with("x.toml:2: "), "{error}");
    }
}
