//! Storage of what one shard of environments experienced in one horizon.

use core::ops::Range;

use crate::gae::{GaeConfig, GaeStep, advantage};
use paid_policy::matrix::{Mat, MatMut};

/// How a shard's environments are cut into blocks, and where a block's samples lie.
///
/// A *unit* is what minibatches are drawn from: one block at one step, or for recurrent networks one block over the whole horizon.
/// Its samples are contiguous columns, so that a unit goes through the networks as it is stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RolloutLayout {
    /// Environments of the shard.
    pub envs: usize,
    /// Steps.
    pub horizon: usize,
    /// Environments of each block.
    pub blocks: Vec<Range<usize>>,
    /// True if a unit spans the horizon.
    pub sequences: bool,
}

/// Where a block's samples of one step lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// First sample of the unit among all samples of the shard.
    pub unit: usize,
    /// Samples of the unit: the row stride of its matrices.
    pub stride: usize,
    /// First column within the unit.
    pub column: usize,
    /// Environments of the block.
    pub width: usize,
}

impl RolloutLayout {
    /// Cuts `envs` environments into nearly equal blocks of at most `block`, widths multiples of 16 where possible.
    pub fn new(envs: usize, horizon: usize, block: usize, sequences: bool) -> Self {
        let count = envs.div_ceil(block.max(1)).max(1);
        let even = envs.div_ceil(count);
        let width = if even >= 16 { even.next_multiple_of(16).min(block.max(16)) } else { even };
        let mut blocks = Vec::new();
        let mut first = 0;
        while first < envs {
            let end = (first + width).min(envs);
            blocks.push(first..end);
            first = end;
        }
        Self { envs, horizon, blocks, sequences }
    }

    /// Samples of a horizon.
    pub fn samples(&self) -> usize {
        self.envs * self.horizon
    }

    /// Where block `b` at step `t` lies.
    pub fn place(&self, t: usize, b: usize) -> Place {
        let Range { start, end } = self.blocks[b];
        let width = end - start;
        if self.sequences {
            Place { unit: start * self.horizon, stride: width * self.horizon, column: t * width, width }
        } else {
            Place { unit: t * self.envs + start, stride: width, column: 0, width }
        }
    }

    /// Number of units.
    pub fn units(&self) -> usize {
        if self.sequences { self.blocks.len() } else { self.blocks.len() * self.horizon }
    }

    /// The block of a unit and the place of its first step.
    pub fn unit(&self, unit: usize) -> (usize, Place) {
        let (t, b) =
            if self.sequences { (0, unit) } else { (unit / self.blocks.len(), unit % self.blocks.len()) };
        (b, self.place(t, b))
    }
}

/// How the shards of all ranks are cut into blocks, in their order; some of them are this rank's.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct World {
    /// Every shard's layout.
    pub layouts: Vec<RolloutLayout>,
    /// Number of this rank's first shard.
    pub first: usize,
}

impl World {
    /// Environments of the ranks before this one.
    pub fn first_env(&self) -> usize {
        self.layouts[..self.first].iter().map(|layout| layout.envs).sum()
    }

    /// All units: shard and unit of it.
    pub fn units(&self) -> Vec<(usize, usize)> {
        let shards = self.layouts.iter().enumerate();
        shards.flat_map(|(k, layout)| (0..layout.units()).map(move |unit| (k, unit))).collect()
    }

    /// Samples of some units.
    pub fn samples(&self, units: &[(usize, usize)]) -> usize {
        units.iter().map(|&(k, unit)| self.layouts[k].unit(unit).1.stride).sum()
    }
}

/// Samples of a shard, feature-major within a unit (see [`RolloutLayout`]).
#[derive(Clone, Debug)]
pub struct Rollout {
    /// Where things lie.
    pub layout: RolloutLayout,
    /// Features of the policy's observation, the critic's, and actions.
    pub dims: [usize; 3],
    /// Normalized policy observations.
    pub policy_obs: Vec<f32>,
    /// Normalized critic observations.
    pub critic_obs: Vec<f32>,
    /// Actions taken.
    pub action: Vec<f32>,
    /// Means of the policy.
    pub mean: Vec<f32>,
    /// Mean actions of the teacher, while there is one; else empty.
    pub taught: Vec<f32>,
    /// Log probability of the action.
    pub log_prob: Vec<f32>,
    /// Bit 0: terminated, bit 1: truncated.
    pub done: Vec<u8>,
    /// 0 where the step is the first of an episode, else 1: factor on the recurrent state before it.
    pub mask: Vec<f32>,
    /// Advantages, summed over the streams.
    pub advantage: Vec<f32>,
    /// The task's reward and, with a second critic, the learned one.
    pub streams: Vec<ValueStream>,
}

/// A reward and what its critic made of it.
#[derive(Clone, Debug)]
pub struct ValueStream {
    /// Value of the state before the step.
    pub value: Vec<f32>,
    /// Reward of the step.
    pub reward: Vec<f32>,
    /// Returns, the critic's targets: advantage plus value.
    pub returns: Vec<f32>,
    /// Value after the last step, by environment.
    pub last_value: Vec<f32>,
}

impl ValueStream {
    fn new(layout: &RolloutLayout) -> Self {
        let zeros = vec![0.0; layout.samples()];
        Self {
            value: zeros.clone(),
            reward: zeros.clone(),
            returns: zeros,
            last_value: vec![0.0; layout.envs],
        }
    }
}

/// The block of a matrix of `rows` features at a place.
pub fn block_mut(data: &mut [f32], rows: usize, place: Place) -> MatMut<'_, f32> {
    let Place { unit, stride, column, width } = place;
    let first = rows * unit + column;
    let end = rows * (unit + stride);
    MatMut::new(&mut data[first..end], rows, width, stride)
}

/// All samples of the unit at a place.
pub fn unit_ref(data: &[f32], rows: usize, place: Place) -> Mat<'_, f32> {
    Mat::new(&data[rows * place.unit..], rows, place.stride, place.stride)
}

impl Place {
    /// The block's samples in vectors of one number per sample.
    pub fn range(&self) -> Range<usize> {
        self.unit + self.column..self.unit + self.column + self.width
    }

    /// The unit's samples in vectors of one number per sample.
    pub fn unit_range(&self) -> Range<usize> {
        self.unit..self.unit + self.stride
    }
}

impl Rollout {
    /// Space for a horizon; `dims` as in [`Rollout::dims`], one stream per critic.
    pub fn new(layout: RolloutLayout, dims: [usize; 3], streams: usize) -> Self {
        let [policy_obs, critic_obs, actions] = dims;
        let n = layout.samples();
        Self {
            dims,
            policy_obs: vec![0.0; policy_obs * n],
            critic_obs: vec![0.0; critic_obs * n],
            action: vec![0.0; actions * n],
            mean: vec![0.0; actions * n],
            taught: Vec::new(),
            log_prob: vec![0.0; n],
            done: vec![0; n],
            mask: vec![1.0; n],
            advantage: vec![0.0; n],
            streams: (0..streams).map(|_| ValueStream::new(&layout)).collect(),
            layout,
        }
    }

    /// Fills the returns of every stream and the advantages, the sum of the streams' with `weights`; returns sum and sum of
    /// squares of the advantages.
    pub fn estimate_advantages(&mut self, config: GaeConfig, weights: &[f32]) -> (f64, f64) {
        let (mut sum, mut squares) = (0.0, 0.0);
        let last = self.streams.len() - 1;
        for (k, (stream, weight)) in self.streams.iter_mut().zip(weights).enumerate() {
            for b in 0..self.layout.blocks.len() {
                let first = self.layout.blocks[b].start;
                for i in 0..self.layout.blocks[b].len() {
                    let mut next_value = stream.last_value[first + i];
                    let mut next = 0.0;
                    for t in (0..self.layout.horizon).rev() {
                        let s = self.layout.place(t, b).range().start + i;
                        let step = GaeStep {
                            reward: stream.reward[s],
                            value: stream.value[s],
                            next_value,
                            terminated: self.done[s] & 1 != 0,
                            truncated: self.done[s] & 2 != 0,
                        };
                        next = advantage(config, step, next);
                        next_value = step.value;
                        stream.returns[s] = next + step.value;
                        let share = weight * next;
                        let total = if k == 0 { share } else { self.advantage[s] + share };
                        self.advantage[s] = total;
                        if k == last {
                            sum += f64::from(total);
                            squares += f64::from(total) * f64::from(total);
                        }
                    }
                }
            }
        }
        (sum, squares)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_cover_every_sample_once() {
        for sequences in [false, true] {
            for envs in [1, 16, 40, 600] {
                let layout = RolloutLayout::new(envs, 5, 256, sequences);
                let mut seen = vec![0; layout.samples()];
                for t in 0..5 {
                    for b in 0..layout.blocks.len() {
                        for s in layout.place(t, b).range() {
                            seen[s] += 1;
                        }
                    }
                }
                assert!(seen.iter().all(|&n| n == 1), "{envs} environments, sequences {sequences}");
                let samples: usize = (0..layout.units()).map(|u| layout.unit(u).1.stride).sum();
                assert_eq!(samples, layout.samples());
            }
        }
    }
}
