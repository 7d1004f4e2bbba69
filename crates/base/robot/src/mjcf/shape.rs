//! Primitive geoms.

use paid_lanes::{Quat, Vec3};

use super::attributes::Attributes;
use super::error::{MjcfError, MjcfProblem};
use crate::Shape;

/// The shape of a `<geom>` in the body frame.
pub(super) fn read(at: &Attributes) -> Result<Shape, MjcfError> {
    match at.text("type").unwrap_or("sphere") {
        "sphere" => Ok(Shape::Sphere { center: position(at)?, radius: sizes(at, 1)?[0] }),
        "capsule" => capsule(at),
        "box" => {
            let size = sizes(at, 3)?;
            let half_size = [size[0], size[1], size[2]];
            refuse_fromto(at)?;
            Ok(Shape::Box { center: position(at)?, half_size, quat: at.orientation()? })
        }
        "cylinder" => {
            Err(at.bad("type", "'sphere', 'capsule' or 'box' (a capsule of the same radius is nearest)"))
        }
        _ => Err(at.bad("type", "'sphere', 'capsule' or 'box'")),
    }
}

fn capsule(at: &Attributes) -> Result<Shape, MjcfError> {
    if let Some([a, b, c, d, e, f]) = at.numbers("fromto")? {
        if [a, b, c] == [d, e, f] {
            return Err(at.bad("fromto", "two different points"));
        }
        return Ok(Shape::Capsule { ends: [[a, b, c], [d, e, f]], radius: sizes(at, 1)?[0] });
    }
    let size = sizes(at, 2)?;
    let (center, half) = (Vec3(position(at)?), Quat(at.orientation()?).rotate(Vec3([0.0, 0.0, size[1]])));
    Ok(Shape::Capsule { ends: [(center - half).0, (center + half).0], radius: size[0] })
}

fn position(at: &Attributes) -> Result<[f64; 3], MjcfError> {
    Ok(at.numbers("pos")?.unwrap_or([0.0; 3]))
}

fn refuse_fromto(at: &Attributes) -> Result<(), MjcfError> {
    match at.text("fromto") {
        None => Ok(()),
        Some(_) => Err(at.error(MjcfProblem::Unsupported("'fromto' is read for capsules only".to_owned()))),
    }
}

/// The first `used` sizes `[m]`, positive; MJCF allows up to three.
fn sizes(at: &Attributes, used: usize) -> Result<Vec<f64>, MjcfError> {
    let size = at.list("size", used, 3)?.ok_or_else(|| at.error(MjcfProblem::MissingAttribute("size")))?;
    if size[..used].iter().all(|s| *s > 0.0) { Ok(size) } else { Err(at.bad("size", "positive sizes")) }
}
