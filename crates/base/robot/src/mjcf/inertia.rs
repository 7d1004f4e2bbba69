//! Mass, center of mass and inertia of a body.

use paid_lanes::Quat;

use super::attributes::Attributes;
use super::error::{MjcfError, MjcfProblem};

/// An `<inertial>`: mass `[kg]`, center of mass in the body frame `[m]`, inertia about it in body axes
/// xx, yy, zz, xy, xz, yz `[kg m^2]`.
pub(super) struct Inertial {
    pub mass: f64,
    pub com: [f64; 3],
    pub inertia: [f64; 6],
}

pub(super) fn read(at: &Attributes) -> Result<Inertial, MjcfError> {
    let [mass] = at.required_numbers("mass")?;
    if mass <= 0.0 {
        return Err(at.bad("mass", "a positive mass [kg]"));
    }
    let com = at.required_numbers("pos")?;
    let inertia = match (at.numbers::<3>("diaginertia")?, at.numbers::<6>("fullinertia")?) {
        (Some(d), None) => {
            if !is_inertia(d) {
                return Err(
                    at.bad("diaginertia", "positive moments, none above the sum of the others [kg m^2]")
                );
            }
            rotate_diagonal(d, at.orientation()?)
        }
        (None, Some(full)) => {
            if ["quat", "euler", "axisangle"].iter().any(|a| at.text(a).is_some()) {
                let text = "an orientation and 'fullinertia' exclude each other".to_owned();
                return Err(at.error(MjcfProblem::Unsupported(text)));
            }
            if !is_positive_definite(full) {
                return Err(at.bad("fullinertia", "a positive definite matrix xx yy zz xy xz yz [kg m^2]"));
            }
            full
        }
        (Some(_), Some(_)) => {
            let text = "'diaginertia' and 'fullinertia' exclude each other".to_owned();
            return Err(at.error(MjcfProblem::Unsupported(text)));
        }
        (None, None) => return Err(at.error(MjcfProblem::MissingAttribute("diaginertia"))),
    };
    Ok(Inertial { mass, com, inertia })
}

/// Principal moments of a real body; the slack admits published figures that are rounded.
fn is_inertia(d: [f64; 3]) -> bool {
    let sum = d[0] + d[1] + d[2];
    d.iter().all(|x| *x > 0.0 && 2.0 * x <= sum * (1.0 + 1e-3))
}

/// Sylvester's criterion.
fn is_positive_definite([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> bool {
    let minor = xx * yy - xy * xy;
    let det = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    xx > 0.0 && minor > 0.0 && det > 0.0
}

/// `R diag(d) R^T` as xx, yy, zz, xy, xz, yz.
fn rotate_diagonal(d: [f64; 3], quat: [f64; 4]) -> [f64; 6] {
    let r = Quat(quat).to_mat().0;
    let entry = |i: usize, j: usize| (0..3).map(|k| r[i][k] * d[k] * r[j][k]).sum();
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]
}
