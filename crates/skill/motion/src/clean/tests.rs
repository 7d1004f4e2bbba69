//! Cleaning of kicks that are damaged on purpose; none is anybody's recording.

use paid_lanes::{Quat, Vec3};

use super::*;
use crate::MotionLibrary;
use crate::check::Verdict;
use crate::generate::Pose;

fn kick() -> (RobotModel, RobotSpec, Clip) {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let clip = MotionLibrary::builtin(&model, &spec, 50.0).expect("built in").clips.remove(0);
    (model, spec, clip)
}

/// The slope of the cost, as the normal equations have it.
fn slopes(problem: &Problem<'_>, poses: &[Pose]) -> Vec<f64> {
    let n = problem.figure.n;
    let mut band = rows::Band::new(n * poses.len(), 3 * n);
    problem.cost(poses, Some(&mut band));
    band.right.iter().map(|x| -2.0 * x).collect()
}

#[test]
fn the_normal_equations_have_the_slope_of_the_cost() {
    let (model, spec, clip) = kick();
    let figure = Figure::new(&model, &spec).expect("a humanoid");
    let poses = clip.poses().collect::<Vec<_>>();
    let plan = Plan::new(&figure, &poses, &CleanOptions::default(), clip.kick_leg.index(), 90);
    let problem = Problem::new(&figure, &plan, 0.5);
    let mut poses = plan.poses.clone();
    for (t, pose) in poses.iter_mut().enumerate() {
        for (j, q) in pose.joints.iter_mut().enumerate() {
            *q += 0.02 * (0.3 * t as f64 + j as f64).sin();
        }
    }
    let slope = slopes(&problem, &poses);
    let (mut off, mut size) = (0.0, 0.0);
    for t in [0, 40, 101, poses.len() - 1] {
        for k in 0..figure.n {
            let cost = |h: f64| {
                let mut step = vec![0.0; figure.n];
                step[k] = h;
                let mut moved = poses.clone();
                moved[t] = problem::moved(&poses[t], &step);
                problem.cost(&moved, None)
            };
            let difference = (cost(1e-6) - cost(-1e-6)) / 2e-6;
            off += (difference - slope[t * figure.n + k]).powi(2);
            size += difference * difference;
        }
    }
    // The change of the inertias with the pose is left out.
    assert!(off.sqrt() < 0.05 * size.sqrt(), "{} of {}", off.sqrt(), size.sqrt());
}

#[test]
fn a_kick_that_slides_and_sinks_comes_back_to_the_floor() {
    let (model, spec, clip) = kick();
    let mut poses = clip.poses().collect::<Vec<_>>();
    for (t, pose) in poses.iter_mut().enumerate() {
        let s = (0.15 * t as f64).sin();
        pose.base_pos[0] += 0.03 * s;
        pose.base_pos[2] -= 0.04 + 0.015 * s;
    }
    let damaged = Clip {
        name: "damaged".to_owned(),
        license: Some("ours".to_owned()),
        kick_leg: clip.kick_leg,
        ..Clip::of_poses(&model, 50.0, &poses)
    };
    let cleaned = clean(&damaged, &model, &spec, &CleanOptions::default()).expect("a kick");
    let (before, after) = (&cleaned.report.before, &cleaned.report.after);
    assert!(before.verdict > Verdict::Pass && before.measures.penetration_m.value > 0.04);
    assert!(after.measures.penetration_m.value < 0.010, "{:?}", after.measures.penetration_m);
    assert!(after.measures.sliding_m.value < before.measures.sliding_m.value);
    assert!(after.measures.unbalanced < 0.05, "{}", after.measures.unbalanced);
    assert!(after.verdict <= Verdict::Warn, "{:?}", after.findings);
    let [was, is] = cleaned.report.kick_speed;
    assert!(is > 0.9 * was, "{was} to {is} m/s");
    assert_eq!(cleaned.clip.kick_leg, damaged.kick_leg);
    assert_eq!(after.measures.end_feet, 2);
}

fn refusal(clip: &Clip) -> String {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    match clean(clip, &model, &spec, &CleanOptions::default()) {
        Ok(cleaned) => panic!("cleaned: {:?}", cleaned.report.reasons),
        Err(error) => error.to_string(),
    }
}

#[test]
fn input_that_is_no_kick_is_refused_in_one_sentence() {
    let (model, _, clip) = kick();
    let changed = |change: &dyn Fn(usize, &mut Pose)| {
        let mut poses = clip.poses().collect::<Vec<_>>();
        poses.iter_mut().enumerate().for_each(|(t, pose)| change(t, pose));
        Clip { name: "odd".to_owned(), ..Clip::of_poses(&model, 50.0, &poses) }
    };
    let short = crate::edit::cut(&clip, &model, 0.0, 0.04).expect("3 frames");
    assert!(refusal(&short).contains("found 3 frames in 0.04 s"), "{}", refusal(&short));
    let long = Clip { fps: 0.02, ..clip.clone() };
    assert!(refusal(&long).contains("expected a motion of 0.5 to 120 s"), "{}", refusal(&long));
    let centimeters = changed(&|_, pose| pose.base_pos = pose.base_pos.map(|x| 100.0 * x));
    assert!(refusal(&centimeters).contains("look like centimeters"), "{}", refusal(&centimeters));
    let back = Quat::from_axis_angle(Vec3([0.0, 1.0, 0.0]), -1.5);
    let lying = changed(&|_, pose| {
        pose.base_quat = back.mul(Quat(pose.base_quat)).0;
        pose.base_pos[2] = 0.1;
    });
    assert!(refusal(&lying).contains("it lies, or another axis points up"), "{}", refusal(&lying));
    let aloft = changed(&|_, pose| pose.base_pos[2] += 1.5);
    assert!(refusal(&aloft).contains("it floats"), "{}", refusal(&aloft));
    let hollow = changed(&|t, pose| {
        if t == 7 {
            pose.joints[3] = f64::NAN;
        }
    });
    assert!(refusal(&hollow).contains("frame 7"), "{}", refusal(&hollow));
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let fast = CleanOptions { slow: Some(0.5), ..CleanOptions::default() };
    let error = clean(&clip, &model, &spec, &fast).expect_err("faster");
    assert_eq!(error.to_string(), "stretch: expected 1 to 4, found 0.5");
}

#[test]
fn a_recording_at_another_rate_is_brought_to_the_requested_one() {
    let (model, spec, clip) = kick();
    let coarse = resample(&clip, &model, 24.0);
    let cleaned = clean(&coarse, &model, &spec, &CleanOptions::default()).expect("a kick");
    assert_eq!(cleaned.clip.fps, 50.0);
    assert!(cleaned.clip.duration_s() < 10.0);
}

// Slow: makes all built-in kicks and cleans the one that turns most three times, because options change all of it.
#[test]
fn what_is_kept_before_the_kick_and_where_the_first_stand_faces_are_options() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let facing = |clip: &Clip| {
        let facts = kick_facts(clip, &model, &spec).expect("feet");
        let foot = model.body_index(&spec.feet[clip.kick_leg.index()]).expect("a foot");
        let way = clip.body_lin_vel(facts.kick_frame)[foot];
        let off = way[1].atan2(way[0]) - Quat(clip.body_quat(0)[0]).to_mat().yaw();
        off.sin().atan2(off.cos()).abs()
    };
    // Of the generator's kicks the one that goes farthest off where the player stands, after three seconds of waiting.
    let clips = MotionLibrary::builtin(&model, &spec, 50.0).expect("built in").clips;
    let clip = clips.iter().max_by(|a, b| facing(a).total_cmp(&facing(b))).expect("some");
    let waits = std::iter::repeat_n(clip.poses().next().expect("a frame"), 150);
    let poses: Vec<Pose> = waits.chain(clip.poses()).collect();
    let waiting = Clip { kick_leg: clip.kick_leg, ..Clip::of_poses(&model, 50.0, &poses) };
    let of = |options: CleanOptions| clean(&waiting, &model, &spec, &options).expect("a kick").clip;
    let whole = of(CleanOptions::default());
    let short = of(CleanOptions { lead_s: 2.0, ..CleanOptions::default() });
    assert!(whole.frames > short.frames + 50, "{} and {} frames", whole.frames, short.frames);
    let ahead = of(CleanOptions { lead_s: 2.0, facing: 0.05, ..CleanOptions::default() });
    assert!(facing(&short) > 0.3 && facing(&ahead) < 0.15, "{} {}", facing(&short), facing(&ahead));
    let wide = CleanOptions { facing: 2.0, ..CleanOptions::default() };
    let error = clean(&waiting, &model, &spec, &wide).expect_err("more than a right angle").to_string();
    assert!(error.starts_with("facing: expected 0 to 90 degrees, found 114"), "{error}");
}

// Slow: cleans a kick three times, because each way to name its frame needs a cleaning of its own.
#[test]
fn a_stated_kick_frame_is_kept_and_the_fastest_one_is_found_again() {
    let (model, spec, clip) = kick();
    let fastest = kick_facts(&clip, &model, &spec).expect("feet").kick_frame;
    let of = |kick_frame: Option<usize>, slow: f64| {
        let options = CleanOptions { lead_s: 1.0, slow: Some(slow), ..CleanOptions::default() };
        clean(&Clip { kick_frame, ..clip.clone() }, &model, &spec, &options).expect("a kick")
    };
    // Everything takes 5/4 of its time: so does the way to a frame that 4 divides.
    let stated = fastest / 4 * 4 - 12;
    let cleaned = of(Some(stated), 1.25);
    let due = stated * 5 / 4 + cleaned.report.added[0] - cleaned.report.cut[0];
    assert_eq!(cleaned.clip.kick_frame, Some(due));
    let (found, same) = (of(None, 1.0).clip, of(Some(fastest), 1.0).clip);
    assert_eq!(found.kick_frame, kick_facts(&found, &model, &spec).map(|facts| facts.kick_frame));
    assert_eq!(same, found);
}
