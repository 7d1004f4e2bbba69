//! Footage as images of the software renderer: needs no display and no viewer.

use paid_plot::{Camera, Canvas, Scene, Shown, draw_robot, episode_frame};

use super::recording::{BESIDE, Footage};

const BONE: [u8; 3] = [70, 120, 190];
const TRAIL: [u8; 3] = [235, 150, 60];
/// Height of letters [pixels].
const TEXT: i64 = 14;
/// How long the word `kick` is shown in the image `[s]`.
const KICK_S: f64 = 0.4;

/// What is drawn in addition to the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shows {
    /// The reference.
    pub ghost: bool,
    /// Contact forces.
    pub forces: bool,
}

/// Frame `t` as an image of `size` pixels: an episode over the robot's shoulder to the goal, a motion from its side.
pub fn picture(footage: &Footage, t: usize, size: [usize; 2], shows: Shows) -> Canvas {
    let frame = &footage.frames[t];
    let mut image = if footage.episode { episode(footage, t, size, shows) } else { motion(footage, t, size) };
    image.text(8, 8, TEXT, [30; 3], &format!("{:.2} s", footage.time_s(t)));
    if !footage.episode || footage.ball_radius_m.is_some() {
        let what = if footage.episode { "ball" } else { "foot" };
        image.text(8, 24, TEXT, [120, 70, 20], &format!("{what} {:.1} m/s", frame.mark_speed));
    }
    let kick = footage.frames.iter().position(|f| f.pose.kicked);
    if kick.is_some_and(|kick| t >= kick && (t - kick) as f64 * footage.dt_s <= KICK_S) {
        image.text(8, 40, TEXT, [190, 50, 20], "kick");
    }
    image
}

fn episode(footage: &Footage, t: usize, size: [usize; 2], shows: Shows) -> Canvas {
    let frame = &footage.frames[t];
    let (trail, arrows) = (footage.trail(t, f64::INFINITY), frame.arrows());
    let ghost = frame.ghost.as_ref().filter(|_| shows.ghost);
    let shown = Shown {
        trail: &trail,
        ghost: ghost.map(|g| (&g.pos[..], &g.rot[..])),
        forces: if shows.forces { &arrows } else { &[] },
    };
    let (ball, width) = (footage.ball_radius_m, footage.goal_half_width_m);
    episode_frame(&footage.model, &frame.pose, &shown, ball, width, size)
}

fn motion(footage: &Footage, t: usize, [width, height]: [usize; 2]) -> Canvas {
    let middle = center(footage, t);
    let (aside, far) = if footage.human.is_some() { (0.5 * BESIDE[1], 1.35) } else { (0.0, 1.0) };
    let at = |x: f64, y: f64, z: f64| [middle[0] + x, middle[1] + aside + y, z];
    let camera = Camera { eye: at(2.1 * far, -2.3 * far, 1.4), target: at(0.0, 0.0, 0.68), field: 0.62 };
    // Drawn at twice the size and halved: smooth edges.
    let mut scene = Scene::new(2 * width, 2 * height, camera);
    for p in footage.trail(t, f64::INFINITY) {
        scene.sphere(p, 0.012, TRAIL);
    }
    let bones = footage.human(t);
    for (ends, _) in &bones {
        scene.shadow(ends[1], 0.06);
    }
    for (ends, head) in bones {
        scene.capsule(ends, 0.028, BONE);
        if head {
            scene.sphere(ends[1], 0.1, BONE);
        }
    }
    let pose = &footage.frames[t].pose;
    draw_robot(&mut scene, &footage.model, &pose.pos, &pose.rot);
    scene.finish().halved()
}

/// Where the camera looks: the base's place, averaged over a second.
fn center(footage: &Footage, t: usize) -> [f64; 2] {
    let reach = (0.5 / footage.dt_s) as usize;
    let range = t.saturating_sub(reach)..(t + reach + 1).min(footage.frames.len());
    let count = range.len() as f64;
    range.fold([0.0; 2], |sum, k| {
        let base = footage.frames[k].pose.pos[0];
        [sum[0] + base[0] / count, sum[1] + base[1] / count]
    })
}
