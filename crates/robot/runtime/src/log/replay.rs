//! Runs a log again.

use std::sync::Arc;

use cpu_time::ThreadTime;

use super::{Course, Frame, LogReader};
use crate::DeployError;
use crate::lateness::Durations;
use crate::player::Player;
use crate::runtime::{PolicyTrace, Runtime};

/// What a replay found.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// Frames.
    pub frames: usize,
    /// Of these with a policy step.
    pub policy_steps: usize,
    /// The first frame that came out otherwise, and in what.
    pub difference: Option<(usize, &'static str)>,
    /// How long it took.
    pub times: ReplayTimes,
    /// How it went, for a chart.
    pub course: Course,
}

/// Processor time of the replaying thread.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReplayTimes {
    /// The policy alone, observation in, action out.
    pub policy: Durations,
    /// Whole steps of the runtime in which the policy acted: packets, tracker, checks, observation, policy, command.
    pub acting: Durations,
    /// All other steps.
    pub others: Durations,
}

/// Runs a log's packets through a new runtime and compares everything bit for bit.
///
/// # Errors
/// If the log is damaged.
pub fn replay(log: &mut LogReader, player: &Arc<Player>) -> Result<Replay, DeployError> {
    let mut runtime = Runtime::new(Arc::clone(player), log.header.limits.clone());
    let mut out = Replay {
        frames: 0,
        policy_steps: 0,
        difference: None,
        times: ReplayTimes::default(),
        course: Course::default(),
    };
    let (mut memory, mut action) = (player.policy.start(1), vec![0.0; player.joints()]);
    while let Some(frame) = log.next_frame()? {
        let begin = ThreadTime::now();
        let output = runtime.step(frame.now_us, &frame.packets, frame.stop);
        let took = begin.elapsed();
        if output.acted { &mut out.times.acting } else { &mut out.times.others }.add(took);
        if out.course.due(frame.now_us) {
            out.course.add(&runtime.status(frame.now_us));
        }
        let again = Frame::new(frame.now_us, &frame.packets, frame.stop, &output, &runtime);
        let bits = |trace: &Option<PolicyTrace>| {
            trace
                .as_ref()
                .map(|t| t.observation.iter().chain(&t.action).map(|x| x.to_bits()).collect::<Vec<_>>())
        };
        let what = if bits(&again.trace) != bits(&frame.trace) {
            Some("the policy's step")
        } else if again.command != frame.command {
            Some("the command")
        } else if again.state != frame.state || again.events != frame.events {
            Some("the state")
        } else {
            None
        };
        if let (Some(what), None) = (what, out.difference) {
            out.difference = Some((out.frames, what));
        }
        if let Some(trace) = &again.trace {
            let begin = ThreadTime::now();
            player.policy.act(&trace.observation, &mut memory, &mut action);
            out.times.policy.add(begin.elapsed());
        }
        out.frames += 1;
        out.policy_steps += usize::from(frame.trace.is_some());
    }
    Ok(out)
}

impl ReplayTimes {
    /// A table: a row a bin, then the quantiles.
    pub fn table(&self) -> String {
        Durations::table(&[
            ("policy alone", &self.policy),
            ("step that acts", &self.acting),
            ("other step", &self.others),
        ])
    }
}
