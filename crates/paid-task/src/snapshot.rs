//! Exact save and restore of a shard: the numbers of the lanes widen to `f64` and come back exactly.

use paid_lanes::Real;
use paid_physics::{EnvParams, LaneState, Simulator};
use serde::{Deserialize, Serialize};

use crate::anchoring::Anchoring;
use crate::codec::{Reader, append, expect};
use crate::stance::EndStates;
use crate::task::EnvTask;
use crate::{BallCurriculum, EndCause, InitialState, KickEvent, SamplerState, Task, TaskMetrics};

/// First bytes of a snapshot; the last is the version.
const MAGIC: &[u8; 8] = b"paidtsk\x07";

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
            sums: widen(self.sums.terms.iter().chain(&self.sums.tracking)),
            groups: self.groups.iter().map(group).collect(),
        };
        let state = |index: usize| self.sim.save_lane(index / V::LANES, index % V::LANES);
        let environments =
            self.envs.iter().enumerate().map(|(index, env)| Environment::new(env, state(index)));
        let bytes = append(append(MAGIC.to_vec(), &self.header()), &shard);
        environments.fold(bytes, |bytes, environment| append(bytes, &environment))
    }

    pub(crate) fn restore_bytes(&mut self, bytes: &[u8]) -> Result<(), String> {
        let mut reader = Reader::new(bytes, MAGIC)?;
        let (header, found): (Header, Header) = (self.header(), reader.value()?);
        expect("environments", header.envs, found.envs)?;
        expect("lanes", header.lanes, found.lanes)?;
        expect("joints", header.joints, found.joints)?;
        expect("motions", header.motions, found.motions)?;
        expect("phase bins", header.bins, found.bins)?;
        expect("seed", header.seed, found.seed)?;
        let shard: Shard = reader.value()?;
        let pairs = self.failures.len();
        expect("failure counts", pairs, shard.failures.len())?;
        expect("failures of the sampler", pairs, shard.sampler.failures.len())?;
        expect("probabilities of the sampler", pairs, shard.sampler.probabilities.len())?;
        expect("groups", self.groups.len(), shard.groups.len())?;
        let sums = self.sums.terms.iter_mut().chain(&mut self.sums.tracking).collect();
        narrow("sums", sums, &shard.sums)?;
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
