//! The tree of bodies with their joints and geoms.

use roxmltree::Node;

use super::attributes::{Attributes, Compiler, check_known, unit};
use super::defaults::Defaults;
use super::error::{MjcfError, MjcfProblem, Source};
use super::inertia;
use super::shape;
use super::vocabulary::{BODY_ELEMENTS, SKIPPED_BODY_ELEMENTS, attributes_of};
use crate::{Body, Geom, Joint, RobotModel};

/// Bodies nested deeper than this are refused: no robot has them, and reading recurses.
const MAX_DEPTH: usize = 200;

/// Collects bodies and joints depth first.
pub(super) struct Tree<'s, 'a, 'd> {
    source: &'s Source<'a, 'd>,
    compiler: Compiler,
    defaults: &'s Defaults<'a, 'd>,
    bodies: Vec<Body>,
    joints: Vec<Joint>,
}

fn elements<'a, 'd>(node: Node<'a, 'd>) -> impl Iterator<Item = Node<'a, 'd>> {
    node.children().filter(Node::is_element)
}

impl<'s, 'a, 'd> Tree<'s, 'a, 'd> {
    pub fn new(source: &'s Source<'a, 'd>, compiler: Compiler, defaults: &'s Defaults<'a, 'd>) -> Self {
        Self { source, compiler, defaults, bodies: Vec::new(), joints: Vec::new() }
    }

    /// Reads a `<worldbody>`: one body; geoms, lights, cameras and sites of the world are skipped.
    pub fn read_world(&mut self, world: Node<'a, 'd>) -> Result<(), MjcfError> {
        for node in elements(world) {
            let tag = node.tag_name().name();
            if tag == "body" {
                if !self.bodies.is_empty() {
                    return Err(self.unsupported(node, "a second tree: a robot file holds one robot"));
                }
                self.read_body(node, None, 0, 0)?;
            } else if tag != "geom" && !SKIPPED_BODY_ELEMENTS.contains(&tag) {
                return Err(self.source.stranger(node, BODY_ELEMENTS));
            }
        }
        Ok(())
    }

    /// The model without exclusions and effort limits.
    pub fn finish(self, root: Node) -> Result<RobotModel, MjcfError> {
        if self.bodies.is_empty() {
            return Err(self.source.error(root, MjcfProblem::MissingElement("a <worldbody> with a <body>")));
        }
        let (bodies, joints) = (self.bodies, self.joints);
        Ok(RobotModel { name: String::new(), bodies, joints, contact_exclusions: Vec::new() })
    }

    fn unsupported(&self, node: Node, text: &str) -> MjcfError {
        self.source.error(node, MjcfProblem::Unsupported(text.to_owned()))
    }

    fn read_body(
        &mut self,
        node: Node<'a, 'd>,
        parent: Option<usize>,
        childclass: usize,
        depth: usize,
    ) -> Result<(), MjcfError> {
        if depth > MAX_DEPTH {
            return Err(self.unsupported(node, "bodies are nested too deeply"));
        }
        for child in elements(node) {
            let tag = child.tag_name().name();
            if !BODY_ELEMENTS.contains(&tag) && !SKIPPED_BODY_ELEMENTS.contains(&tag) {
                return Err(self.source.stranger(child, BODY_ELEMENTS));
            }
        }
        check_known(self.source, node, attributes_of("body"))?;
        let at = Attributes::own(self.source, self.compiler, node);
        let name = at.required("name")?.to_owned();
        if self.bodies.iter().any(|b| b.name == name) {
            return Err(at.error(MjcfProblem::Duplicate { kind: "body", name }));
        }
        let childclass = self.defaults.class_of(self.source, node, "childclass")?.unwrap_or(childclass);
        let children = |tag: &'static str| elements(node).filter(move |n| n.tag_name().name() == tag);

        let mut inertials = children("inertial");
        let Some(inertial) = inertials.next() else {
            return Err(at.error(MjcfProblem::MissingElement(
                "an <inertial> with mass, pos and diaginertia (masses are not computed from geoms)",
            )));
        };
        if let Some(second) = inertials.next() {
            return Err(self.unsupported(second, "a second <inertial> in one body"));
        }
        check_known(self.source, inertial, attributes_of("inertial"))?;
        let inertial = inertia::read(&Attributes::own(self.source, self.compiler, inertial))?;

        let index = self.bodies.len();
        self.bodies.push(Body {
            name,
            parent,
            pos: at.numbers("pos")?.unwrap_or([0.0; 3]),
            quat: at.orientation()?,
            mass: inertial.mass,
            com: inertial.com,
            inertia: inertial.inertia,
            geoms: Vec::new(),
        });
        match parent {
            None => self.check_free(node, childclass)?,
            Some(_) => self.read_hinge(node, index, childclass)?,
        }
        for geom in children("geom") {
            self.read_geom(geom, index, childclass)?;
        }
        for body in children("body") {
            self.read_body(body, Some(index), childclass, depth + 1)?;
        }
        Ok(())
    }

    /// The root has one free joint and nothing else.
    fn check_free(&self, body: Node<'a, 'd>, childclass: usize) -> Result<(), MjcfError> {
        let joints: Vec<_> =
            elements(body).filter(|n| ["joint", "freejoint"].contains(&n.tag_name().name())).collect();
        let [joint] = joints[..] else {
            return Err(self
                .source
                .error(body, MjcfProblem::MissingElement("a single <freejoint> in the root body")));
        };
        if joint.tag_name().name() == "freejoint" {
            return check_known(self.source, joint, attributes_of("freejoint"));
        }
        let (at, _) = self.defaults.resolve(self.source, self.compiler, joint, childclass)?;
        match at.text("type") {
            Some("free") => Ok(()),
            _ => Err(at.bad("type", "'free' in the root body")),
        }
    }

    fn read_hinge(&mut self, body: Node<'a, 'd>, index: usize, childclass: usize) -> Result<(), MjcfError> {
        let joints: Vec<_> =
            elements(body).filter(|n| ["joint", "freejoint"].contains(&n.tag_name().name())).collect();
        let joint = match joints[..] {
            [joint] if joint.tag_name().name() == "joint" => joint,
            [] => return Err(self.source.error(body, MjcfProblem::MissingElement("a <joint>"))),
            [free] => return Err(self.unsupported(free, "only the root body is free")),
            [_, second, ..] => return Err(self.unsupported(second, "a second joint in one body")),
        };
        let (at, _) = self.defaults.resolve(self.source, self.compiler, joint, childclass)?;
        if !matches!(at.text("type"), None | Some("hinge")) {
            return Err(at.bad("type", "'hinge'"));
        }
        let name = at.required("name")?.to_owned();
        if self.joints.iter().any(|j| j.name == name) {
            return Err(at.error(MjcfProblem::Duplicate { kind: "joint", name }));
        }
        for (attribute, why) in [
            ("pos", "zero: the axis runs through the body's origin"),
            ("ref", "zero: the drawn pose is angle zero"),
            ("stiffness", "zero: joint springs are not simulated"),
        ] {
            if at.list(attribute, 1, 3)?.is_some_and(|v| v.iter().any(|x| *x != 0.0)) {
                return Err(at.bad(attribute, why));
            }
        }
        let axis = at.numbers("axis")?.unwrap_or([0.0, 0.0, 1.0]);
        let axis = unit(axis).ok_or_else(|| at.bad("axis", "a direction that is not zero"))?;
        let Some(range) = at.limits("range", "limited")? else {
            return Err(
                at.error(MjcfProblem::Unsupported("a hinge needs a 'range' that limits it".to_owned()))
            );
        };
        // Infinite until the actuators are read: the smallest of all limits holds.
        let effort_limit = match at.limits("actuatorfrcrange", "actuatorfrclimited")? {
            Some([lo, hi]) if lo == -hi => hi,
            Some(_) => return Err(at.bad("actuatorfrcrange", "limits -x x")),
            None => f64::INFINITY,
        };
        self.joints.push(Joint {
            name,
            body: index,
            axis,
            range: range.map(|x| x * self.compiler.angle_unit),
            armature: at.non_negative("armature")?,
            friction_loss: at.non_negative("frictionloss")?,
            damping: at.non_negative("damping")?,
            effort_limit,
        });
        Ok(())
    }

    fn read_geom(&mut self, node: Node<'a, 'd>, body: usize, childclass: usize) -> Result<(), MjcfError> {
        let (at, class) = self.defaults.resolve(self.source, self.compiler, node, childclass)?;
        if at.text("type") == Some("mesh") {
            return check_mesh(&at);
        }
        if at.text("mesh").is_some() {
            return Err(at.error(MjcfProblem::Unsupported(
                "a shape fitted to a mesh: give its size, and remove 'mesh'".to_owned(),
            )));
        }
        let count = self.bodies[body].geoms.len();
        let name =
            at.text("name").map_or_else(|| format!("{}_geom{count}", self.bodies[body].name), str::to_owned);
        if self.bodies.iter().flat_map(|b| &b.geoms).any(|g| g.name == name) {
            return Err(at.error(MjcfProblem::Duplicate { kind: "geom", name }));
        }
        let geom = Geom { name, class: self.defaults.name(class).to_owned(), shape: shape::read(&at)? };
        self.bodies[body].geoms.push(geom);
        Ok(())
    }
}

/// A mesh that touches nothing is skipped: masses are in `<inertial>`.
fn check_mesh(at: &Attributes) -> Result<(), MjcfError> {
    if ["contype", "conaffinity"].iter().all(|bits| at.text(bits) == Some("0")) {
        return Ok(());
    }
    Err(at.error(MjcfProblem::Unsupported(
        "a mesh that touches other shapes: replace it by spheres, capsules or boxes, or give it contype=\"0\" conaffinity=\"0\""
            .to_owned(),
    )))
}
