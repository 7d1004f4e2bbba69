//! Where the camera sits on the torso, from a few views of a ball.

use paid_lanes::{Quat, Vec3};

use crate::{Pose, VisionError};

/// A view of a ball that lies still.
#[derive(Clone, Copy, Debug)]
pub struct BallView {
    /// Torso in the odometry frame when the image was taken.
    pub torso: Pose,
    /// The ball's center as [`crate::locate::locate`] gave it, camera frame `[m]`.
    pub in_camera: [f64; 3],
    /// Which place of the ball this is: views of the same place have the same number, counted from 0.
    pub place: usize,
}

/// What a calibration found.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// Torso from the camera's optical frame.
    pub torso_from_camera: Pose,
    /// Places of the balls, odometry frame `[m]`.
    pub balls: Vec<[f64; 3]>,
    /// Root mean square of what is left, across the ray `[rad]`.
    pub residual_rad: f64,
    /// Root mean square of what is left, along the ray `[m]`.
    pub residual_m: f64,
    /// How far the camera was moved `[m]` and turned `[rad]` from the first guess.
    pub change: [f64; 2],
}

/// Deviations by which errors are weighed: a pixel of 424 across the ray `[rad]`, and a median of depths along it, as a share of the
/// distance.
const ACROSS: f64 = 1.0 / 308.0;
const ALONG: f64 = 0.006;

/// Camera on torso from views of balls that lie still while the torso leans and turns: Gauss-Newton over the camera's six degrees of freedom
/// and the balls' places, from `first` (the robot's description).
///
/// # Errors
/// If there are too few views, a number is not finite, or the views do not tell all six: lean and turn the torso by 10 degrees or more
/// between them, to several sides.
pub fn calibrate(views: &[BallView], first: &Pose) -> Result<Calibration, VisionError> {
    let places = views.iter().map(|view| view.place + 1).max().unwrap_or(0);
    let unknown = 6 + 3 * places;
    let finite = |view: &BallView| {
        view.in_camera
            .iter()
            .chain(&view.torso.pos.0)
            .chain(view.torso.rot.0.as_flattened())
            .all(|v| v.is_finite())
            && view.in_camera[2] > 0.05
    };
    if let Some(k) = views.iter().position(|view| !finite(view)) {
        return Err(VisionError::value(
            format!("calibration: view {k}"),
            "a ball before the camera and a torso's pose",
            format!("{:?}", views[k].in_camera),
        ));
    }
    let mut of_place = vec![0_usize; places];
    for view in views {
        of_place[view.place] += 1;
    }
    if 3 * views.len() < unknown + 3 || of_place.iter().any(|n| *n < 2) {
        return Err(VisionError::value(
            "calibration",
            "6 views or more, of every place of the ball 2 or more",
            format!("{} views, {of_place:?} of the places", views.len()),
        ));
    }
    let mut camera = *first;
    let mut balls: Vec<[f64; 3]> = (0..places)
        .map(|place| {
            let seen = views.iter().filter(|view| view.place == place);
            let sum = seen.fold(Vec3::zero(), |sum, view| {
                sum + Vec3(view.torso.compose(&camera).point(view.in_camera))
            });
            sum.scale(1.0 / of_place[place] as f64).0
        })
        .collect();
    let mut error = square(&residuals(views, &camera, &balls));
    for _ in 0..30 {
        let now = residuals(views, &camera, &balls);
        // Numeric derivatives: the parameters are meters and radians of order 1.
        let step = 1e-6;
        let columns: Vec<Vec<f64>> = (0..unknown)
            .map(|k| {
                let mut change = vec![0.0; unknown];
                change[k] = step;
                let (camera, balls) = moved(&camera, &balls, &change);
                let there = residuals(views, &camera, &balls);
                there.iter().zip(&now).map(|(b, a)| (b - a) / step).collect()
            })
            .collect();
        let change = solve(&columns, &now).ok_or_else(|| {
            VisionError::value(
                "calibration",
                "views that differ: lean and turn the torso by 10 degrees or more, to several sides",
                format!("{} views that leave a direction open", views.len()),
            )
        })?;
        let (next_camera, next_balls) = moved(&camera, &balls, &change);
        let next = square(&residuals(views, &next_camera, &next_balls));
        if next.is_nan() || next >= error {
            break;
        }
        let done = error - next < 1e-12 * error;
        (camera, balls, error) = (next_camera, next_balls, next);
        if done {
            break;
        }
    }
    let left = residuals(views, &camera, &balls);
    let (mut across, mut along) = (0.0, 0.0);
    for (view, r) in views.iter().zip(left.chunks_exact(3)) {
        let distance = Vec3(view.in_camera).norm();
        across += 0.5 * (r[0] * r[0] + r[1] * r[1]) * ACROSS * ACROSS;
        along += (r[2] * ALONG * distance).powi(2);
    }
    let mean = |sum: f64| (sum / views.len() as f64).sqrt();
    let turned = first.rot.tr_mul_mat(&camera.rot).0;
    let cos = 0.5 * (turned[0][0] + turned[1][1] + turned[2][2] - 1.0);
    Ok(Calibration {
        torso_from_camera: camera,
        balls,
        residual_rad: mean(across),
        residual_m: mean(along),
        change: [(camera.pos - first.pos).norm(), cos.clamp(-1.0, 1.0).acos()],
    })
}

/// Differences between views and parameters, in deviations: three a view, two across the ray and one along it.
fn residuals(views: &[BallView], camera: &Pose, balls: &[[f64; 3]]) -> Vec<f64> {
    let mut out = Vec::with_capacity(3 * views.len());
    for view in views {
        let expected = Vec3(view.torso.compose(camera).inverse_point(balls[view.place]));
        let seen = Vec3(view.in_camera);
        let distance: f64 = seen.norm();
        let ray = seen.scale(1.0 / distance);
        let error = expected - seen;
        // Two directions across the ray; rays point ahead, so that "right" is never along one.
        let down = ray.cross(Vec3([1.0, 0.0, 0.0]));
        let down = down.scale(1.0 / down.norm());
        let right = down.cross(ray);
        out.extend([
            error.dot(right) / (distance * ACROSS),
            error.dot(down) / (distance * ACROSS),
            error.dot(ray) / (distance * ALONG),
        ]);
    }
    out
}

/// Parameters after a change: turn and shift of the camera in its own frame, then the balls.
fn moved(camera: &Pose, balls: &[[f64; 3]], change: &[f64]) -> (Pose, Vec<[f64; 3]>) {
    let turn = Vec3([change[0], change[1], change[2]]);
    let angle: f64 = turn.norm();
    let rot = if angle > 1e-15 {
        camera.rot.mul_mat(&Quat::from_axis_angle(turn.scale(1.0 / angle), angle).to_mat())
    } else {
        camera.rot
    };
    let pos = camera.pos + Vec3([change[3], change[4], change[5]]);
    let shifted = |(k, ball): (usize, &[f64; 3])| [0, 1, 2].map(|i| ball[i] + change[6 + 3 * k + i]);
    (Pose { rot, pos }, balls.iter().enumerate().map(shifted).collect())
}

fn square(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}

/// The step that makes `now + columns step` smallest, by Cholesky's factors of the normal equations; `None` if they are all but singular.
fn solve(columns: &[Vec<f64>], now: &[f64]) -> Option<Vec<f64>> {
    let n = columns.len();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut lower = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let below: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
            let rest = product(&columns[i], &columns[j]) - below;
            if i == j {
                // What is left of a parameter after the others: less than 1e-6 of it is nothing.
                if rest.is_nan() || rest <= 1e-6 * product(&columns[i], &columns[i]) {
                    return None;
                }
                lower[i][i] = rest.sqrt();
            } else {
                lower[i][j] = rest / lower[j][j];
            }
        }
    }
    let mut x: Vec<f64> = columns.iter().map(|column| -product(column, now)).collect();
    for i in 0..n {
        let below: f64 = (0..i).map(|k| lower[i][k] * x[k]).sum();
        x[i] = (x[i] - below) / lower[i][i];
    }
    for i in (0..n).rev() {
        let above: f64 = (i + 1..n).map(|k| lower[k][i] * x[k]).sum();
        x[i] = (x[i] - above) / lower[i][i];
    }
    x.iter().all(|v| v.is_finite()).then_some(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::rng::Rng;

    /// Views of three balls by a camera that sits 2 cm and 3 degrees off; errors of a pixel's third and 4 mm if `noise` is 1.
    fn views(count: usize, lean: f64, noise: f64) -> (Vec<BallView>, Pose) {
        let mut rng = Rng::new(9, 0, 0);
        let first = Pose::g1_camera();
        let off = Quat::<f64>::from_axis_angle(Vec3([0.6, 0.0, 0.8]), 0.05).to_mat();
        let truth = Pose { rot: first.rot.mul_mat(&off), pos: first.pos + Vec3([0.012, -0.01, 0.012]) };
        let balls = [[1.0, 0.2, 0.11], [1.4, -0.4, 0.11], [0.8, 0.0, 0.11]];
        let views = (0..count)
            .map(|k| {
                let place = k % 3;
                let angle = |rng: &mut Rng| rng.uniform(-lean, lean);
                let turn =
                    |axis: [f64; 3], angle: f64| Quat::<f64>::from_axis_angle(Vec3(axis), angle).to_mat();
                let rot = turn([0.0, 0.0, 1.0], angle(&mut rng))
                    .mul_mat(&turn([0.0, 1.0, 0.0], angle(&mut rng)))
                    .mul_mat(&turn([1.0, 0.0, 0.0], angle(&mut rng)));
                let pos = Vec3([0, 1, 2].map(|i| [0.0, 0.0, 0.8][i] + rng.uniform(-0.05, 0.05)));
                let torso = Pose { rot, pos };
                let mut in_camera = torso.compose(&truth).inverse_point(balls[place]);
                for (i, sigma) in [0.0012, 0.0012, 0.004].into_iter().enumerate() {
                    in_camera[i] += noise * sigma * rng.normal();
                }
                BallView { torso, in_camera, place }
            })
            .collect();
        (views, truth)
    }

    fn off(found: &Pose, truth: &Pose) -> [f64; 2] {
        let m = truth.rot.tr_mul_mat(&found.rot).0;
        let angle = (0.5 * (m[0][0] + m[1][1] + m[2][2] - 1.0)).clamp(-1.0, 1.0).acos();
        [(found.pos - truth.pos).norm(), angle]
    }

    #[test]
    fn exact_views_give_the_camera_exactly() {
        let (views, truth) = views(9, 0.3, 0.0);
        let found = calibrate(&views, &Pose::g1_camera()).expect("enough views");
        let [shift, turn] = off(&found.torso_from_camera, &truth);
        assert!(shift < 1e-5 && turn < 1e-5, "{shift} {turn}");
        assert!(found.residual_rad < 1e-6 && found.residual_m < 1e-6);
        assert!(
            (found.change[0] - 0.0197).abs() < 1e-3 && (found.change[1] - 0.05).abs() < 1e-3,
            "{:?}",
            found.change
        );
        assert!((found.balls[1][0] - 1.4).abs() < 1e-4);
    }

    #[test]
    fn views_with_noise_give_it_within_a_centimeter_and_tell_their_residual() {
        let (views, truth) = views(30, 0.3, 1.0);
        let found = calibrate(&views, &Pose::g1_camera()).expect("enough views");
        let [shift, turn] = off(&found.torso_from_camera, &truth);
        assert!(shift < 0.01 && turn < 0.01, "{shift} {turn}");
        // 1.2 mm at about 1.4 m, and 4 mm.
        assert!((4e-4..2e-3).contains(&found.residual_rad), "{}", found.residual_rad);
        assert!((2e-3..6e-3).contains(&found.residual_m), "{}", found.residual_m);
    }

    #[test]
    fn a_torso_that_does_not_lean_is_refused() {
        let (still, _) = views(9, 0.0, 0.0);
        let error = calibrate(&still, &Pose::g1_camera()).expect_err("one direction is open").to_string();
        assert!(error.contains("lean and turn"), "{error}");
        let (few, _) = views(4, 0.3, 0.0);
        let error = calibrate(&few, &Pose::g1_camera()).expect_err("too few").to_string();
        assert!(error.contains("6 views") && error.contains("4 views"), "{error}");
        let (mut broken, _) = views(9, 0.3, 0.0);
        broken[3].in_camera[0] = f64::NAN;
        let error = calibrate(&broken, &Pose::g1_camera()).expect_err("no number").to_string();
        assert!(error.contains("view 3"), "{error}");
    }
}
