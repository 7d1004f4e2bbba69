//! What there is to draw, said once.

use paid_eval::panel::PANEL;
use paid_eval::shooting::Grid;
use paid_eval::subject::Subject;
use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, Shape};
use paid_task::reward_names;
use paid_track::EyesPreset;
use serde::Serialize;

use crate::VERSION;
use crate::board::size;
use crate::game::{GOAL_HALF_WIDTH_M, GOAL_HEIGHT_M};
use crate::watch::Watched;

/// Radius of the lines between joints `[m]`.
const BONE_M: f64 = 0.026;

/// Length of the neck `[m]`.
const NECK_M: f64 = 0.15;

/// What a part looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Look {
    Shell,
    Sole,
    Bone,
    Head,
}

/// A box with round edges: spheres, capsules and boxes.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Part {
    /// Number of the body that it is fixed to.
    body: usize,
    /// Center in the body's frame `[m]`.
    center: [f64; 3],
    /// Orientation in the body's frame, w, x, y, z.
    quat: [f64; 4],
    /// Half extents, the rounding included `[m]`.
    half: [f64; 3],
    /// Radius of the edges `[m]`.
    round: f64,
    look: Look,
}

/// The camera through which the robot sees its ball.
#[derive(Debug, Serialize)]
struct Camera {
    /// Number of the body that carries it: the anchor.
    body: usize,
    /// Place in the body's frame `[m]`.
    mount: [f64; 3],
    /// The rays through the corners of its image, body frame, in order around it.
    corners: [[f64; 3]; 4],
    /// How far it detects a ball `[m]`.
    far_m: f64,
}

#[derive(Debug, Serialize)]
struct Engine {
    name: &'static str,
    surfaces: String,
}

/// The scene.
#[derive(Debug, Serialize)]
pub(crate) struct Scene {
    kind: &'static str,
    version: u8,
    policy: String,
    robot: String,
    /// What the policy is given of ball and goal.
    knowledge: String,
    /// True: the page only watches, and can stop it.
    watched: bool,
    /// True: there is neither reference nor contact force to be shown.
    bare: bool,
    /// What the stop does.
    stop: &'static str,
    /// `None` if it is given the true values.
    camera: Option<Camera>,
    bodies: Vec<String>,
    /// Number of the body that a push is drawn from, and that places are measured from.
    anchor: usize,
    parts: Vec<Part>,
    /// False: the robot follows clips, there is neither ball nor goal.
    ball: bool,
    ball_radius_m: f64,
    goal_half_width_m: f64,
    goal_height_m: f64,
    control_dt_s: f64,
    mass_kg: f64,
    clips: Vec<String>,
    engines: Vec<Engine>,
    /// Balls and grounds that MuJoCo has in addition to the scene's: name, and description.
    surfaces: Vec<[&'static str; 2]>,
    rewards: Vec<&'static str>,
    /// First and last place ahead and to the left, and the distance between places `[m]`.
    grid: Grid,
    /// Rows and columns.
    cells: [usize; 2],
    /// What a set of kicks covers, where one is shown.
    kicks: Option<Kicks>,
}

/// The figures of a set of kicks; the server draws the plots on request.
#[derive(Debug, Serialize)]
pub(crate) struct Kicks {
    /// Names of the plots.
    pub pictures: [&'static str; 4],
    /// How much is covered, as a sentence.
    pub share: String,
    /// Which kick to record next, as a sentence.
    pub advice: String,
}

/// The shortest rotation from the x axis to a direction of length 1.
fn from_x(d: [f64; 3]) -> [f64; 4] {
    if d[0] < -1.0 + 1e-9 {
        return [0.0, 0.0, 0.0, 1.0];
    }
    Quat([1.0 + d[0], 0.0, -d[2], d[1]]).normalize().0
}

fn capsule(body: usize, ends: [[f64; 3]; 2], radius: f64, look: Look) -> Part {
    let (a, b) = (Vec3(ends[0]), Vec3(ends[1]));
    let length = (b - a).norm();
    let quat = if length > 1e-9 { from_x((b - a).scale(1.0 / length).0) } else { [1.0, 0.0, 0.0, 0.0] };
    Part {
        body,
        center: (a + b).scale(0.5).0,
        quat,
        half: [0.5 * length + radius, radius, radius],
        round: radius,
        look,
    }
}

/// The robot's contact shapes and the lines between its joints.
fn parts(model: &RobotModel) -> Vec<Part> {
    let mut parts = Vec::new();
    for (i, body) in model.bodies.iter().enumerate() {
        if let Some(parent) = body.parent {
            parts.push(capsule(parent, [[0.0; 3], body.pos], BONE_M, Look::Bone));
        }
        for geom in body.geoms.iter().filter(|g| g.class != "referee") {
            let look = match (geom.class.as_str(), geom.name.as_str()) {
                ("sole", _) => Look::Sole,
                (_, "head") => Look::Head,
                _ => Look::Shell,
            };
            let part = match geom.shape {
                Shape::Sphere { center, radius } => capsule(i, [center; 2], radius, look),
                Shape::Capsule { ends, radius } => {
                    if look == Look::Head {
                        // A neck, so that the head does not float.
                        let [x, y, z] = ends[0];
                        parts.push(capsule(i, [[x, y, z - NECK_M], ends[0]], BONE_M, Look::Bone));
                    }
                    capsule(i, ends, radius, look)
                }
                Shape::Box { center, half_size, quat } => {
                    let round = 0.25 * half_size.iter().copied().fold(f64::INFINITY, f64::min);
                    Part { body: i, center, quat, half: half_size, round, look }
                }
            };
            parts.push(part);
        }
    }
    parts
}

fn camera(eyes: &EyesPreset, body: usize) -> Camera {
    let geometry = eyes.camera.geometry();
    let corner = |left: f64, up: f64| geometry.ray(left, up).0;
    Camera {
        body,
        mount: geometry.mount::<f64>().0,
        corners: [corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)],
        far_m: eyes.range_m[1],
    }
}

impl Scene {
    /// Of a subject.
    pub fn new(subject: &Subject) -> Self {
        let setup = &subject.setup;
        let builtin = paid_eval::engine::EngineChoice::Builtin.facts(&setup.preset);
        let mujoco = subject.in_mujoco().engine.facts(&setup.preset);
        let engines = [
            Engine { name: "built-in", surfaces: builtin.surfaces },
            Engine { name: "MuJoCo", surfaces: mujoco.surfaces },
        ];
        let shown = Watched {
            policy: subject.name.clone(),
            robot: &setup.robot,
            anchor: setup.robot.body_index(&setup.spec.anchor_body).unwrap_or(0),
            task: &setup.preset,
            clips: setup.library.facts().iter().map(|f| f.name.clone()).collect(),
            engine: "",
            stop: "The evaluation ends",
        };
        let knowledge = builtin.knowledge.as_ref().map_or_else(String::new, ToString::to_string);
        Self { watched: false, bare: false, engines: engines.into(), ..Self::watched(shown, knowledge) }
    }

    /// Of a subject that the page only looks at.
    pub fn looked_on(subject: &Subject) -> Self {
        Self { watched: true, ..Self::new(subject) }
    }

    /// Of clips that are shown without a policy.
    pub fn of_kicks(shown: Watched<'_>, kicks: Kicks) -> Self {
        Self { watched: false, kicks: Some(kicks), ..Self::watched(shown, String::new()) }
    }

    /// Of something that is played elsewhere.
    pub fn watched(shown: Watched<'_>, knowledge: String) -> Self {
        let Watched { policy, robot, anchor, task, clips, engine, stop } = shown;
        Self {
            kind: "scene",
            version: VERSION,
            policy,
            robot: robot.name.clone(),
            knowledge,
            watched: true,
            bare: true,
            stop,
            camera: task.perceives().then(|| camera(&task.eyes, anchor)),
            bodies: robot.body_names(),
            anchor,
            parts: parts(robot),
            ball: task.scene.ball,
            ball_radius_m: task.ball_params.radius_m,
            goal_half_width_m: GOAL_HALF_WIDTH_M,
            goal_height_m: GOAL_HEIGHT_M,
            control_dt_s: task.control_dt_s(),
            mass_kg: robot.mass(),
            clips,
            engines: vec![Engine { name: engine, surfaces: String::new() }],
            surfaces: PANEL.iter().map(|ball| [ball.name, ball.what]).collect(),
            rewards: reward_names().to_vec(),
            grid: Grid::EFFECTIVE,
            cells: size(&Grid::EFFECTIVE),
            kicks: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_capsule_along_z_is_a_long_box_turned_onto_z() {
        let part = capsule(3, [[0.0, 0.0, -0.2], [0.0, 0.0, 0.1]], 0.05, Look::Shell);
        let turned = Quat(part.quat).rotate(Vec3([1.0, 0.0, 0.0])).0;
        assert!((turned[2] - 1.0).abs() < 1e-12, "{turned:?}");
        assert!((part.center[2] + 0.05).abs() < 1e-12 && (part.half[0] - 0.2).abs() < 1e-12);
        assert_eq!((part.half[1], part.round), (0.05, 0.05));
        let back = capsule(0, [[1.0, 0.0, 0.0], [0.0; 3]], 0.1, Look::Bone);
        assert_eq!(Quat(back.quat).rotate(Vec3([1.0, 0.0, 0.0])).0, [-1.0, 0.0, 0.0]);
    }

    #[test]
    fn every_joint_has_its_line_and_the_referees_shapes_are_left_out() {
        let model = RobotModel::g1();
        let parts = parts(&model);
        let bones = parts.iter().filter(|p| p.look == Look::Bone).count();
        let shapes = model.bodies.iter().flat_map(|b| &b.geoms).filter(|g| g.class != "referee").count();
        assert_eq!((bones, parts.len() - bones), (29 + 1, shapes), "a line a joint, and the neck");
        assert_eq!(parts.iter().filter(|p| p.look == Look::Head).count(), 1);
    }
}
