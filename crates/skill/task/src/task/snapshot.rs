//! Exact save and restore of a shard: the numbers of the lanes widen to `f64` and come back exactly, in groups of as many lanes as
//! this instruction set has.

use core::ops::Range;

use paid_lanes::Real;
use paid_physics::{EnvParams, LaneState, Simulator};
use serde::{Deserialize, Serialize};

use crate::codec::{Reader, append, expect};
use crate::episode::stance::EndStates;
use crate::references::anchoring::Anchoring;
use crate::scene::kick::KickState;
use crate::task::EnvTask;
use crate::{
    BallCurriculum, EndCause, InitialState, KickEvent, SamplerState, Task, TaskMetrics, end_names,
    reward_names,
};

/// First bytes of a snapshot; the last is the version.
const MAGIC: &[u8; 8] = b"paidtsk\x08";
/// The version before: with three more reward terms, the last ones, and five more numbers of a group, behind its kick.
const BEFORE: (&[u8; 8], usize, usize) = (b"paidtsk\x07", 3, 5);

/// What a shard must agree with.
#[derive(Serialize, Deserialize)]
struct Header {
    envs: usize,
    lanes: usize,
    joints: usize,
    motions: usize,
    bins: usize,
    seed: u64,
}

/// A shard but for its environments.
#[derive(Serialize, Deserialize)]
struct Shard {
    observations: u64,
    sampler: SamplerState,
    curriculum: BallCurriculum,
    failures: Vec<f32>,
    end_states: EndStates,
    metrics: TaskMetrics,
    /// Running sums, the lanes of each one after another.
    sums: Vec<f64>,
    /// What each group remembers, the same way.
    groups: Vec<Vec<f64>>,
}

impl Shard {
    /// Takes the last `terms` reward terms, and these `numbers` of each group, out of a snapshot of an earlier version.
    fn without(&mut self, terms: usize, numbers: Range<usize>, lanes: usize) -> Result<(), String> {
        let short = || "task snapshot: it has fewer numbers than its version".to_owned();
        let rewards = &mut self.metrics.reward_terms;
        let kept = rewards.len().checked_sub(terms).ok_or_else(short)?;
        rewards.truncate(kept);
        let lanes_of = |numbers: Range<usize>| numbers.start * lanes..numbers.end * lanes;
        for (values, gone) in [(&mut self.sums, kept..kept + terms)]
            .into_iter()
            .chain(self.groups.iter_mut().map(|g| (g, numbers.clone())))
        {
            let gone = lanes_of(gone);
            if gone.end > values.len() {
                return Err(short());
            }
            values.drain(gone);
        }
        Ok(())
    }
}

/// An environment.
#[derive(Serialize, Deserialize)]
struct Environment {
    id: u32,
    motion: usize,
    frame: usize,
    hold: usize,
    after_strike: bool,
    anchoring: Option<Anchoring>,
    step: u32,
    push_in: u32,
    /// Positions of the random streams.
    reset_rng: u64,
    push_rng: u64,
    start_rng: u64,
    ended: Option<EndCause>,
    kick: Option<KickEvent>,
    forced: Option<InitialState>,
    params: EnvParams,
    state: LaneState,
}

impl Environment {
    fn new(env: &EnvTask, state: LaneState) -> Self {
        Self {
            id: env.id,
            motion: env.motion,
            frame: env.frame,
            hold: env.hold,
            after_strike: env.after_strike,
            anchoring: env.anchoring,
            step: env.step,
            push_in: env.push_in,
            reset_rng: env.reset_rng.position(),
            push_rng: env.push_rng.position(),
            start_rng: env.start_rng.position(),
            ended: env.ended,
            kick: env.kick.clone(),
            forced: env.forced.clone(),
            params: env.params.clone(),
            state,
        }
    }
}

/// The lanes of every number, one number after another.
fn widen<'a, V: Real>(numbers: impl IntoIterator<Item = &'a V>) -> Vec<f64> {
    numbers.into_iter().flat_map(|number| (0..V::LANES).map(|lane| number.lane(lane))).collect()
}

/// The other way; `what` is for the error.
fn narrow<V: Real>(what: &str, mut numbers: Vec<&mut V>, from: &[f64]) -> Result<(), String> {
    expect(what, numbers.len() * V::LANES, from.len())?;
    for (number, lanes) in numbers.iter_mut().zip(from.chunks_exact(V::LANES)) {
        for (lane, x) in lanes.iter().enumerate() {
            number.set_lane(lane, *x);
        }
    }
    Ok(())
}

/// What groups of `found` lanes (at least one) hold, in groups of `own` lanes: [group][number x lane]. Environments keep their order.
fn regroup(groups: &[Vec<f64>], found: usize, own: usize) -> Result<Vec<Vec<f64>>, String> {
    let size = groups.first().map_or(0, Vec::len);
    for group in groups {
        expect("numbers of a group", size, group.len())?;
    }
    let (envs, numbers) = (groups.len() * found, size / found);
    expect("numbers of a group", numbers * found, size)?;
    let value = |env: usize, number: usize| groups[env / found][number * found + env % found];
    let group = |first: usize| {
        (0..numbers).flat_map(|number| (first..first + own).map(move |env| value(env, number))).collect()
    };
    expect("environments beyond whole groups", 0, envs % own)?;
    Ok((0..envs).step_by(own).map(group).collect())
}

/// Running sums of `found` lanes (at least one) in `own` lanes: the sum over the lanes of each stays.
fn refold(sums: &[f64], found: usize, own: usize) -> Vec<f64> {
    let fold = |lanes: &[f64]| {
        let mut folded = vec![0.0; own];
        for (lane, x) in lanes.iter().enumerate() {
            folded[lane % own] += x;
        }
        folded
    };
    sums.chunks(found).flat_map(fold).collect()
}

impl<V: Real, S: Simulator<V>> Task<V, S> {
    fn header(&self) -> Header {
        Header {
            envs: self.envs.len(),
            lanes: V::LANES,
            joints: self.config.joints(),
            motions: self.library.len(),
            bins: self.library.bins(),
            seed: self.seed,
        }
    }

    pub(crate) fn save_bytes(&self) -> Vec<u8> {
        let group = |group: &crate::group::GroupTask<V>| {
            let mut group = group.clone();
            widen(group.fields().into_iter().map(|field| &*field))
        };
        let shard = Shard {
            observations: self.observations,
            sampler: self.sampler.clone(),
            curriculum: self.curriculum,
            failures: self.failures.clone(),
            end_states: self.end_states.clone(),
            metrics: self.metrics.clone(),
            sums: widen(self.sums.clone().all_mut().map(|sum| &*sum)),
            groups: self.groups.iter().map(group).collect(),
        };
        let state = |index: usize| self.sim.save_lane(index / V::LANES, index % V::LANES);
        let environments =
            self.envs.iter().enumerate().map(|(index, env)| Environment::new(env, state(index)));
        let bytes = append(append(MAGIC.to_vec(), &self.header()), &shard);
        environments.fold(bytes, |bytes, environment| append(bytes, &environment))
    }

    pub(crate) fn restore_bytes(&mut self, bytes: &[u8]) -> Result<(), String> {
        let (magic, terms, numbers) = BEFORE;
        let is_before = bytes.starts_with(magic);
        let mut reader = Reader::new(bytes, if is_before { magic } else { MAGIC })?;
        let (header, found): (Header, Header) = (self.header(), reader.value()?);
        expect("environments", header.envs, found.envs)?;
        if found.lanes == 0 || !found.envs.is_multiple_of(found.lanes) {
            let (envs, lanes) = (found.envs, found.lanes);
            return Err(format!(
                "task snapshot: lanes: expected a divisor of {envs} environments, found {lanes}"
            ));
        }
        expect("joints", header.joints, found.joints)?;
        expect("motions", header.motions, found.motions)?;
        expect("phase bins", header.bins, found.bins)?;
        expect("seed", header.seed, found.seed)?;
        let mut shard: Shard = reader.value()?;
        if is_before {
            // Actions, the ones before, offsets of the joints, goal, heading.
            let kick = 3 * header.joints + 3 + 2 + KickState::<V>::new().fields().len();
            shard.without(terms, kick..kick + numbers, found.lanes)?;
        }
        if found.lanes != header.lanes {
            shard.sums = refold(&shard.sums, found.lanes, header.lanes);
            shard.groups = regroup(&shard.groups, found.lanes, header.lanes)?;
        }
        let pairs = self.failures.len();
        expect("failure counts", pairs, shard.failures.len())?;
        expect("failures of the sampler", pairs, shard.sampler.failures.len())?;
        expect("probabilities of the sampler", pairs, shard.sampler.probabilities.len())?;
        expect("groups", self.groups.len(), shard.groups.len())?;
        narrow("sums", self.sums.all_mut().collect(), &shard.sums)?;
        expect("reward terms", reward_names().len(), shard.metrics.reward_terms.len())?;
        expect("causes of an end", end_names().len(), shard.metrics.ends.len())?;
        (self.observations, self.sampler, self.failures) =
            (shard.observations, shard.sampler, shard.failures);
        if !shard.end_states.fit(self.config.joints()) {
            return Err("task snapshot: the end states are another robot's".into());
        }
        (self.end_states, self.curriculum) = (shard.end_states, shard.curriculum);
        self.metrics = shard.metrics;
        for index in 0..self.envs.len() {
            let environment = reader.value()?;
            self.restore_env(index, environment)?;
        }
        reader.end()?;
        for (group, numbers) in shard.groups.iter().enumerate() {
            narrow("numbers of a group", self.groups[group].fields(), numbers)?;
            self.sim.refresh(group);
            self.gather_reference(group);
        }
        Ok(())
    }

    fn restore_env(&mut self, index: usize, found: Environment) -> Result<(), String> {
        let env = &mut self.envs[index];
        expect("environment number", env.id, found.id)?;
        let facts = self.library.facts().get(found.motion);
        if facts.is_none() || found.frame == 0 {
            return Err(format!("task snapshot: motion {} has no frame {}", found.motion, found.frame));
        }
        let state = found.state;
        for joints in [&state.joint_pos, &state.joint_vel] {
            expect("joints of a state", self.config.joints(), joints.len())?;
        }
        (env.motion, env.frame) = (found.motion, found.frame);
        (env.hold, env.after_strike) = (found.hold, found.after_strike);
        self.set_anchoring(index, found.anchoring);
        let env = &mut self.envs[index];
        (env.step, env.push_in) = (found.step, found.push_in);
        env.reset_rng.seek(found.reset_rng);
        env.push_rng.seek(found.push_rng);
        env.start_rng.seek(found.start_rng);
        (env.ended, env.kick, env.forced) = (found.ended, found.kick, found.forced);
        env.params = found.params;
        let (group, lane) = (index / V::LANES, index % V::LANES);
        self.sim.set_params(group, lane, &self.envs[index].params);
        self.sim.reset_lane(group, lane, &state);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number n of environment e is 10 e + n.
    fn groups(envs: usize, lanes: usize) -> Vec<Vec<f64>> {
        let value = |env: usize, number: usize| (10 * env + number) as f64;
        let group = |first: usize| {
            (0..3).flat_map(|number| (first..first + lanes).map(move |env| value(env, number))).collect()
        };
        (0..envs).step_by(lanes).map(group).collect()
    }

    #[test]
    fn environments_keep_their_numbers_in_groups_of_other_lanes() {
        assert_eq!(groups(4, 2)[1], [20.0, 30.0, 21.0, 31.0, 22.0, 32.0]);
        for (found, own) in [(16, 8), (8, 16), (8, 1), (1, 8), (8, 8)] {
            assert_eq!(regroup(&groups(48, found), found, own), Ok(groups(48, own)), "{found} {own}");
        }
        assert_eq!(regroup(&[], 16, 8), Ok(vec![]));
    }

    #[test]
    fn a_snapshot_of_the_version_before_loses_the_numbers_that_are_gone() {
        let shard = |terms: Vec<f64>| Shard {
            observations: 0,
            sampler: SamplerState::uniform(1, 1),
            curriculum: BallCurriculum::default(),
            failures: vec![0.0],
            end_states: EndStates::default(),
            metrics: TaskMetrics { reward_terms: terms, ..TaskMetrics::default() },
            // Two lanes of three terms and one tracking error, and of four numbers of a group.
            sums: vec![1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 9.0, 9.5],
            groups: vec![vec![0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5]],
        };
        let mut before = shard(vec![1.0, 2.0, 3.0]);
        before.without(2, 1..3, 2).expect("has them");
        assert_eq!(before.metrics.reward_terms, [1.0]);
        assert_eq!(before.sums, [1.0, 1.5, 9.0, 9.5]);
        assert_eq!(before.groups, [[0.0, 0.5, 3.0, 3.5]]);
        for (mut short, numbers) in [(shard(vec![1.0]), 1..3), (shard(vec![1.0, 2.0, 3.0]), 3..5)] {
            assert!(short.without(2, numbers, 2).expect_err("short").contains("fewer numbers"));
        }
    }

    #[test]
    fn groups_that_cannot_be_whole_are_refused() {
        let error = regroup(&groups(24, 8), 8, 16).expect_err("half a group is left");
        assert_eq!(error, "task snapshot: environments beyond whole groups: expected 0, found 8");
        let mut uneven = groups(32, 16);
        uneven[1].pop();
        assert!(regroup(&uneven, 16, 8).is_err());
        assert!(regroup(&[vec![0.0; 17]], 16, 8).is_err());
    }

    #[test]
    fn a_running_sum_stays_what_it_is() {
        assert_eq!(refold(&[1.0, 2.0, 3.0, 4.0, 10.0, 20.0, 30.0, 40.0], 4, 2), [4.0, 6.0, 40.0, 60.0]);
        assert_eq!(refold(&[1.0, 2.0], 2, 4), [1.0, 2.0, 0.0, 0.0]);
    }
}
