//! What can be wrong with an MJCF file.

use roxmltree::{Document, Node};
use thiserror::Error;

use super::vocabulary::UNSUPPORTED;
use crate::names::hint;

/// A fault in an MJCF file and its place.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{file}:{line}:{column}: {element}: {problem}")]
pub struct MjcfError {
    /// File name as given to the reader.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// The element, with its name if it has one, as in `<joint 'left_knee_joint'>`.
    pub element: String,
    /// What is wrong.
    pub problem: Box<MjcfProblem>,
}

/// The kinds of fault.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MjcfProblem {
    /// Not well-formed XML.
    #[error("not valid XML: {0}")]
    Syntax(String),
    /// An element that this reader does not know at this place.
    #[error("unknown element here{hint}")]
    UnknownElement {
        /// A suggestion, or nothing.
        hint: String,
    },
    /// An attribute that this reader does not know on this element.
    #[error("unknown attribute '{name}'{hint}")]
    UnknownAttribute {
        /// The attribute.
        name: String,
        /// A suggestion, or nothing.
        hint: String,
    },
    /// A required attribute is absent, also from the default classes.
    #[error("attribute '{0}' is missing")]
    MissingAttribute(&'static str),
    /// A required child element is absent.
    #[error("{0} is missing")]
    MissingElement(&'static str),
    /// An attribute's value cannot be used.
    #[error("attribute '{attribute}': expected {expected}, found '{found}'")]
    BadValue {
        /// The attribute.
        attribute: String,
        /// What would be right.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A name that is taken.
    #[error("the {kind} name '{name}' occurs twice")]
    Duplicate {
        /// Body, joint, geom, class or actuator.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A reference to something that does not exist.
    #[error("attribute '{attribute}': there is no {kind} '{name}'{hint}")]
    UnknownName {
        /// The referring attribute.
        attribute: &'static str,
        /// Body, joint or class.
        kind: &'static str,
        /// The name.
        name: String,
        /// A suggestion, or nothing.
        hint: String,
    },
    /// Valid MJCF that such a robot model cannot hold.
    #[error("{0}")]
    Unsupported(String),
}

/// The parsed file and its name, for error positions.
pub(super) struct Source<'a, 'd> {
    pub file: &'a str,
    pub doc: &'a Document<'d>,
}

impl Source<'_, '_> {
    /// An error at an element.
    pub fn error(&self, node: Node, problem: MjcfProblem) -> MjcfError {
        self.error_at(node, node.range().start, problem)
    }

    /// The error of an element that is not allowed here; `known` are the ones that may.
    pub fn stranger(&self, node: Node, known: &[&str]) -> MjcfError {
        let tag = node.tag_name().name();
        let problem = match UNSUPPORTED.iter().find(|(name, _)| *name == tag) {
            Some((_, why)) => MjcfProblem::Unsupported((*why).to_owned()),
            None => MjcfProblem::UnknownElement { hint: hint(tag, known) },
        };
        self.error(node, problem)
    }

    /// An error at an attribute of an element, or at the element if it has no such attribute.
    pub fn attribute_error(&self, node: Node, attribute: &str, problem: MjcfProblem) -> MjcfError {
        let at = node.attribute_node(attribute).map_or(node.range().start, |a| a.range().start);
        self.error_at(node, at, problem)
    }

    fn error_at(&self, node: Node, byte: usize, problem: MjcfProblem) -> MjcfError {
        let place = self.doc.text_pos_at(byte);
        let tag = node.tag_name().name();
        let class = node.attribute("class").filter(|_| tag == "default");
        let name = node.attribute("name").or(class).or_else(|| node.attribute("joint"));
        let element = name.map_or_else(|| format!("<{tag}>"), |name| format!("<{tag} '{name}'>"));
        MjcfError {
            file: self.file.to_owned(),
            line: place.row,
            column: place.col,
            element,
            problem: Box::new(problem),
        }
    }
}
