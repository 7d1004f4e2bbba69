//! Attribute values: own ones first, then those of the default classes.

use roxmltree::Node;

use super::error::{MjcfError, MjcfProblem, Source};
use crate::names::hint;

/// Units and conventions of the file (`<compiler>`).
#[derive(Clone, Copy, Debug)]
pub(super) struct Compiler {
    /// Radians per unit of angle in the file.
    pub angle_unit: f64,
    /// A range alone switches a limit on.
    pub autolimits: bool,
    /// Axes of `euler`, lower case about the rotated axes, upper case about the fixed ones.
    pub euler: [u8; 3],
}

impl Default for Compiler {
    /// MuJoCo's defaults.
    fn default() -> Self {
        Self { angle_unit: std::f64::consts::PI / 180.0, autolimits: true, euler: *b"xyz" }
    }
}

/// Fails if the element has an attribute outside `known`.
pub(super) fn check_known(source: &Source, node: Node, known: &[&str]) -> Result<(), MjcfError> {
    match node.attributes().find(|a| !known.contains(&a.name())) {
        None => Ok(()),
        Some(a) => Err(source.attribute_error(
            node,
            a.name(),
            MjcfProblem::UnknownAttribute { name: a.name().to_owned(), hint: hint(a.name(), known) },
        )),
    }
}

/// An element and the defaults that apply to it, nearest first.
pub(super) struct Attributes<'s, 'a, 'd> {
    pub source: &'s Source<'a, 'd>,
    pub compiler: Compiler,
    /// The element, then the defaults of its class, of that class's parent, and so on.
    pub nodes: Vec<Node<'a, 'd>>,
}

impl<'s, 'a, 'd> Attributes<'s, 'a, 'd> {
    /// An element without defaults.
    pub fn own(source: &'s Source<'a, 'd>, compiler: Compiler, node: Node<'a, 'd>) -> Self {
        Self { source, compiler, nodes: vec![node] }
    }

    /// An error at the element.
    pub fn error(&self, problem: MjcfProblem) -> MjcfError {
        self.source.error(self.nodes[0], problem)
    }

    /// An error at the place where the attribute is set.
    pub fn bad(&self, name: &str, expected: impl Into<String>) -> MjcfError {
        let node = self.nodes.iter().find(|n| n.has_attribute(name)).unwrap_or(&self.nodes[0]);
        let found = node.attribute(name).unwrap_or("nothing").to_owned();
        let problem = MjcfProblem::BadValue { attribute: name.to_owned(), expected: expected.into(), found };
        self.source.attribute_error(*node, name, problem)
    }

    /// The text of an attribute.
    pub fn text(&self, name: &str) -> Option<&'a str> {
        self.nodes.iter().find_map(|n| n.attribute(name))
    }

    /// The text of an attribute that must be there.
    pub fn required(&self, name: &'static str) -> Result<&'a str, MjcfError> {
        self.text(name).ok_or_else(|| self.error(MjcfProblem::MissingAttribute(name)))
    }

    /// Finite numbers, at least `min` and at most `max` of them.
    pub fn list(&self, name: &str, min: usize, max: usize) -> Result<Option<Vec<f64>>, MjcfError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        let values: Option<Vec<f64>> = text
            .split_ascii_whitespace()
            .map(|word| word.parse().ok().filter(|x: &f64| x.is_finite()))
            .collect();
        let count = if min == max { format!("{min}") } else { format!("{min} to {max}") };
        values.filter(|v| (min..=max).contains(&v.len())).map(Some).ok_or_else(|| {
            self.bad(name, format!("{count} finite number{}", if max == 1 { "" } else { "s" }))
        })
    }

    /// Exactly `N` finite numbers.
    pub fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, MjcfError> {
        Ok(self.list(name, N, N)?.map(|v| std::array::from_fn(|i| v[i])))
    }

    /// Exactly `N` finite numbers that must be there.
    pub fn required_numbers<const N: usize>(&self, name: &'static str) -> Result<[f64; N], MjcfError> {
        self.numbers(name)?.ok_or_else(|| self.error(MjcfProblem::MissingAttribute(name)))
    }

    /// A number of at least zero; zero if absent.
    pub fn non_negative(&self, name: &str) -> Result<f64, MjcfError> {
        let [x] = self.numbers(name)?.unwrap_or([0.0]);
        if x < 0.0 { Err(self.bad(name, "a number of at least zero")) } else { Ok(x) }
    }

    /// A lower and an upper limit, lower first, if the limit is in force: `switch` is the attribute that switches it.
    pub fn limits(&self, name: &str, switch: &str) -> Result<Option<[f64; 2]>, MjcfError> {
        let on = match self.text(switch) {
            Some("true") => true,
            Some("false") => false,
            None | Some("auto") => self.compiler.autolimits,
            Some(_) => return Err(self.bad(switch, "'true', 'false' or 'auto'")),
        };
        let Some(limits) = self.numbers::<2>(name)? else { return Ok(None) };
        if limits[0] >= limits[1] {
            return Err(self.bad(name, "a lower and a larger upper limit"));
        }
        Ok(on.then_some(limits))
    }

    /// The orientation w, x, y, z (unit norm) from `quat`, `euler` or `axisangle`; the nearest node that has one decides.
    pub fn orientation(&self) -> Result<[f64; 4], MjcfError> {
        const FORMS: [&str; 3] = ["quat", "euler", "axisangle"];
        let Some(node) = self.nodes.iter().find(|n| FORMS.iter().any(|f| n.has_attribute(*f))) else {
            return Ok([1.0, 0.0, 0.0, 0.0]);
        };
        let at = Attributes::own(self.source, self.compiler, *node);
        let given: Vec<_> = FORMS.iter().filter(|f| node.has_attribute(**f)).collect();
        if given.len() > 1 {
            let both = format!("'{}' and '{}' exclude each other", given[0], given[1]);
            return Err(at.error(MjcfProblem::Unsupported(both)));
        }
        if let Some(q) = at.numbers::<4>("quat")? {
            return unit(q).ok_or_else(|| at.bad("quat", "a quaternion w x y z that is not zero"));
        }
        if let Some([x, y, z, angle]) = at.numbers::<4>("axisangle")? {
            let [_, x, y, z] = unit([0.0, x, y, z])
                .ok_or_else(|| at.bad("axisangle", "an axis that is not zero and an angle"))?;
            return Ok(turn([x, y, z], angle * self.compiler.angle_unit));
        }
        let angles: [f64; 3] = at.required_numbers("euler")?;
        let mut q = [1.0, 0.0, 0.0, 0.0];
        for (letter, angle) in self.compiler.euler.iter().zip(angles) {
            let mut axis = [0.0; 3];
            axis[usize::from(letter.to_ascii_lowercase() - b'x')] = 1.0;
            let step = turn(axis, angle * self.compiler.angle_unit);
            q = if letter.is_ascii_lowercase() { product(q, step) } else { product(step, q) };
        }
        Ok(q)
    }
}

/// Rotation about a unit axis by an angle `[rad]`.
fn turn(axis: [f64; 3], angle: f64) -> [f64; 4] {
    let (s, c) = (0.5 * angle).sin_cos();
    [c, axis[0] * s, axis[1] * s, axis[2] * s]
}

fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    paid_lanes::Quat(a).mul(paid_lanes::Quat(b)).0
}

/// Scales to unit norm; `None` for a vector too short to have a direction.
pub(super) fn unit<const N: usize>(v: [f64; N]) -> Option<[f64; N]> {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    (norm > 1e-10 && norm.is_finite()).then(|| v.map(|x| x / norm))
}
