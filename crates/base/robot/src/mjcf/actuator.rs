//! Effort limits from the actuators.

use roxmltree::Node;

use super::attributes::Compiler;
use super::defaults::Defaults;
use super::error::{MjcfError, MjcfProblem, Source};
use crate::RobotModel;
use crate::names::hint;

const KINDS: &[&str] = &["motor", "position"];

/// Reads all actuators: each joint has exactly one. Its effort limit is the smallest of the joint's `actuatorfrcrange`,
/// the actuator's `forcerange` and, for a motor, its `ctrlrange`, times the gear ratio where the limit is the actuator's.
pub(super) fn read_all<'a, 'd>(
    source: &Source<'a, 'd>,
    compiler: Compiler,
    defaults: &Defaults<'a, 'd>,
    sections: impl Iterator<Item = Node<'a, 'd>>,
    model: &mut RobotModel,
) -> Result<(), MjcfError> {
    let mut actuated = vec![false; model.joints.len()];
    let mut names: Vec<&str> = Vec::new();
    for node in sections.flat_map(|s| s.children()).filter(Node::is_element) {
        let tag = node.tag_name().name();
        if !KINDS.contains(&tag) {
            return Err(source.error(node, MjcfProblem::UnknownElement { hint: hint(tag, KINDS) }));
        }
        let (at, _) = defaults.resolve(source, compiler, node, 0)?;
        if let Some(name) = at.text("name") {
            if names.contains(&name) {
                return Err(at.error(MjcfProblem::Duplicate { kind: "actuator", name: name.to_owned() }));
            }
            names.push(name);
        }
        let joint_name = at.required("joint")?;
        let Some(joint) = model.joint_index(joint_name) else {
            let hint = hint(joint_name, &model.joint_names());
            let name = joint_name.to_owned();
            let problem = MjcfProblem::UnknownName { attribute: "joint", kind: "joint", name, hint };
            return Err(source.attribute_error(node, "joint", problem));
        };
        if std::mem::replace(&mut actuated[joint], true) {
            let text = format!("joint '{joint_name}' has a second actuator");
            return Err(at.error(MjcfProblem::Unsupported(text)));
        }
        let gear = at.list("gear", 1, 6)?.map_or(1.0, |g| g[0]);
        if gear <= 0.0 {
            return Err(at.bad("gear", "a positive ratio"));
        }
        let mut limit = model.joints[joint].effort_limit;
        for (range, switch) in [("forcerange", "forcelimited"), ("ctrlrange", "ctrllimited")] {
            let is_force = range == "forcerange" || tag == "motor";
            match at.limits(range, switch)? {
                Some([lo, hi]) if is_force && lo == -hi => limit = limit.min(hi * gear),
                Some(_) if is_force => return Err(at.bad(range, "limits -x x")),
                _ => {}
            }
        }
        if limit.is_infinite() {
            return Err(at.error(MjcfProblem::MissingAttribute("forcerange")));
        }
        model.joints[joint].effort_limit = limit;
    }
    match actuated.iter().position(|a| !a) {
        None => Ok(()),
        Some(joint) => {
            let text = format!("joint '{}' has no actuator", model.joints[joint].name);
            Err(source.error(source.doc.root_element(), MjcfProblem::Unsupported(text)))
        }
    }
}
