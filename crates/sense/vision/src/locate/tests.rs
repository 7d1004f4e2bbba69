//! Places from rendered images.

use paid_lanes::rng::Rng;
use paid_lanes::{Mat3, Quat, Vec3};

use super::find::in_floor;
use super::*;
use crate::detect::Detection;
use crate::render::{DepthSensor, Rendered, render};
use crate::scatter::{Sample, Scatter, Use};
use crate::{DepthImage, Intrinsics, PixelBox, Pose, StampedPose};

/// The box around the pixels that show the ball, as a detector gives it.
fn seen(rendered: &Rendered, intrinsics: &Intrinsics) -> Option<Detection> {
    let pixels = rendered.ball_mask().iter().enumerate().filter(|(_, ball)| **ball);
    let places: Vec<[f64; 2]> =
        pixels.map(|(i, _)| [(i % intrinsics.width) as f64, (i / intrinsics.width) as f64]).collect();
    if places.len() < 40 {
        return None;
    }
    let edge = |k: usize, pick: fn(f64, f64) -> f64| places.iter().map(|p| p[k]).reduce(pick).unwrap_or(0.0);
    let outline =
        PixelBox { min: [0, 1].map(|k| edge(k, f64::min)), max: [0, 1].map(|k| edge(k, f64::max) + 1.0) };
    Some(Detection { outline, score: 0.9, mask: None, whole: false })
}

/// Scenes of walking and kicking robots with a ball near a distance, little of it hidden.
fn scenes(distance: f64, count: usize) -> Vec<(Sample, Rendered)> {
    let scatter = Scatter::new(Use::HeldOut, 31).expect("the robot");
    let mut found = Vec::new();
    for number in 0.. {
        let sample = scatter.sample(number, Intrinsics::g1_color(), true);
        let Some(ball) = sample.ball else { continue };
        if (ball.distance - distance).abs() > 0.3 {
            continue;
        }
        let rendered = render(&sample.scene, &sample.view);
        let size = ball.outline.map_or([0.0; 2], |b| b.size());
        let share = rendered.ball_pixels() as f64 / (0.785 * size[0] * size[1]).max(1.0);
        if share > 0.9 {
            found.push((sample, rendered));
            if found.len() == count {
                break;
            }
        }
    }
    found
}

/// The 95th percentile.
fn most(mut errors: Vec<f64>) -> f64 {
    errors.sort_by(f64::total_cmp);
    errors[(errors.len() * 95).div_ceil(100) - 1]
}

/// Errors of the place in the odometry frame while the torso sways and turns and its poses come at 50 Hz.
fn errors(distance: f64, count: usize, with_depth: bool) -> Vec<f64> {
    let mut rng = Rng::new(5, 0, 0);
    let (mut errors, mut refused) = (Vec::new(), 0);
    for (sample, rendered) in scenes(distance, count) {
        let ball = sample.ball.expect("with a ball");
        let intrinsics = sample.view.intrinsics;
        // Camera as mounted in this scene; walking at up to 0.8 m/s, swaying by up to 1 rad/s.
        let mount = sample.torso.inverse().compose(&sample.view.pose);
        let mut finder = BallFinder::new(intrinsics, mount, ball.radius).expect("a camera");
        let velocity = Vec3([rng.uniform(-0.8, 0.8), rng.uniform(-0.3, 0.3), rng.uniform(-0.1, 0.1)]);
        let rate = Vec3([0; 3].map(|_| rng.uniform(-1.0, 1.0)));
        let captured_s = 100.0 + rng.uniform(0.0, 0.02);
        for k in -5..=5 {
            let time_s = 100.0 + 0.02 * f64::from(k);
            let dt = time_s - captured_s;
            let turn = Quat::<f64>::from_axis_angle(rate.scale(1.0 / rate.norm()), rate.norm() * dt);
            let rot = turn.to_mat().mul_mat(&sample.torso.rot);
            let pose =
                StampedPose { time_s, quat: quat_of(&rot), pos: sample.torso.pos + velocity.scale(dt) };
            assert!(finder.poses().push(pose));
        }
        let Some(detection) = seen(&rendered, &intrinsics) else { continue };
        let depth = with_depth.then(|| rendered.depth(&sample.depth));
        let located = match finder.sight(&detection, depth.as_ref(), captured_s, 0.0) {
            Ok(located) => located,
            // A few balls in a hundred have depths that could be a box's: the image is passed over.
            Err(fault) => {
                assert_eq!((fault, with_depth), (NoSighting::Box, true));
                refused += 1;
                continue;
            }
        };
        assert!(!with_depth || located.source == Source::Depth);
        let error = (0..3).map(|k| (located.position[k] - ball.center[k]).powi(2)).sum::<f64>().sqrt();
        errors.push(error);
    }
    assert!(errors.len() * 10 >= count * 9 && refused * 20 <= count, "{refused} refused");
    errors
}

/// A unit quaternion of a rotation whose real part is not small.
fn quat_of(m: &Mat3<f64>) -> Quat<f64> {
    let m = m.0;
    let w = 0.5 * (1.0 + m[0][0] + m[1][1] + m[2][2]).max(1e-9).sqrt();
    let k = 0.25 / w;
    Quat([w, k * (m[2][1] - m[1][2]), k * (m[0][2] - m[2][0]), k * (m[1][0] - m[0][1])])
}

#[test]
fn a_walking_robot_places_the_ball_within_2_cm_at_1_m_and_5_cm_at_3_m() {
    for (distance, bound) in [(1.0, 0.02), (3.0, 0.05)] {
        let error = most(errors(distance, 60, true));
        assert!(error < bound, "{distance} m: 95% within {error:.4} m");
    }
}

#[test]
fn without_depth_the_floor_or_the_size_places_the_ball() {
    // Some of these balls bounce: they are off the floor, and their size has to do.
    let error = most(errors(1.5, 40, false));
    assert!(error < 0.25, "95% within {error:.3} m");
    let mut typical = errors(1.5, 40, false);
    typical.sort_by(f64::total_cmp);
    assert!(typical[20] < 0.04, "half within {:.3} m", typical[20]);
}

/// A camera that looks ahead, a ball 2 m before it, 0.5 m to the right.
fn plain() -> (Intrinsics, [f64; 3], PixelBox) {
    let intrinsics = Intrinsics { width: 400, height: 300, focal: [300.0; 2], center: [200.0, 150.0] };
    let center = [0.5, 0.1, 2.0];
    (intrinsics, center, intrinsics.sphere_box(center, 0.11).expect("in front"))
}

#[test]
fn a_box_alone_gives_the_distance_of_a_ball_of_known_size() {
    let (intrinsics, center, outline) = plain();
    let detection = Detection { outline, score: 1.0, mask: None, whole: true };
    let fix = locate(&detection, None, &intrinsics, 0.11, None).expect("placed");
    assert_eq!(fix.source, Source::Size);
    for k in 0..3 {
        assert!((fix.position[k] - center[k]).abs() < 2e-3, "{fix:?}");
    }
    // With a floor below: height of the camera is the ball's depth below it plus its radius.
    let floor = Floor { up: [0.0, -1.0, 0.0], height_m: 0.1 + 0.11 };
    let fix = locate(&detection, None, &intrinsics, 0.11, Some(&floor)).expect("placed");
    // The ray falls by 0.1 in 2 m: it grazes, so that size has to do.
    assert_eq!(fix.source, Source::Size);
}

#[test]
fn a_leg_before_the_ball_and_the_floor_behind_it_do_not_move_it() {
    let (intrinsics, center, outline) = plain();
    let detection = Detection { outline, score: 1.0, mask: None, whole: true };
    let range = (0.25_f64 + 0.01 + 4.0).sqrt();
    // The sphere's own depth, a third of the box hidden at 1 m and a sixth of it holes.
    let mut data = vec![5000_u16; 400 * 300];
    for y in 0..300 {
        for x in 0..400 {
            let ray = intrinsics.ray([x as f64 + 0.5, y as f64 + 0.5]);
            let a = ray.iter().map(|v| v * v).sum::<f64>();
            let b = (0..3).map(|k| ray[k] * center[k]).sum::<f64>();
            let inside = b * b - a * (range * range - 0.11 * 0.11);
            if inside > 0.0 {
                data[y * 400 + x] = ((b - inside.sqrt()) / a * 1000.0).round() as u16;
            }
            if (x as f64) < outline.min[0] + outline.size()[0] / 3.0 {
                data[y * 400 + x] = 1000;
            }
            if (y as f64) < outline.min[1] + outline.size()[1] / 6.0 {
                data[y * 400 + x] = 0;
            }
        }
    }
    let depth = DepthImage::new(400, 300, data).expect("whole");
    let fix = locate(&detection, Some(&depth), &intrinsics, 0.11, None).expect("placed");
    assert_eq!(fix.source, Source::Depth);
    for k in 0..3 {
        assert!((fix.position[k] - center[k]).abs() < 4e-3, "{fix:?}");
    }
    // A depth image without a depth, or of another size, is as none.
    for empty in [DepthImage::new(400, 300, vec![0; 120_000]), DepthImage::new(200, 150, vec![2000; 30_000])]
    {
        let fix = locate(&detection, empty.as_ref().ok(), &intrinsics, 0.11, None).expect("placed");
        assert_eq!(fix.source, Source::Size);
    }
}

#[test]
fn a_ball_that_the_edge_cuts_is_placed_by_its_other_sides() {
    let (intrinsics, _, _) = plain();
    let center = [1.3, 0.1, 2.0];
    let outline = intrinsics.sphere_box(center, 0.11).expect("in front");
    assert!(outline.max[0] > 400.0 && outline.middle()[0] < 400.0);
    let detection = Detection { outline: outline.clipped(400, 300), score: 1.0, mask: None, whole: false };
    let fix = locate(&detection, None, &intrinsics, 0.11, None).expect("placed");
    let error = (0..3).map(|k| (fix.position[k] - center[k]).powi(2)).sum::<f64>().sqrt();
    // A sphere this far aside is a fifth wider than high: the rest of the error.
    assert!(error < 0.15, "{fix:?}");
}

#[test]
fn boxes_that_say_nothing_give_no_place() {
    let (intrinsics, _, outline) = plain();
    for (min, max) in [([f64::NAN; 2], outline.max), ([500.0; 2], [600.0; 2]), (outline.max, outline.min)] {
        let detection = Detection { outline: PixelBox { min, max }, score: 1.0, mask: None, whole: false };
        assert_eq!(locate(&detection, None, &intrinsics, 0.11, None), None);
    }
}

#[test]
fn the_place_is_where_the_torso_was_when_the_picture_was_taken() {
    let (intrinsics, center, outline) = plain();
    let mut finder = BallFinder::new(intrinsics, Pose::identity(), 0.11).expect("a camera").with_floor(None);
    let detection = Detection { outline, score: 0.7, mask: None, whole: true };
    assert_eq!(finder.sight(&detection, None, 1.0, 0.0), Err(NoSighting::Pose(crate::PoseGap::Empty)));
    for (time_s, x) in [(1.0, 0.0), (1.2, 0.4)] {
        finder.poses().push(StampedPose { time_s, quat: Quat::identity(), pos: Vec3([x, 0.0, 0.0]) });
    }
    // Captured at 1.1 s, half way; it arrives at 1.2 s.
    let located = finder.sight(&detection, None, 1.1, 0.0).expect("placed");
    assert!((located.position[0] - (center[0] + 0.2)).abs() < 2e-3, "{located:?}");
    let picture = located.measurement(1.2);
    assert!(
        (picture.age_s - 0.1).abs() < 1e-12 && picture.seen && picture.position[0] == located.position[0]
    );
    // By size alone it is less sure than by depth.
    let noise = paid_track::EyesPreset::default().noise();
    assert!(located.variance > noise.deviation::<f64>(0.0, 0.5).powi(2));
    let faster = finder.sight(&detection, None, 1.1, 3.0).expect("placed");
    assert!(faster.variance > located.variance);
    assert!(BallFinder::new(intrinsics, Pose::identity(), 0.0).is_err());
    assert!(DepthSensor::default().deviation(3.0) < 0.04);
}

#[test]
fn a_dome_in_the_floor_is_no_ball() {
    // The camera looks straight down from 1.2 m.
    let intrinsics = Intrinsics::g1_color();
    let camera =
        Pose { rot: Mat3([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]]), pos: Vec3([0.0, 0.0, 1.2]) };
    let finder = BallFinder::new(intrinsics, Pose::identity(), 0.11).expect("a camera");
    let sight = |height: f64| {
        let middle = [0.0, 0.0, 1.2 - height];
        let depth_mm = |i: usize| {
            let ray = intrinsics.ray([(i % 424) as f64 + 0.5, (i / 424) as f64 + 0.5]);
            let (along, length2) = (middle[2], ray[0] * ray[0] + ray[1] * ray[1] + 1.0);
            let root = along * along - length2 * (along * along - 0.11 * 0.11);
            let to_sphere = if root > 0.0 { (along - root.sqrt()) / length2 } else { f64::INFINITY };
            (1000.0 * to_sphere.min(1.2)).round() as u16
        };
        let depth = DepthImage::new(424, 240, (0..424 * 240).map(depth_mm).collect()).expect("whole");
        let outline = intrinsics.sphere_box(middle, 0.11).expect("ahead");
        let detection = Detection { outline, score: 0.9, mask: None, whole: true };
        finder.sight_from(&camera, &detection, Some(&depth), 0.0, 0.0).map(|located| located.position[2])
    };
    // A ball lies 0.11 m high and may bounce; half a sphere that sticks out of the floor is no ball.
    for height in [0.11, 0.5] {
        assert!((sight(height).expect("a ball") - height).abs() < 5e-3);
    }
    assert_eq!(sight(-0.01), Err(NoSighting::InFloor));
    // 0.11 - 0.6 0.11 - 0.0175 distance: 2 cm is the least height from 1.2 m away, 0 from 2.5 m on.
    assert!(in_floor(0.02, 1.2, 0.11) && !in_floor(0.026, 1.2, 0.11) && !in_floor(0.001, 2.52, 0.11));
}
