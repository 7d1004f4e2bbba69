//! What all ranks collected in a horizon: which of its steps continue, and the pairs of frames of this rank's own.

use paid_lanes::rng::Rng;
use paid_learn::{Ranks, Transitions};

use crate::GROUP;
use crate::clips::Clips;

/// Draws for a pair that ends no episode, before a step goes without.
const TRIES: usize = 1000;

/// A step of an environment of a shard, among those of all ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    shard: usize,
    step: usize,
    env: usize,
}

/// The steps of all ranks' shards, those of the first ranks first.
#[derive(Debug)]
pub struct Horizon<'a> {
    /// This rank's shards.
    own: &'a [&'a Transitions],
    /// Number of the first of them among all.
    first: usize,
    /// Of every shard.
    ends: Vec<Ends>,
}

/// Where the episodes of a shard ended.
#[derive(Debug)]
struct Ends {
    envs: usize,
    steps: usize,
    /// `[steps, envs]`, zero where the episode continues.
    done: Vec<u8>,
}

impl<'a> Horizon<'a> {
    /// Exchanges with the other ranks where episodes ended.
    pub fn new(own: &'a [&'a Transitions], ranks: &dyn Ranks) -> Self {
        let mut sent = Vec::new();
        for shard in own {
            sent.extend([shard.envs(), shard.steps()].iter().flat_map(|size| (*size as u32).to_le_bytes()));
            (0..shard.steps()).for_each(|t| sent.extend_from_slice(shard.done(t)));
        }
        let all: Vec<Vec<Ends>> = ranks.gather(&sent).iter().map(|bytes| Ends::read(bytes)).collect();
        let first = all[..ranks.rank()].iter().map(Vec::len).sum();
        Self { own, first, ends: all.into_iter().flatten().collect() }
    }

    /// A random step that ends no episode; `None` if there is hardly any. The same on every rank.
    pub fn draw(&self, rng: &mut Rng) -> Option<Step> {
        if self.ends.is_empty() {
            return None;
        }
        (0..TRIES).find_map(|_| {
            let shard = rng.below(self.ends.len());
            let Ends { envs, steps, done } = &self.ends[shard];
            let (step, env) = (rng.below(*steps), rng.below(*envs));
            (done[step * envs + env] == 0).then_some(Step { shard, step, env })
        })
    }

    /// Writes the frames before and after a step, scaled; nothing if the step is another rank's.
    pub fn pair(&self, at: Step, clips: &Clips, out: &mut [f32]) {
        let own = at.shard.checked_sub(self.first).and_then(|shard| self.own.get(shard));
        let Some((shard, group)) = own.and_then(|shard| Some((shard, shard.group(GROUP)?))) else { return };
        let frames = [shard.before(group, at.step), shard.after(group, at.step)];
        for (half, frame) in out.chunks_exact_mut(clips.features()).zip(frames) {
            for (i, x) in half.iter_mut().enumerate() {
                *x = clips.scaled(i, frame.row(i)[at.env]);
            }
        }
    }
}

impl Ends {
    /// Every shard of a rank, from the bytes that it sent.
    fn read(mut bytes: &[u8]) -> Vec<Self> {
        let mut shards = Vec::new();
        while let Some((sizes, rest)) = bytes.split_at_checked(8) {
            let [envs, steps] = [0, 4].map(|at| {
                let word = core::array::from_fn(|i| sizes[at + i]);
                u32::from_le_bytes(word) as usize
            });
            let (done, rest) = rest.split_at(envs * steps);
            shards.push(Self { envs, steps, done: done.to_vec() });
            bytes = rest;
        }
        shards
    }
}
