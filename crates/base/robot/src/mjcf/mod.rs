//! Reader for the MJCF subset that humanoid descriptions use whose contacts have simple shapes.
//!
//! Read are `compiler` (angle unit, autolimits, euler order), nested `default` classes and `childclass`, one tree of
//! bodies with a free root and one hinge each, `inertial` (principal or full), sphere, capsule and box geoms, `exclude`,
//! and `motor` and `position` actuators. Meshes that touch nothing are skipped. Sections that say nothing about mechanics (`visual`, `sensor`, ...) and
//! attributes of MuJoCo's solver are skipped by name; anything else is an error at its line.
//!
//! Why not a crate: the maintained one, `mjcf-rs` 0.36 (of rapier), silently drops elements and attributes that it does
//! not know, and its errors carry no line; a misspelled `armature` would be zero.

mod actuator;
mod attributes;
mod bodies;
mod defaults;
mod error;
mod inertia;
mod shape;
mod vocabulary;

use roxmltree::{Document, Node};

pub use error::{MjcfError, MjcfProblem};

use self::attributes::{Attributes, Compiler, check_known};
use self::bodies::Tree;
use self::defaults::Defaults;
use self::error::Source;
use self::vocabulary::{SECTIONS, SKIPPED_SECTIONS, attributes_of};
use crate::RobotModel;
use crate::names::hint;

impl RobotModel {
    /// Reads an MJCF text; `file_name` is for error messages only.
    ///
    /// Pairs of a body and its parent count as contact exclusions, as in MuJoCo.
    ///
    /// # Errors
    /// The first fault, with line and element: bad XML, an element or attribute outside the subset, a number that is
    /// not finite or has the wrong sign, a name used twice, a reference to nothing, a missing inertial, limit or actuator.
    pub fn from_mjcf(text: &str, file_name: &str) -> Result<Self, MjcfError> {
        let doc = Document::parse(text).map_err(|e| MjcfError {
            file: file_name.to_owned(),
            line: e.pos().row,
            column: e.pos().col,
            element: "document".to_owned(),
            problem: Box::new(MjcfProblem::Syntax(e.to_string())),
        })?;
        read(&Source { file: file_name, doc: &doc })
    }

    /// The Unitree G1 with 29 joints, embedded in the program.
    ///
    /// # Panics
    /// Never: a test reads the embedded file.
    pub fn g1() -> Self {
        match Self::from_mjcf(G1, "assets/g1.xml") {
            Ok(model) => model,
            Err(e) => panic!("the embedded robot description is broken: {e}"),
        }
    }
}

/// The MJCF of the G1, embedded in the program (for MuJoCo, which reads the text itself).
pub const G1: &str = include_str!("../../assets/g1.xml");

fn read(source: &Source) -> Result<RobotModel, MjcfError> {
    let root = source.doc.root_element();
    if root.tag_name().name() != "mujoco" {
        return Err(
            source.error(root, MjcfProblem::UnknownElement { hint: " (expected <mujoco>)".to_owned() })
        );
    }
    check_known(source, root, &["model"])?;
    let sections: Vec<Node> = root.children().filter(Node::is_element).collect();
    for section in &sections {
        let tag = section.tag_name().name();
        if !SECTIONS.contains(&tag) && !SKIPPED_SECTIONS.contains(&tag) {
            return Err(source.stranger(*section, SECTIONS));
        }
    }
    let named = |name: &'static str| sections.iter().copied().filter(move |s| s.tag_name().name() == name);

    let mut compiler = Compiler::default();
    for section in named("compiler") {
        read_compiler(source, section, &mut compiler)?;
    }
    let mut defaults = Defaults::new();
    for section in named("default") {
        defaults.read(source, section)?;
    }
    let mut tree = Tree::new(source, compiler, &defaults);
    for section in named("worldbody") {
        tree.read_world(section)?;
    }
    let mut model = tree.finish(root)?;
    for section in named("contact") {
        read_exclusions(source, section, &mut model)?;
    }
    let parents = model.bodies.iter().enumerate().filter_map(|(i, b)| b.parent.map(|p| (p, i)));
    model.contact_exclusions.extend(parents);
    model.contact_exclusions.sort_unstable();
    model.contact_exclusions.dedup();
    actuator::read_all(source, compiler, &defaults, named("actuator"), &mut model)?;
    model.name = root.attribute("model").unwrap_or("robot").to_owned();
    Ok(model)
}

fn read_compiler<'a, 'd>(
    source: &Source<'a, 'd>,
    node: Node<'a, 'd>,
    compiler: &mut Compiler,
) -> Result<(), MjcfError> {
    check_known(source, node, attributes_of("compiler"))?;
    let at = Attributes::own(source, *compiler, node);
    match at.text("angle") {
        None => {}
        Some("radian") => compiler.angle_unit = 1.0,
        Some("degree") => compiler.angle_unit = std::f64::consts::PI / 180.0,
        Some(_) => return Err(at.bad("angle", "'radian' or 'degree'")),
    }
    match at.text("autolimits") {
        None => {}
        Some("true") => compiler.autolimits = true,
        Some("false") => compiler.autolimits = false,
        Some(_) => return Err(at.bad("autolimits", "'true' or 'false'")),
    }
    if let Some(order) = at.text("eulerseq") {
        compiler.euler = order
            .as_bytes()
            .try_into()
            .ok()
            .filter(|letters: &[u8; 3]| letters.iter().all(|l| b"xyzXYZ".contains(l)))
            .ok_or_else(|| at.bad("eulerseq", "three letters of x, y, z, X, Y, Z"))?;
    }
    if !matches!(at.text("coordinate"), None | Some("local")) {
        return Err(at.bad("coordinate", "'local'"));
    }
    if !matches!(at.text("inertiafromgeom"), None | Some("auto" | "false")) {
        return Err(at.bad("inertiafromgeom", "'auto' or 'false': inertias are read, not computed"));
    }
    Ok(())
}

fn read_exclusions(source: &Source, section: Node, model: &mut RobotModel) -> Result<(), MjcfError> {
    for node in section.children().filter(Node::is_element) {
        if node.tag_name().name() != "exclude" {
            return Err(source
                .error(node, MjcfProblem::UnknownElement { hint: " (only <exclude> is read)".to_owned() }));
        }
        check_known(source, node, attributes_of("exclude"))?;
        let body = |attribute: &'static str| {
            let Some(name) = node.attribute(attribute) else {
                return Err(source.error(node, MjcfProblem::MissingAttribute(attribute)));
            };
            model.body_index(name).ok_or_else(|| {
                let hint = hint(name, &model.body_names());
                let problem =
                    MjcfProblem::UnknownName { attribute, kind: "body", name: name.to_owned(), hint };
                source.attribute_error(node, attribute, problem)
            })
        };
        let (a, b) = (body("body1")?, body("body2")?);
        if a == b {
            return Err(
                source.error(node, MjcfProblem::Unsupported("a body does not meet itself anyway".to_owned()))
            );
        }
        model.contact_exclusions.push((a.min(b), a.max(b)));
    }
    Ok(())
}
