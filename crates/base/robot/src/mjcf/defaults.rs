//! Default classes: a tree of named attribute sets.

use roxmltree::Node;

use super::attributes::{Attributes, Compiler, check_known};
use super::error::{MjcfError, MjcfProblem, Source};
use super::vocabulary::{DEFAULT_ELEMENTS, SKIPPED_DEFAULTS, attributes_of};
use crate::names::hint;

struct Class<'a, 'd> {
    name: &'a str,
    parent: Option<usize>,
    elements: Vec<Node<'a, 'd>>,
}

/// All default classes; class 0 applies everywhere.
pub(super) struct Defaults<'a, 'd>(Vec<Class<'a, 'd>>);

impl<'a, 'd> Defaults<'a, 'd> {
    /// No defaults.
    pub fn new() -> Self {
        Self(vec![Class { name: "main", parent: None, elements: Vec::new() }])
    }

    /// Reads a top-level `<default>`.
    pub fn read(&mut self, source: &Source<'a, 'd>, node: Node<'a, 'd>) -> Result<(), MjcfError> {
        if let Some(name) = node.attribute("class") {
            self.0[0].name = name;
        }
        self.read_class(source, node, 0)
    }

    fn read_class(
        &mut self,
        source: &Source<'a, 'd>,
        node: Node<'a, 'd>,
        class: usize,
    ) -> Result<(), MjcfError> {
        check_known(source, node, &["class"])?;
        for child in node.children().filter(Node::is_element) {
            let tag = child.tag_name().name();
            if tag == "default" {
                let Some(name) = child.attribute("class") else {
                    return Err(source.error(child, MjcfProblem::MissingAttribute("class")));
                };
                if self.0.iter().any(|c| c.name == name) {
                    let problem = MjcfProblem::Duplicate { kind: "class", name: name.to_owned() };
                    return Err(source.error(child, problem));
                }
                self.0.push(Class { name, parent: Some(class), elements: Vec::new() });
                self.read_class(source, child, self.0.len() - 1)?;
            } else if DEFAULT_ELEMENTS.contains(&tag) {
                check_known(source, child, attributes_of(tag))?;
                // Later settings come first: they override earlier ones of the same class.
                self.0[class].elements.insert(0, child);
            } else if !SKIPPED_DEFAULTS.contains(&tag) {
                return Err(source.stranger(child, DEFAULT_ELEMENTS));
            }
        }
        Ok(())
    }

    /// The class that `attribute` of the element names, if it names one.
    pub fn class_of(
        &self,
        source: &Source,
        node: Node,
        attribute: &'static str,
    ) -> Result<Option<usize>, MjcfError> {
        let Some(name) = node.attribute(attribute) else { return Ok(None) };
        match self.0.iter().position(|c| c.name == name) {
            Some(class) => Ok(Some(class)),
            None => {
                let names: Vec<_> = self.0.iter().map(|c| c.name).collect();
                let name = name.to_owned();
                let hint = hint(&name, &names);
                let problem = MjcfProblem::UnknownName { attribute, kind: "default class", name, hint };
                Err(source.attribute_error(node, attribute, problem))
            }
        }
    }

    /// The name of a class.
    pub fn name(&self, class: usize) -> &'a str {
        self.0[class].name
    }

    /// Checks the element's own attributes and joins them with those of its class, or of `childclass` if it names none.
    pub fn resolve<'s>(
        &self,
        source: &'s Source<'a, 'd>,
        compiler: Compiler,
        node: Node<'a, 'd>,
        childclass: usize,
    ) -> Result<(Attributes<'s, 'a, 'd>, usize), MjcfError> {
        let tag = node.tag_name().name();
        check_known(source, node, attributes_of(tag))?;
        let class = self.class_of(source, node, "class")?.unwrap_or(childclass);
        let mut nodes = vec![node];
        let mut next = Some(class);
        while let Some(c) = next {
            nodes.extend(self.0[c].elements.iter().filter(|e| e.tag_name().name() == tag));
            next = self.0[c].parent;
        }
        Ok((Attributes { source, compiler, nodes }, class))
    }
}
