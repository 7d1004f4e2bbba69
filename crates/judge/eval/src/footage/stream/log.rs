//! What is logged to Rerun, and where. World axes with z up, SI units.
//!
//! | entity | what |
//! |---|---|
//! | `/world/ground`, `/world/goal` | lines |
//! | `/world/robot/BODY`, `/world/reference/BODY` | one transform per frame; the shapes lie under it |
//! | `/world/ball`, `/world/trail` | the ball; the way of the ball, or of a motion's kicking foot |
//! | `/world/forces` | contact forces as arrows, 1 m for 1000 N |
//! | `/world/human` | the bones of the human that the robot follows |
//! | `/plots/angle/JOINT/robot`, `.../reference` | joint angles `[rad]` |
//! | `/plots/speed/JOINT`, `/plots/torque/JOINT` | `[rad/s]`, `[N m]` |
//! | `/plots/force/BODY` | contact force on every body that had one `[N]` |
//! | `/plots/mark` | speed of the ball, or of a motion's kicking foot `[m/s]` |
//! | `/rewards/TERM` | weighted reward terms that were ever paid |
//! | `/events` | kick and end |
//!
//! The time lines are `step` (frames) and `time` `[s]`.

use paid_lanes::Vec3;
use paid_plot::{Bodies, FORCE_SCALE_M_PER_N};
use paid_task::reward_names;
use re_sdk::blueprint::components::PanelState;
use re_sdk::blueprint::{
    Blueprint, ContainerLike, Horizontal, SelectionPanel, Spatial3DView, Tabs, TextLogView, TimePanel,
    TimeSeriesView, Vertical,
};
use re_sdk::log::TimeColumn;
use re_sdk::{RecordingStream, RecordingStreamResult};
use re_sdk_types::archetypes::{
    Arrows3D, Ellipsoids3D, LineStrips3D, Scalars, TextLog, Transform3D, ViewCoordinates,
};
use re_sdk_types::components::{Color, FillMode};

use super::shapes::{Paint, robot, single};
use crate::footage::Shows;
use crate::footage::recording::{BodyPoses, Footage, Frame, LEAST_FORCE_N};

/// Every moment's trail is this long at most `[s]`: one line per frame would otherwise grow with the square of the recording.
const TRAIL_S: f64 = 1.5;

type Done = RecordingStreamResult<()>;

/// The views: the scene, and next to it rewards, joints and events.
pub fn arrangement(footage: &Footage) -> Blueprint {
    let series =
        |name: &str, origin: &str| -> ContainerLike { TimeSeriesView::new(name).with_origin(origin).into() };
    let mut tabs = Vec::new();
    if footage.episode {
        tabs.push(series("rewards", "/rewards"));
    }
    tabs.extend([series("joint angles", "/plots/angle"), series("joint speeds", "/plots/speed")]);
    if footage.episode {
        tabs.extend([series("torques", "/plots/torque"), series("contact forces", "/plots/force")]);
    }
    tabs.push(series(if footage.episode { "ball speed" } else { "foot speed" }, "/plots/mark"));
    let side =
        Vertical::new([Tabs::new(tabs).into(), TextLogView::new("events").with_origin("/events").into()]);
    let scene = Spatial3DView::new("scene").with_origin("/world");
    Blueprint::new(
        Horizontal::new([scene.into(), side.with_row_shares([4.0, 1.0]).into()])
            .with_column_shares([3.0, 2.0]),
    )
    .with_auto_views(false)
    .with_selection_panel(SelectionPanel::from_state(PanelState::Collapsed))
    .with_time_panel(TimePanel::new().with_state(PanelState::Collapsed).with_timeline("time"))
}

/// Logs everything.
pub fn footage(rec: &RecordingStream, footage: &Footage, shows: Shows) -> Done {
    let frames = &footage.frames;
    rec.log_static("/world", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    still(rec, footage)?;
    robot(rec, "/world/robot", &footage.model, &Paint::robot())?;
    let poses: Vec<_> = frames.iter().map(|f| (&f.pose.pos[..], &f.pose.rot[..])).collect();
    moving(rec, "/world/robot", footage, &poses)?;
    let ghosts: Vec<&BodyPoses> = frames.iter().filter_map(|f| f.ghost.as_ref()).collect();
    if shows.ghost && ghosts.len() == frames.len() {
        robot(rec, "/world/reference", &footage.model, &Paint::ghost())?;
        let poses: Vec<_> = ghosts.iter().map(|g| (&g.pos[..], &g.rot[..])).collect();
        moving(rec, "/world/reference", footage, &poses)?;
    }
    ball_and_trail(rec, footage)?;
    if shows.forces && footage.episode {
        forces(rec, footage)?;
    }
    human(rec, footage)?;
    plots(rec, footage)?;
    for (t, text) in &footage.events {
        rec.set_time_sequence("step", *t as i64);
        rec.set_duration_secs("time", footage.time_s(*t));
        rec.log("/events", &TextLog::new(text.as_str()).with_level("INFO"))?;
    }
    Ok(())
}

/// The time lines of all frames.
fn times(footage: &Footage) -> [TimeColumn; 2] {
    let steps = 0..footage.frames.len();
    [
        TimeColumn::new_sequence("step", steps.clone().map(|t| t as i64)),
        TimeColumn::new_duration_secs("time", steps.map(|t| footage.time_s(t))),
    ]
}

/// Ground and goal.
fn still(rec: &RecordingStream, footage: &Footage) -> Done {
    let goal = goal(footage);
    // No larger than needed: the viewer first looks at everything that is there.
    let [low, high] = extent(footage, goal.iter().flatten());
    let along = |k: usize| low[k]..=high[k];
    let [low, high] = [low, high].map(|p| p.map(|x| x as f32));
    let columns = along(0).map(|x| vec![[x as f32, low[1], 0.0], [x as f32, high[1], 0.0]]);
    let rows = along(1).map(|y| vec![[low[0], y as f32, 0.0], [high[0], y as f32, 0.0]]);
    let lines = columns.chain(rows);
    let ground = LineStrips3D::new(lines).with_colors([Color::from_rgb(90, 120, 90)]).with_radii([0.004]);
    rec.log_static("/world/ground", &ground)?;
    if let Some(goal) = goal {
        let goal = LineStrips3D::new([goal.map(single).to_vec()]);
        rec.log_static(
            "/world/goal",
            &goal.with_colors([Color::from_rgb(250, 250, 250)]).with_radii([0.04]),
        )?;
    }
    Ok(())
}

/// Least and largest x and y of the robot's way and of other points, a meter more on every side `[m]`.
fn extent<'a>(footage: &'a Footage, others: impl Iterator<Item = &'a [f64; 3]>) -> [[i32; 2]; 2] {
    let mut bounds = [[i32::MAX; 2], [i32::MIN; 2]];
    let bases = footage.frames.iter().filter_map(|f| f.pose.pos.first());
    for point in bases.chain(others) {
        for k in 0..2 {
            bounds[0][k] = bounds[0][k].min(point[k].floor() as i32 - 1);
            bounds[1][k] = bounds[1][k].max(point[k].ceil() as i32 + 1);
        }
    }
    bounds
}

/// The goal's frame as a line from foot to foot of its posts, 1 m high `[m]`; `None` without ball and goal.
fn goal(footage: &Footage) -> Option<[[f64; 3]; 4]> {
    let pose = &footage.frames.first().filter(|_| footage.ball_radius_m.is_some())?.pose;
    let (s, c) = pose.heading.sin_cos();
    let post = |left: f64, up: f64| [pose.goal[0] - s * left, pose.goal[1] + c * left, up];
    let w = footage.goal_half_width_m;
    Some([post(-w, 0.0), post(-w, 1.0), post(w, 1.0), post(w, 0.0)])
}

/// One transform per body and frame: origins `[m]` and row-major frames.
fn moving(rec: &RecordingStream, root: &str, footage: &Footage, poses: &[Bodies]) -> Done {
    for (i, body) in footage.model.bodies.iter().enumerate() {
        let columns = |m: [[f64; 3]; 3]| [0, 1, 2].map(|c| [0, 1, 2].map(|r| m[r][c] as f32));
        let transforms = Transform3D::update_fields()
            .with_many_translation(poses.iter().map(|(pos, _)| single(pos[i])))
            .with_many_mat3x3(poses.iter().map(|(_, rot)| columns(rot[i])));
        rec.send_columns(
            format!("{root}/{}", body.name),
            times(footage),
            transforms.columns_of_unit_batches()?,
        )?;
    }
    Ok(())
}

fn ball_and_trail(rec: &RecordingStream, footage: &Footage) -> Done {
    if let Some(radius) = footage.ball_radius_m {
        let shape = Ellipsoids3D::from_radii([radius as f32]).with_colors([Color::from_rgb(245, 150, 40)]);
        rec.log_static("/world/ball", &shape.with_fill_mode(FillMode::Solid))?;
        let places = footage.frames.iter().map(|f| single(f.pose.ball));
        let places = Transform3D::update_fields().with_many_translation(places);
        rec.send_columns("/world/ball", times(footage), places.columns_of_unit_batches()?)?;
    } else if footage.episode {
        return Ok(());
    }
    let style = LineStrips3D::update_fields().with_colors([Color::from_rgb(235, 170, 80)]);
    rec.log_static("/world/trail", &style.with_radii([0.012]))?;
    let trails = (0..footage.frames.len()).map(|t| {
        let mut points: Vec<[f32; 3]> = footage.trail(t, TRAIL_S).into_iter().map(single).collect();
        points.push(single(footage.frames[t].mark));
        points
    });
    rec.send_columns("/world/trail", times(footage), LineStrips3D::new(trails).columns_of_unit_batches()?)
}

fn forces(rec: &RecordingStream, footage: &Footage) -> Done {
    let style = Arrows3D::update_fields().with_colors([Color::from_rgb(215, 40, 60)]).with_radii([0.012]);
    rec.log_static("/world/forces", &style)?;
    let arrows: Vec<_> = footage.frames.iter().map(Frame::arrows).collect();
    let vectors = arrows.iter().flatten().map(|(_, f)| single(f.map(|x| x * FORCE_SCALE_M_PER_N)));
    let arrows3d =
        Arrows3D::from_vectors(vectors).with_origins(arrows.iter().flatten().map(|(at, _)| single(*at)));
    let counts: Vec<usize> = arrows.iter().map(Vec::len).collect();
    rec.send_columns("/world/forces", times(footage), arrows3d.columns(counts)?)
}

fn human(rec: &RecordingStream, footage: &Footage) -> Done {
    if footage.human.is_none() {
        return Ok(());
    }
    let style = LineStrips3D::update_fields().with_colors([Color::from_rgb(70, 120, 190)]);
    rec.log_static("/world/human", &style.with_radii([0.02]))?;
    let bones: Vec<_> = (0..footage.frames.len()).map(|t| footage.human(t)).collect();
    let strips = bones.iter().flatten().map(|(ends, _)| ends.map(single).to_vec());
    let counts: Vec<usize> = bones.iter().map(Vec::len).collect();
    rec.send_columns("/world/human", times(footage), LineStrips3D::new(strips).columns(counts)?)
}

/// A number of a frame, or nothing where it was not measured.
type Number = fn(&Frame, usize) -> Option<f64>;

fn plots(rec: &RecordingStream, footage: &Footage) -> Done {
    let series = |path: String, number: Number, index: usize, least: f64| -> Done {
        let values: Option<Vec<f64>> = footage.frames.iter().map(|f| number(f, index)).collect();
        // What was never measured, or never rose above nothing, is left out.
        match values.filter(|all| all.iter().any(|x| x.abs() > least)) {
            Some(values) => {
                rec.send_columns(path, times(footage), Scalars::new(values).columns_of_unit_batches()?)
            }
            None => Ok(()),
        }
    };
    for (j, joint) in footage.model.joints.iter().enumerate() {
        let name = &joint.name;
        series(format!("/plots/angle/{name}/robot"), |f, j| f.joint_pos.get(j).copied(), j, -1.0)?;
        series(format!("/plots/angle/{name}/reference"), |f, j| f.reference_pos.get(j).copied(), j, -1.0)?;
        series(format!("/plots/speed/{name}"), |f, j| f.joint_vel.get(j).copied(), j, -1.0)?;
        series(format!("/plots/torque/{name}"), |f, j| f.joint_torque.get(j).copied(), j, -1.0)?;
    }
    for (b, body) in footage.model.bodies.iter().enumerate() {
        let path = format!("/plots/force/{}", body.name);
        series(path, |f, b| f.contact_force.get(b).map(|&force| Vec3(force).norm()), b, LEAST_FORCE_N)?;
    }
    if footage.ball_radius_m.is_some() || !footage.episode {
        series("/plots/mark".to_owned(), |f, _| Some(f.mark_speed), 0, -1.0)?;
    }
    for (k, term) in reward_names().iter().enumerate() {
        series(format!("/rewards/{term}"), |f, k| f.rewards.get(k).copied(), k, 0.0)?;
    }
    Ok(())
}
