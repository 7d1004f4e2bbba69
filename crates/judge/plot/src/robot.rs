//! The robot, the ball and the goal of an episode, as frames and as a film strip.

use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, Shape};

use crate::{Camera, Canvas, Rgb, Scene};

/// Everything that an image of a moment shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Control steps since the start.
    pub step: u32,
    /// Body origins, model order, world `[m]`.
    pub pos: Vec<[f64; 3]>,
    /// Body frames in the world, row-major, model order.
    pub rot: Vec<[[f64; 3]; 3]>,
    /// Ball center `[m]`.
    pub ball: [f64; 3],
    /// Goal center `[m]`.
    pub goal: [f64; 3],
    /// Heading of the shooting direction `[rad]`.
    pub heading: f64,
    /// True after the first contact with the ball.
    pub kicked: bool,
}

/// An episode.
#[derive(Clone, Debug, Default)]
pub struct Film {
    /// Every control step, the start first.
    pub poses: Vec<Pose>,
}

const SHELL: Rgb = [205, 208, 214];
const BONE: Rgb = [95, 100, 112];
const SOLE: Rgb = [70, 74, 84];
const BALL: Rgb = [245, 150, 40];
const TRAIL: Rgb = [235, 190, 120];
const POST: Rgb = [250, 250, 250];
const GHOST: Rgb = [90, 150, 235];
const FORCE: Rgb = [215, 40, 60];
/// Height of letters [pixels].
const TEXT: i64 = 16;
/// How much of the ghost is seen.
const GHOST_SHARE: f64 = 0.42;
/// A ghost nearer to the robot than this is not drawn over it `[m]`.
const GHOST_MARGIN_M: f64 = 0.03;
/// Length of a force's arrow `[m/N]`: the robot's weight is a third of a meter.
pub const FORCE_SCALE_M_PER_N: f64 = 1e-3;

/// A robot's pose: body origins, world `[m]`, and body frames in the world, row-major; both in model order.
pub type Bodies<'a> = (&'a [[f64; 3]], &'a [[[f64; 3]; 3]]);

/// What an image shows in addition to robot, ball and goal. Nothing by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shown<'a> {
    /// Where the ball was `[m]`.
    pub trail: &'a [[f64; 3]],
    /// A second robot, seen as if made of blue glass: the reference.
    pub ghost: Option<Bodies<'a>>,
    /// Forces: where they act `[m]`, and the force `[N]`; world axes. Drawn as arrows of [`FORCE_SCALE_M_PER_N`].
    pub forces: &'a [([f64; 3], [f64; 3])],
}

/// An image of `width` x `height` pixels from the robot's side toward the goal. `ball_radius` in m; `None` without a ball;
/// `half_width` is the goal's.
pub fn frame(
    model: &RobotModel,
    pose: &Pose,
    ball_radius: Option<f64>,
    half_width: f64,
    size: [usize; 2],
) -> Canvas {
    episode_frame(model, pose, &Shown::default(), ball_radius, half_width, size)
}

/// As [`frame`], for pose `index` of a film, with the ball's way up to then.
///
/// # Panics
/// If the film has no such pose.
pub fn film_frame(
    model: &RobotModel,
    film: &Film,
    index: usize,
    ball_radius: Option<f64>,
    half_width: f64,
    size: [usize; 2],
) -> Canvas {
    let trail: Vec<[f64; 3]> =
        film.poses[..index].iter().filter(|_| ball_radius.is_some()).map(|p| p.ball).collect();
    let shown = Shown { trail: &trail, ..Shown::default() };
    episode_frame(model, &film.poses[index], &shown, ball_radius, half_width, size)
}

/// As [`frame`], with what else is to be `shown`.
pub fn episode_frame(
    model: &RobotModel,
    pose: &Pose,
    shown: &Shown,
    ball_radius: Option<f64>,
    half_width: f64,
    [width, height]: [usize; 2],
) -> Canvas {
    let base = pose.pos.first().copied().unwrap_or_default();
    let (s, c) = pose.heading.sin_cos();
    // Axes of the shot: ahead and to the left.
    let at =
        |ahead: f64, left: f64, up: f64| [base[0] + c * ahead - s * left, base[1] + s * ahead + c * left, up];
    let camera = Camera { eye: at(-2.3, -2.3, 1.6), target: at(0.8, 0.2, 0.5), field: 0.72 };
    // Drawn at twice the size and halved: smooth edges.
    let mut scene = Scene::new(2 * width, 2 * height, camera);
    for p in shown.trail {
        scene.sphere(*p, 0.015, TRAIL);
    }
    draw_robot(&mut scene, model, &pose.pos, &pose.rot);
    if let Some(radius) = ball_radius {
        scene.shadow(pose.ball, radius);
        scene.sphere(pose.ball, radius, BALL);
        let post = |left: f64, up: f64| [pose.goal[0] - s * left, pose.goal[1] + c * left, up];
        for side in [-half_width, half_width] {
            scene.capsule([post(side, 0.0), post(side, 1.0)], 0.04, POST);
        }
        scene.capsule([post(-half_width, 1.0), post(half_width, 1.0)], 0.04, POST);
    }
    draw_shown(&mut scene, model, shown);
    scene.finish().halved()
}

/// Draws ghost and forces (not the trail) over what is there.
pub fn draw_shown(scene: &mut Scene, model: &RobotModel, shown: &Shown) {
    for (at, force) in shown.forces {
        scene.arrow(*at, force.map(|f| f * FORCE_SCALE_M_PER_N), 0.02, FORCE);
    }
    if let Some((pos, rot)) = shown.ghost {
        let mut layer = scene.layer();
        draw_body(&mut layer, model, pos, rot, [GHOST; 3]);
        scene.blend(&layer, GHOST_SHARE, GHOST_MARGIN_M);
    }
}

/// Draws the robot's contact shapes, the lines between its joints and its shadow: body origins `pos` `[m]` and frames `rot`, model order.
pub fn draw_robot(scene: &mut Scene, model: &RobotModel, pos: &[[f64; 3]], rot: &[[[f64; 3]; 3]]) {
    for p in pos {
        scene.shadow(*p, 0.07);
    }
    draw_body(scene, model, pos, rot, [SHELL, SOLE, BONE]);
}

/// The shapes in the colors of shell, soles and bones.
fn draw_body(
    scene: &mut Scene,
    model: &RobotModel,
    pos: &[[f64; 3]],
    rot: &[[[f64; 3]; 3]],
    [shell, sole, bone]: [Rgb; 3],
) {
    for (i, body) in model.bodies.iter().enumerate().take(pos.len().min(rot.len())) {
        let axes = paid_lanes::Mat3(rot[i]);
        let world = |p: [f64; 3]| (axes.mul_vec(Vec3(p)) + Vec3(pos[i])).0;
        if let Some(parent) = body.parent {
            scene.capsule([pos[parent], pos[i]], 0.028, bone);
        }
        for geom in body.geoms.iter().filter(|g| g.class != "referee") {
            let color = if geom.class == "sole" { sole } else { shell };
            match geom.shape {
                Shape::Sphere { center, radius } => scene.sphere(world(center), radius, color),
                Shape::Capsule { ends, radius } => scene.capsule(ends.map(world), radius, color),
                Shape::Box { center, half_size, quat } => {
                    // Its longest inner capsule: enough to see where it is.
                    let long = (0..3).fold(0, |a, b| if half_size[b] > half_size[a] { b } else { a });
                    let radius = half_size.iter().copied().fold(f64::INFINITY, f64::min);
                    let mut axis = [0.0; 3];
                    axis[long] = half_size[long] - radius;
                    let offset = Quat(quat).rotate(Vec3(axis));
                    let ends = [(Vec3(center) - offset).0, (Vec3(center) + offset).0];
                    scene.capsule(ends.map(world), radius, color);
                }
            }
        }
    }
}

/// `count` moments of an episode side by side in rows of four, evenly from the first to the last pose, or, if the ball was
/// kicked, from 1.2 s before to 0.8 s after.
pub fn film_strip(
    model: &RobotModel,
    film: &Film,
    control_dt_s: f64,
    ball_radius: Option<f64>,
    half_width: f64,
    count: usize,
) -> Canvas {
    const SIZE: [usize; 2] = [320, 300];
    const COLUMNS: usize = 4;
    let last = film.poses.len().saturating_sub(1);
    let (from, to) = match film.poses.iter().position(|p| p.kicked) {
        Some(kick) => {
            let steps = |s: f64| (s / control_dt_s).round() as usize;
            (kick.saturating_sub(steps(1.2)), (kick + steps(0.8)).min(last))
        }
        None => (0, last),
    };
    let count = count.clamp(1, film.poses.len().max(1));
    let rows = count.div_ceil(COLUMNS);
    let mut strip = Canvas::new(SIZE[0] * COLUMNS.min(count), SIZE[1] * rows, [255; 3]);
    for k in 0..count {
        let t = from + ((to - from) * k).checked_div(count - 1).unwrap_or(0);
        let Some(pose) = film.poses.get(t) else { continue };
        let mut image = film_frame(model, film, t, ball_radius, half_width, SIZE);
        let label = format!("{:.2} s", f64::from(pose.step) * control_dt_s);
        image.text(8, 8, TEXT, [30; 3], &label);
        if pose.kicked {
            image.text(8, 30, TEXT, [180, 60, 20], "kicked");
        }
        strip.paste((SIZE[0] * (k % COLUMNS)) as i64, (SIZE[1] * (k / COLUMNS)) as i64, &image);
    }
    strip
}
