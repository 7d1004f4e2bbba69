//! Place and ball together.

use paid_track::effective_time;

use super::*;
use crate::PlayerSpec;
use crate::message::{BallReport, quaternion};
use crate::player::about_z;

/// Nothing is struck soon.
const FAR_AHEAD: KickTimes = KickTimes { to_strike_s: f64::INFINITY, to_contact_s: f64::INFINITY };

fn player() -> Player {
    let policy = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
    Player::load(&PlayerSpec { policy, motions: None, sets: Vec::new() }).expect("policy")
}

#[test]
fn a_late_picture_counts_from_where_the_robot_was() {
    let player = player();
    let mut world = WorldBelief::new(&player);
    let mut body = Body::new(player.joints());
    let torso = player.anchor_in_base(&body.joint_pos);
    let ball = Vec3([2.0, 0.5, 0.11]);
    // The robot slides along x at 1 m/s and turns at 1 rad/s. The inertial sensor's heading is 0.3 rad off odometry's.
    let at = |us: u64| Pose { pos: Vec3([us as f64 * 1e-6, 0.0, 0.76]), rot: about_z(us as f64 * 1e-6) };
    let mut pictures = Vec::new();
    for k in 0..300_u64 {
        let now_us = 2000 * k;
        let base = at(now_us);
        body.base_rot = about_z(-0.3).mul_mat(&base.rot);
        world.remember(now_us, &body, &player);
        if k % 5 == 0 {
            let half = 0.5 * now_us as f64 * 1e-6;
            let quaternion = [half.cos(), 0.0, 0.0, half.sin()];
            world.odometry(OdometryPose { stamp_us: now_us, position: base.pos.0, quaternion });
        }
        if k % 15 == 0 {
            let seen = torso.point_in_body(base.point_in_body(ball)).0;
            pictures.push(BallDetection { captured_us: now_us, ball: Some(seen), deviation_m: 0.01 });
        }
        if pictures.first().is_some_and(|p| p.captured_us + 60_000 <= now_us) {
            world.sighting(pictures.remove(0));
        }
        if k % 10 == 0 {
            world.advance(now_us, 0.02, f64::INFINITY);
        }
    }
    let belief = world.belief(f64::INFINITY);
    let [x, y] = belief.ball.position;
    assert!(belief.known && (x - 2.0).hypot(y - 0.5) < 0.01, "{x} {y}");
    // Without the times of capture it would be 6 cm and 0.06 rad off.
}

#[test]
fn a_ball_that_was_put_elsewhere_must_be_looked_at_again() {
    let player = player();
    let mut world = WorldBelief::new(&player);
    let body = Body::new(player.joints());
    let torso = player.anchor_in_base(&body.joint_pos);
    let mut looks = Vec::new();
    for k in 0..90_u64 {
        let now_us = 20_000 * (k + 1);
        let stamp_us = now_us;
        world.odometry(OdometryPose {
            stamp_us,
            position: [0.0, 0.0, 0.76],
            quaternion: [1.0, 0.0, 0.0, 0.0],
        });
        world.remember(now_us, &body, &player);
        // Somebody puts the ball a meter farther; later something else is taken for it once.
        let place = match k {
            0..40 => Vec3([1.0, 0.0, 0.11]),
            70 => Vec3([1.0, 0.9, 0.11]),
            _ => Vec3([2.0, 0.3, 0.11]),
        };
        let ball = torso.point_in_body(place - Vec3([0.0, 0.0, 0.76])).0;
        world.sighting(BallDetection { captured_us: now_us, ball: Some(ball), deviation_m: 0.01 });
        world.advance(now_us, 0.02, f64::INFINITY);
        looks.push(world.looks());
    }
    // The first image makes it known, the next ones agree.
    assert_eq!((looks[0], looks[39]), (0, 39));
    // The tracker accepts the third image of the new place.
    assert_eq!(looks[40..44], [0, 0, 0, 1]);
    assert_eq!((looks[69], looks[70], looks[71]), (27, 0, 1));
    let [x, y] = world.belief(f64::INFINITY).ball.position;
    assert!((x - 2.0).hypot(y - 0.3) < 0.01, "{x} {y}");
}

#[test]
fn what_the_eyes_say_counts_from_the_joints_and_the_time_at_which_it_held() {
    let player = player();
    let mut world = WorldBelief::new(&player);
    let mut body = Body::new(player.joints());
    // The waist turns at 2 rad/s while the pelvis stands at (1, 0, 0.76), its inertial sensor's heading 0.3 rad off odometry's.
    let yaw = player.model.joint_index("waist_yaw_joint").expect("a waist");
    body.base_rot = about_z(-0.3);
    let base = Pose { pos: Vec3([1.0, 0.0, 0.76]), rot: about_z(0.0) };
    let mut torsos = Vec::new();
    for k in 0..60_u64 {
        let now_us = 2000 * (k + 1);
        body.joint_pos[yaw] = 2.0 * now_us as f64 * 1e-6;
        let torso = player.anchor_in_base(&body.joint_pos);
        torsos.push((base.point_in_world(torso.pos), base.rot.mul_mat(&torso.rot)));
        world.remember(now_us, &body, &player);
        // A pose that is 20 ms old when it comes.
        if k >= 10 {
            let (pos, rot) = torsos[k as usize - 10];
            let quaternion = quaternion(&rot);
            world.torso_pose(now_us, &TorsoPose { age_us: 20_000, frame: 0, position: pos.0, quaternion });
        }
    }
    let found = world.base(120_000, &body).expect("a pose");
    assert!((found.pos - base.pos).norm() < 1e-9 && found.rot.yaw().abs() < 1e-9, "{found:?}");
    // A ball that rolls at 1 m/s and lay at x = 2 m 30 ms ago.
    let ball = BallReport {
        position: [2.0, 0.5],
        velocity: [1.0, 0.0],
        covariance: [1e-4, 0.0, 1e-4],
        rest: 0.0,
        age_s: 0.07,
        looks: 33,
        id: 4,
        lost: false,
    };
    let report = EyesReport {
        age_us: 30_000,
        picture_age_us: Some(0),
        frame: 0,
        floor_m: Some(-1.2),
        ball: Some(ball),
    };
    world.report(120_000, &report);
    let (belief, way) = (world.belief(f64::INFINITY), effective_time(0.03, world.ball.decay));
    assert!(belief.known && (belief.ball.position[0] - 2.0 - way).abs() < 1e-12 && way > 0.025);
    assert!((belief.age_s - 0.1).abs() < 1e-12 && world.looks() == 33);
    // The floor is 1.2 m below odometry's origin.
    let scene = world.scene(&base, FAR_AHEAD, f64::INFINITY);
    assert!((scene.ball.z() + 1.2 - world.ball.radius + 0.76).abs() < 1e-9, "{scene:?}");
    world.goal_ahead([5.0, 0.0]);
    assert!(world.goal.is_some() && world.goal_bearing().expect("a goal").abs() < 1e-9);
    // The ball rolls, the pelvis moves on and turns.
    world.begin_kick();
    let mut shown = Vec::new();
    for k in 0..20_u64 {
        let ball = BallReport { position: [2.0 + 0.02 * k as f64, 0.5], ..ball };
        world.report(120_000, &EyesReport { ball: Some(ball), ..report });
        let base = Pose { pos: Vec3([1.0 + 0.01 * k as f64, 0.0, 0.76]), rot: about_z(0.05 * k as f64) };
        let scene = world.scene(&base, FAR_AHEAD, f64::INFINITY);
        shown.push(base.point_in_world(scene.ball));
    }
    assert!(shown[19].x() - shown[0].x() > 0.3, "{shown:?}");
    // Odometry restarts: ball and goal are gone, and a report of the old frame is not taken.
    body.joint_pos[yaw] = 0.0;
    world.remember(122_000, &body, &player);
    let pose = TorsoPose { age_us: 0, frame: 1, position: [0.0; 3], quaternion: [1.0, 0.0, 0.0, 0.0] };
    world.torso_pose(122_000, &pose);
    world.report(122_000, &report);
    assert!(world.goal.is_none() && !world.belief(f64::INFINITY).known && world.looks() == 0);
}
