//! A recorded motion made fit for a robot: feet that stand hold still on the floor, the pressure is under them, joints keep to their
//! limits, and the motion begins and ends in a stand.
//!
//! First a plan is made: which frames are used, where and when the feet stand, what is added. Then one optimization over all
//! frames at once finds the motion nearest to the original that keeps to it. Its unknowns are the base and the joints of every frame; wishes and
//! conditions are squares (a condition counts where it is broken), accelerations join three frames, so the normal equations are a band, which is
//! factored in place. Inverse dynamics of the robot's model gives pressure, friction and torques.

mod collide;
mod error;
mod figure;
mod momentum;
mod plan;
mod problem;
mod report;
mod rows;
mod sanity;
mod solve;
mod stance;
#[cfg(test)]
mod tests;

pub use error::CleanError;
pub use report::{CleanReport, Peak};

use std::time::Instant;

use paid_robot::{RobotModel, RobotSpec};

use crate::check::{CheckLimits, check_clip};
use crate::{Clip, kick_facts, resample};
use figure::Figure;
use plan::Plan;
use problem::Problem;

/// Choices of a cleaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CleanOptions {
    /// Frames a second of the result.
    pub fps: f64,
    /// How many times as long the motion takes; `None`: as little longer as brings the joints' speeds below nine tenths of their limits, at
    /// most 1.1, so that the kick keeps nine tenths of its speed.
    pub slow: Option<f64>,
    /// Share of the joints' torque limits that the motion should need.
    pub torque_share: f64,
    /// Most that is kept before the kick `[s]`.
    pub lead_s: f64,
    /// Largest angle between the heading of the stand at the beginning and the foot's way at the kick `[rad]`; a player who stands further
    /// turned is turned back, by a step if need be.
    pub facing: f64,
}

impl Default for CleanOptions {
    fn default() -> Self {
        Self { fps: 50.0, slow: None, torque_share: 1.0, lead_s: 4.5, facing: 0.5 }
    }
}

/// A cleaned clip and what was done to it.
#[derive(Clone, Debug)]
pub struct Cleaned {
    /// The clip.
    pub clip: Clip,
    /// Before and after.
    pub report: CleanReport,
}

/// Joint speeds above this share of their limits need more time.
const FAST: f64 = 0.9;
/// Most that time is stretched unless an option says otherwise.
const SLOWEST: f64 = 1.1;

/// Cleans a clip.
///
/// # Errors
/// A motion that is not one of a standing person, too short or too long; an option out of range.
pub fn clean(
    clip: &Clip,
    model: &RobotModel,
    spec: &RobotSpec,
    options: &CleanOptions,
) -> Result<Cleaned, CleanError> {
    let begun = Instant::now();
    sanity::options(options)?;
    sanity::motion(clip, model, spec)?;
    let figure = Figure::new(model, spec)?;
    let limits = CheckLimits::default();
    let before = check_clip(clip, model, spec, &limits)?;
    let asked = before.measures.joint_speed.value / FAST;
    let slow = options.slow.unwrap_or_else(|| asked.clamp(1.0, SLOWEST));
    // Slower motion is the same frames at a lower rate.
    let slower = Clip { fps: clip.fps / slow, ..clip.clone() };
    let original = resample(&slower, model, options.fps);
    let Some(facts) = kick_facts(&original, model, spec) else {
        return Err(CleanError::Feet { name: clip.name.clone() });
    };
    // A stated frame holds. Where it is the fastest one, that of the result is found again: the foot's speed may peak a frame aside.
    let fastest = kick_facts(clip, model, spec).map(|facts| facts.kick_frame);
    let stated = original.kick_frame.filter(|_| clip.kick_frame != fastest);
    let plan = Plan::new(
        &figure,
        &original.poses().collect::<Vec<_>>(),
        options,
        clip.kick_leg.index(),
        stated.unwrap_or(facts.kick_frame),
    );
    if plan.flight() * 2 > plan.kept[1] - plan.kept[0] {
        return Err(CleanError::Air {
            name: clip.name.clone(),
            flight: plan.flight(),
            frames: original.frames,
        });
    }
    let mut problem = Problem::new(&figure, &plan, options.torque_share);
    let (mut poses, steps) = solve::solve(&mut problem, &plan.poses);
    for pose in &mut poses {
        for (q, joint) in pose.joints.iter_mut().zip(&model.joints) {
            *q = q.clamp(joint.range[0], joint.range[1]);
        }
    }
    let mut out = Clip {
        name: clip.name.clone(),
        path: clip.path.clone(),
        license: clip.license.clone(),
        kick_leg: clip.kick_leg,
        ..Clip::of_poses(model, options.fps, &poses)
    };
    let moved = |kick: usize| (kick + plan.added[0]).saturating_sub(plan.kept[0]).min(out.frames - 1);
    let found = || kick_facts(&out, model, spec).map(|facts| facts.kick_frame);
    out.kick_frame = stated.map(moved).or_else(found);
    let after = check_clip(&out, model, spec, &limits)?;
    let mut report = CleanReport::new(&problem, &original, &poses, before, after);
    (report.slow, report.steps) = (slow, steps);
    report.seconds = begun.elapsed().as_secs_f64();
    Ok(Cleaned { clip: out, report })
}
