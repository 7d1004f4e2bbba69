//! The robot's shapes in Rerun: one sub-entity per kind of shape under every body, in the body's frame `[m]`.

use paid_lanes::Vec3;
use paid_robot::{Geom, RobotModel, Shape};
use re_sdk::{RecordingStream, RecordingStreamResult};
use re_sdk_types::archetypes::{Boxes3D, Capsules3D, Ellipsoids3D};
use re_sdk_types::components::{Color, FillMode};
use re_sdk_types::datatypes::Quaternion;

/// Radius of the rods that join a body's origin to those of its children `[m]`.
const ROD_M: f64 = 0.028;

/// Numbers as the viewer takes them.
pub fn single(v: [f64; 3]) -> [f32; 3] {
    v.map(|x| x as f32)
}

/// Colors of shell, soles and rods.
pub struct Paint {
    shell: Color,
    sole: Color,
    rod: Color,
}

impl Paint {
    /// The robot itself.
    pub fn robot() -> Self {
        let of = |r, g, b| Color::from_rgb(r, g, b);
        Self { shell: of(205, 208, 214), sole: of(70, 74, 84), rod: of(95, 100, 112) }
    }

    /// The reference: blue glass.
    pub fn ghost() -> Self {
        let glass = Color::from_unmultiplied_rgba(90, 150, 235, 70);
        Self { shell: glass, sole: glass, rod: glass }
    }
}

/// The turn from +z to a direction.
pub fn turn_to([x, y, z]: [f64; 3]) -> Quaternion {
    let length = Vec3([x, y, z]).norm();
    // Half-way between +z and the direction: w = 1 + cos, axis = z x direction.
    let (w, i, j) = (length + z, -y, x);
    let norm = (w * w + i * i + j * j).sqrt();
    if norm < 1e-9 * length.max(1e-9) {
        // Straight down, or no direction at all.
        return Quaternion::from_wxyz([0.0, 1.0, 0.0, 0.0]);
    }
    Quaternion::from_wxyz([(w / norm) as f32, (i / norm) as f32, (j / norm) as f32, 0.0])
}

/// Capsules between pairs of points.
fn capsules(rods: &[([[f64; 3]; 2], f64, Color)]) -> Capsules3D {
    let along = |ends: &[[f64; 3]; 2]| (Vec3(ends[1]) - Vec3(ends[0])).0;
    let lengths = rods.iter().map(|(ends, ..)| Vec3(along(ends)).norm() as f32);
    Capsules3D::from_lengths_and_radii(lengths, rods.iter().map(|(_, r, _)| *r as f32))
        .with_translations(rods.iter().map(|(ends, ..)| single(ends[0])))
        .with_quaternions(rods.iter().map(|(ends, ..)| turn_to(along(ends))))
        .with_colors(rods.iter().map(|(.., c)| *c))
        .with_fill_mode(FillMode::Solid)
}

/// Logs the shapes of all bodies under `root`, once for all times; those that only MuJoCo uses are left out.
pub fn robot(
    rec: &RecordingStream,
    root: &str,
    model: &RobotModel,
    paint: &Paint,
) -> RecordingStreamResult<()> {
    for (i, body) in model.bodies.iter().enumerate() {
        let path = |kind: &str| format!("{root}/{}/{kind}", body.name);
        let color = |geom: &Geom| if geom.class == "sole" { paint.sole } else { paint.shell };
        // Rods first: a body without shapes is seen by them.
        let children = model.bodies.iter().filter(|b| b.parent == Some(i));
        let mut rods: Vec<_> = children.map(|c| ([[0.0; 3], c.pos], ROD_M, paint.rod)).collect();
        let (mut balls, mut boxes) = (Vec::new(), Vec::new());
        for geom in body.geoms.iter().filter(|g| g.class != "referee") {
            match geom.shape {
                Shape::Sphere { center, radius } => balls.push((center, radius, color(geom))),
                Shape::Capsule { ends, radius } => rods.push((ends, radius, color(geom))),
                Shape::Box { center, half_size, quat } => boxes.push((center, half_size, quat, color(geom))),
            }
        }
        if !rods.is_empty() {
            rec.log_static(path("capsules"), &capsules(&rods))?;
        }
        if !balls.is_empty() {
            let shape = Ellipsoids3D::from_centers_and_radii(
                balls.iter().map(|(c, ..)| single(*c)),
                balls.iter().map(|(_, r, _)| *r as f32),
            );
            let colors = balls.iter().map(|(.., c)| *c);
            rec.log_static(path("spheres"), &shape.with_colors(colors).with_fill_mode(FillMode::Solid))?;
        }
        if !boxes.is_empty() {
            let shape = Boxes3D::from_centers_and_half_sizes(
                boxes.iter().map(|(c, ..)| single(*c)),
                boxes.iter().map(|(_, h, ..)| single(*h)),
            );
            let turns = boxes.iter().map(|(_, _, q, _)| Quaternion::from_wxyz(q.map(|x| x as f32)));
            let colors = boxes.iter().map(|(.., c)| *c);
            let shape = shape.with_quaternions(turns).with_colors(colors).with_fill_mode(FillMode::Solid);
            rec.log_static(path("boxes"), &shape)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::Quat;

    #[test]
    fn a_turn_takes_z_to_the_direction() {
        for direction in
            [[0.0, 0.0, 2.0], [1.0, 0.0, 0.0], [-0.3, 0.4, -0.5], [0.0, 1e-3, -1.0], [0.0, 0.0, -3.0]]
        {
            let [x, y, z, w] = turn_to(direction).xyzw().map(f64::from);
            let turned = Quat([w, x, y, z]).rotate(Vec3([0.0, 0.0, 1.0]));
            let wanted = Vec3(direction).scale(1.0 / Vec3(direction).norm());
            assert!((turned - wanted).norm() < 1e-3, "{direction:?}: {turned:?}");
        }
        assert!(turn_to([0.0; 3]).xyzw().iter().all(|x| x.is_finite()));
    }
}
