//! A human motion to a clip of the robot.

use std::time::Instant;

use paid_lanes::{Quat, Vec3};
use paid_motion::check::{Measures, foot_contacts, measure};
use paid_motion::{Clip, KickLabel, KickLeg, fastest_kick};
use paid_robot::{RobotModel, RobotSpec};
use serde::Serialize;

use crate::{
    Ends, Goals, HumanMotion, Naming, Pose, RetargetError, Role, Setting, SolveLimits, Solver, Table,
};

/// How fast the human's time runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeScale {
    /// Everything takes this many times as long.
    Fixed(f64),
    /// As little slower as keeps all joints within their speed limits, at most four times.
    Auto,
}

/// Choices of a retargeting.
#[derive(Clone, Debug, PartialEq)]
pub struct RetargetOptions {
    /// Frames a second of the clip.
    pub fps: f64,
    /// Height of the human `[m]`.
    pub height_m: f64,
    /// Part of the motion that is used, seconds of the file.
    pub span_s: [f64; 2],
    /// Time scaling.
    pub time_scale: TimeScale,
    /// Share of the joints' speed limits that is used; `None`: no limit.
    pub speed_share: Option<f64>,
    /// The kicking leg; `None`: that with the faster foot.
    pub kick_leg: Option<KickLeg>,
    /// Terms of use to state in the clip.
    pub license: Option<String>,
    /// Stage two's end; tests ask for more.
    pub limits: SolveLimits,
}

impl Default for RetargetOptions {
    fn default() -> Self {
        Self {
            fps: 50.0,
            height_m: 1.75,
            span_s: [0.0, f64::INFINITY],
            time_scale: TimeScale::Fixed(1.0),
            speed_share: Some(1.0),
            kick_leg: None,
            license: None,
            limits: SolveLimits { steps: 30, share: 1e-3 },
        }
    }
}

/// What a retargeting did, in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Frames of the clip.
    pub frames: usize,
    /// Names and axes that were recognized.
    pub naming: &'static str,
    /// Everything takes this many times as long as in the file.
    pub time_scale: f64,
    /// Mean over frames and bodies of the distance from the scaled human `[m]`.
    pub position_error_m: f64,
    /// Largest such distance `[m]`.
    pub position_worst_m: f64,
    /// Mean over frames and bodies of the angle from the human's orientation `[rad]`.
    pub rotation_error: f64,
    /// Linear systems solved a frame in the two stages.
    pub steps: [f64; 2],
    /// Share of joint samples at an end of their range.
    pub at_range: f64,
    /// Share of joint samples that moved as fast as allowed.
    pub at_speed: f64,
    /// Largest joint speed over its limit.
    pub joint_speed: f64,
    /// How far the whole clip was moved up to put the feet on the ground `[m]`.
    pub ground_shift_m: f64,
    /// Lowest point of the robot below the ground `[m]`.
    pub penetration_m: f64,
    /// Longest way of a foot in one stance `[m]`.
    pub sliding_m: f64,
    /// The kick: frame of the fastest foot.
    pub kick_frame: usize,
    /// Speed of the kicking foot's center of mass there `[m/s]`.
    pub kick_speed: f64,
    /// Time of the inverse kinematics of all frames `[s]`.
    pub solve_s: f64,
}

/// A clip and how it came about.
#[derive(Clone, Debug)]
pub struct Retargeted {
    /// The clip; its first frame stands above the origin and looks along x.
    pub clip: Clip,
    /// The human that it follows, at the clip's frame rate and in its place.
    pub human: HumanMotion,
    /// Where that human, scaled to the robot's size, has its feet and hands, in the clip's place.
    pub ends: Ends,
    /// Numbers.
    pub report: Report,
}

/// Samples this near to an end of the range are at it `[rad]`.
const AT_END: f64 = 1e-6;
/// Longest part that is retargeted: a kick takes seconds `[s]`.
const LONGEST_S: f64 = 300.0;
/// Less is no motion of a player `[s]`.
pub(crate) const SHORTEST_S: f64 = 0.5;
/// Most that a motion is slowed down to keep the speed limits.
const SLOWEST: f64 = 4.0;
/// A trunk farther off upright on average lies `[rad]`.
const MOST_TILT: f64 = 1.05;
/// A clip farther from the scaled human on average is not that human's: distance `[m]` and angle `[rad]`.
const WORST_FIT: [f64; 2] = [0.15, 0.5];
/// Stage one only leads the way.
const LEAD: SolveLimits = SolveLimits { steps: 11, share: 1e-2 };

/// Retargets a human motion.
///
/// # Errors
/// A motion of less than half a second, an option out of range, bones or bodies that no table knows, a robot that is more than 150 mm or 0.5 rad from
/// the human on average.
pub fn retarget(
    motion: &HumanMotion,
    model: &RobotModel,
    spec: &RobotSpec,
    options: &RetargetOptions,
) -> Result<Retargeted, RetargetError> {
    check(options)?;
    let naming = Naming::of(motion)?;
    if motion.duration_s() < SHORTEST_S {
        return Err(RetargetError::Short {
            path: motion.path.clone(),
            least: SHORTEST_S,
            frames: motion.frames,
            fps: motion.fps,
        });
    }
    let cut = motion.cut(options.span_s[0], options.span_s[1]);
    // Who asks for a faster motion gets fewer frames.
    let shorter = if let TimeScale::Fixed(scale) = options.time_scale { scale.min(1.0) } else { 1.0 };
    if cut.frames < 2 || cut.duration_s() * options.fps * shorter < 2.0 {
        let expected = "a part of the motion of at least 3 frames";
        let [from, to] = options.span_s;
        let to = if to.is_finite() { format!("{to} s") } else { "the end".to_owned() };
        let found =
            format!("{from} s to {to} of the {:.2} s of {}", motion.duration_s(), motion.path.display());
        return Err(RetargetError::Option { option: Setting::Part, expected, found });
    }
    if cut.duration_s() > LONGEST_S {
        let expected = "a part of the motion of at most 300 s; name the seconds around the kick";
        let found = format!("{:.0} s of {}", cut.duration_s(), motion.path.display());
        return Err(RetargetError::Option { option: Setting::Part, expected, found });
    }
    upright(&cut, &naming)?;
    let run = Run { motion: &cut, naming, model, limit: spec.resolve(model)?.velocity_limit, options };
    let (scale, tracked) = match options.time_scale {
        TimeScale::Fixed(scale) => (scale, run.track(scale, options.speed_share)?),
        TimeScale::Auto => run.slow_down()?,
    };
    run.finish(scale, tracked, spec)
}

/// The trunk must be upright on average, or nothing that follows makes sense.
fn upright(motion: &HumanMotion, naming: &Naming) -> Result<(), RetargetError> {
    let bone = |role: Role| {
        let source = naming.sources.iter().find(|s| s.role == role)?;
        motion.skeleton.find(&source.position)
    };
    let (Some(hips), Some(torso)) = (bone(Role::Hips), bone(Role::Torso)) else { return Ok(()) };
    let tilt = |t: usize| {
        let trunk = Vec3(motion.pos(t)[torso]) - Vec3(motion.pos(t)[hips]);
        trunk.x().hypot(trunk.y()).atan2(trunk.z())
    };
    let mean = (0..motion.frames).map(tilt).sum::<f64>() / motion.frames as f64;
    if mean > MOST_TILT {
        return Err(RetargetError::Lying { path: motion.path.clone(), degrees: mean.to_degrees() });
    }
    Ok(())
}

fn check(options: &RetargetOptions) -> Result<(), RetargetError> {
    let mut checks = vec![
        (Setting::ClipRate, "10 to 500 Hz", options.fps, 10.0..=500.0),
        (Setting::Height, "0.5 to 2.5 m", options.height_m, 0.5..=2.5),
        (Setting::Begin, "a time of at least 0 s", options.span_s[0], 0.0..=f64::MAX),
        (Setting::End, "a time of at least 0 s", options.span_s[1], 0.0..=f64::INFINITY),
    ];
    if let TimeScale::Fixed(scale) = options.time_scale {
        checks.push((Setting::TimeScale, "'auto' or 0.25 to 10", scale, 0.25..=10.0));
    }
    if let Some(share) = options.speed_share {
        checks.push((Setting::SpeedShare, "'off' or 0.05 to 10", share, 0.05..=10.0));
    }
    match checks.into_iter().find(|(.., value, range)| !range.contains(value)) {
        Some((option, expected, value, _)) => {
            Err(RetargetError::Option { option, expected, found: value.to_string() })
        }
        None => Ok(()),
    }
}

struct Run<'a> {
    motion: &'a HumanMotion,
    naming: Naming,
    model: &'a RobotModel,
    limit: Vec<f64>,
    options: &'a RetargetOptions,
}

struct Tracked {
    human: HumanMotion,
    poses: Vec<Pose>,
    errors: Vec<[f64; 2]>,
    placed: Vec<bool>,
    steps: [usize; 2],
    at_range: usize,
    at_speed: usize,
    solve_s: f64,
}

impl Run<'_> {
    /// Follows the motion, `scale` times as slow.
    fn track(&self, scale: f64, share: Option<f64>) -> Result<Tracked, RetargetError> {
        let table = (self.naming.table)();
        let human = self.motion.resample(self.options.fps, scale);
        let goals = Goals::new(&human, &self.naming, &table, self.options.height_m)?;
        let mut solver = Solver::new(self.model, &table)?;
        let reach: Option<Vec<f64>> =
            share.map(|s| self.limit.iter().map(|limit| s * limit / self.options.fps).collect());
        let begun = Instant::now();
        let mut pose = solver.start(goals.frame(0));
        // The first frame has no frame before it to lean on: stages in turn until nothing moves.
        let thorough = SolveLimits { steps: 200, share: 1e-9 };
        for _ in 0..3 {
            solver.solve(&mut pose, goals.frame(0), 0, None, thorough);
            solver.solve(&mut pose, goals.frame(0), 1, None, thorough);
        }
        let mut out = Tracked {
            poses: Vec::with_capacity(goals.frames),
            errors: Vec::new(),
            placed: solver.placed(),
            steps: [0; 2],
            at_range: 0,
            at_speed: 0,
            solve_s: 0.0,
            human,
        };
        for t in 0..goals.frames {
            let before = pose.joints.clone();
            let near = if t > 0 { reach.as_deref().map(|reach| (&before[..], reach)) } else { None };
            for (stage, limits) in [LEAD, self.options.limits].into_iter().enumerate() {
                let solved = solver.solve(&mut pose, goals.frame(t), stage, near, limits);
                out.steps[stage] += solved.steps;
            }
            for (j, (q, range)) in pose.joints.iter().zip(&solver.range).enumerate() {
                out.at_range += usize::from(*q < range[0] + AT_END || *q > range[1] - AT_END);
                out.at_speed +=
                    usize::from(near.is_some_and(|(from, r)| (q - from[j]).abs() > r[j] - AT_END));
            }
            out.poses.push(pose.clone());
        }
        out.solve_s = begun.elapsed().as_secs_f64();
        for (t, pose) in out.poses.iter().enumerate() {
            out.errors.extend(solver.errors(pose, goals.frame(t)));
        }
        Ok(out)
    }

    /// The least scale, in steps of a twentieth, at which the unlimited motion keeps the speed limits.
    fn slow_down(&self) -> Result<(f64, Tracked), RetargetError> {
        let share = self.options.speed_share.unwrap_or(1.0);
        let mut scale: f64 = 1.0;
        loop {
            let free = self.track(scale, None)?;
            let excess = self.joint_speed(&free.poses) / share;
            if excess <= 1.0 || scale >= SLOWEST {
                return Ok((scale, self.track(scale, Some(share))?));
            }
            scale = slower(scale, excess);
        }
    }

    /// Largest joint speed between frames over its limit.
    fn joint_speed(&self, poses: &[Pose]) -> f64 {
        let pairs = poses.windows(2).flat_map(|w| w[0].joints.iter().zip(&w[1].joints).zip(&self.limit));
        pairs.map(|((a, b), limit)| (b - a).abs() * self.options.fps / limit).fold(0.0, f64::max)
    }

    fn finish(
        &self,
        scale: f64,
        mut tracked: Tracked,
        spec: &RobotSpec,
    ) -> Result<Retargeted, RetargetError> {
        let (model, fps) = (self.model, self.options.fps);
        let table = (self.naming.table)();
        let goals = Goals::new(&tracked.human, &self.naming, &table, self.options.height_m)?;
        let mut ends = Ends::new(model, &table, &goals);
        if let Some(place) = to_origin(&mut tracked) {
            ends.moved(place);
        }
        let mut clip = self.clip(&tracked.poses);
        // Feet on the ground: the lower of the two heights at which the soles rest.
        let feet = spec.indices(model)?.feet;
        let floor = foot_contacts(&clip, model, &feet).iter().map(|c| c.floor).fold(f64::INFINITY, f64::min);
        if floor.is_finite() {
            tracked.poses.iter_mut().for_each(|p| p.base_pos[2] -= floor);
            ends.lower(floor);
            clip = self.clip(&tracked.poses);
        }
        let kick = fastest_kick(&clip, model, spec).unwrap_or(KickLabel {
            leg: KickLeg::Right,
            frame: 0,
            speed: 0.0,
        });
        clip.kick_leg = self.options.kick_leg.unwrap_or(kick.leg);
        clip.kick_frame = (clip.kick_leg == kick.leg).then_some(kick.frame);
        let measures: Measures = measure(&clip, model, spec)?;
        let placed: Vec<f64> = tracked
            .errors
            .iter()
            .zip(tracked.placed.iter().cycle())
            .filter(|(_, placed)| **placed)
            .map(|(e, _)| e[0])
            .collect();
        let mean = |sum: f64, count: usize| sum / count.max(1) as f64;
        let samples = clip.frames * clip.joints;
        let report = Report {
            frames: clip.frames,
            naming: self.naming.name,
            time_scale: scale,
            position_error_m: mean(placed.iter().sum(), placed.len()),
            position_worst_m: placed.iter().copied().fold(0.0, f64::max),
            rotation_error: mean(tracked.errors.iter().map(|e| e[1]).sum(), tracked.errors.len()),
            steps: tracked.steps.map(|s| mean(s as f64, clip.frames)),
            at_range: mean(tracked.at_range as f64, samples),
            at_speed: mean(tracked.at_speed as f64, samples),
            joint_speed: self.joint_speed(&tracked.poses),
            ground_shift_m: if floor.is_finite() { -floor } else { 0.0 },
            penetration_m: measures.penetration_m.value,
            sliding_m: measures.sliding_m.value,
            kick_frame: measures.foot_speed.frame,
            kick_speed: measures.foot_speed.value,
            solve_s: tracked.solve_s,
        };
        debug_assert!((clip.fps - fps).abs() < 1e-9);
        if report.position_error_m > WORST_FIT[0] || report.rotation_error > WORST_FIT[1] {
            return Err(self.misfit(&tracked, &table, &report));
        }
        Ok(Retargeted { clip, human: tracked.human, ends, report })
    }

    fn misfit(&self, tracked: &Tracked, table: &Table, report: &Report) -> RetargetError {
        let (n, frames) = (table.tasks.len(), report.frames.max(1) as f64);
        let mean = |k: usize| tracked.errors.iter().skip(k).step_by(n).map(|e| e[1]).sum::<f64>() / frames;
        let worst = (0..n).max_by(|&a, &b| mean(a).total_cmp(&mean(b))).unwrap_or(0);
        let bone = table.tasks.get(worst).and_then(|task| self.naming.source(task.role));
        RetargetError::Fit {
            path: self.motion.path.clone(),
            most_m: WORST_FIT[0],
            most_rad: WORST_FIT[1],
            distance_m: report.position_error_m,
            angle: report.rotation_error,
            bone: bone.map(|source| source.orientation.clone()).unwrap_or_default(),
            worst: mean(worst),
        }
    }

    fn clip(&self, poses: &[Pose]) -> Clip {
        let base: Vec<_> = poses.iter().map(|p| (p.base_pos, p.base_quat)).collect();
        let joints: Vec<f64> = poses.iter().flat_map(|p| p.joints.iter().copied()).collect();
        Clip {
            name: self.motion.name.clone(),
            path: self.motion.path.clone(),
            license: self.options.license.clone(),
            ..Clip::from_poses(self.model, self.options.fps, &base, &joints)
        }
    }
}

/// The next scale to try where joints are `excess` times as fast as they may be.
fn slower(scale: f64, excess: f64) -> f64 {
    ((scale * excess * 20.0).ceil() / 20.0).max(scale + 0.05).min(SLOWEST)
}

/// Moves robot and human so that the robot's first base is above the origin and looks along x. What was at `p` in the robot's world is then at
/// `turn` applied to `p - from`; `None` without a frame.
fn to_origin(tracked: &mut Tracked) -> Option<(Quat<f64>, Vec3<f64>)> {
    let first = tracked.poses.first()?;
    let ahead = Quat(first.base_quat).rotate(Vec3([1.0, 0.0, 0.0]));
    let turn = Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), -ahead.y().atan2(ahead.x()));
    let from = Vec3([first.base_pos[0], first.base_pos[1], 0.0]);
    // Of the two signs of a quaternion the one with a positive w to begin with.
    let sign = if turn.mul(Quat(first.base_quat)).0[0] < 0.0 { -1.0 } else { 1.0 };
    for pose in &mut tracked.poses {
        pose.base_pos = turn.rotate(Vec3(pose.base_pos) - from).0;
        pose.base_quat = turn.mul(Quat(pose.base_quat)).normalize().0.map(|x| sign * x);
    }
    let done = (turn, from);
    // The human is larger: about its own hips' first place.
    let Some(&hips) = tracked.human.pos.first() else { return Some(done) };
    let from = Vec3([hips[0], hips[1], 0.0]);
    for pos in &mut tracked.human.pos {
        *pos = turn.rotate(Vec3(*pos) - from).0;
    }
    for quat in &mut tracked.human.quat {
        *quat = turn.mul(Quat(*quat)).normalize().0;
    }
    Some(done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_is_slowed_down_by_twentieths_and_four_times_at_most() {
        assert_eq!(slower(1.0, 1.26), 1.3);
        assert_eq!(slower(1.0, 1.0001), 1.05);
        assert_eq!(slower(2.0, 9.0), SLOWEST);
        // A sum of twentieths may end just below.
        assert_eq!(slower(SLOWEST.next_down(), 1.01), SLOWEST);
    }
}
