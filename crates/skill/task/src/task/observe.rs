//! What the environments show: observations, and where ball and goal seem to be.

use paid_lanes::{MAX_LANES, Real};
use paid_physics::Simulator;
use paid_policy::env::{STYLE_GROUP, TEACHER_GROUP};

use super::{BLOCK_GROUPS, Task};
use crate::kernels::delay::Remember;
use crate::kernels::observe::{Draw, Observe};
use crate::scene::eyes::Look;

impl<V: Real, S: Simulator<V>> Task<V, S> {
    /// Writes observations, see [`paid_policy::VecEnv::observe`].
    pub(crate) fn observe_all(&mut self, out: &mut [&mut [f32]]) {
        let envs = self.envs.len();
        let sizes: Vec<usize> = self.groups_shown().into_iter().map(|(_, size)| size).collect();
        assert!(out.len() <= sizes.len(), "at most {} observation groups, found {}", sizes.len(), out.len());
        for (k, (out, size)) in out.iter().zip(&sizes).enumerate() {
            assert_eq!(out.len(), size * envs, "observation group {k}");
        }
        let disturbed = self.disturbed();
        if !disturbed {
            self.noise.fill(V::zero());
        }
        // A group's rows are 32 or 64 bytes, `envs` numbers apart: written through a small matrix of a few groups, so that
        // the large one receives longer runs and its rows do not fight for the same cache sets.
        let width = BLOCK_GROUPS * V::LANES;
        for block in 0..self.groups.len().div_ceil(BLOCK_GROUPS) {
            let first = block * BLOCK_GROUPS;
            let groups = BLOCK_GROUPS.min(self.groups.len() - first);
            for group in first..first + groups {
                self.observe_group(group, disturbed, (group - first) * V::LANES, width);
            }
            let used = groups * V::LANES;
            let rows = [&self.policy_rows, &self.critic_rows, &self.style_rows, &self.teacher_rows];
            for (out, rows) in out.iter_mut().zip(rows.into_iter().filter(|rows| !rows.is_empty())) {
                for (to, from) in out.chunks_exact_mut(envs).zip(rows.chunks_exact(width)) {
                    to[first * V::LANES..][..used].copy_from_slice(&from[..used]);
                }
            }
        }
        self.observations += 1;
    }

    /// Names and sizes of the observation groups: the policy's, the critic's, and those of a discriminator and a teacher if there are such.
    pub(crate) fn groups_shown(&self) -> Vec<(&'static str, usize)> {
        let (layout, lists) = (&self.config.layout, &self.config.observations);
        let mut groups = vec![("policy", layout.policy_dim()), ("critic", layout.critic_dim())];
        let further = [(STYLE_GROUP, lists.style_dim), (TEACHER_GROUP, lists.teacher_dim)];
        groups.extend(further.into_iter().filter(|(_, size)| *size > 0));
        groups
    }

    /// Numbers of a group's environments, one per lane.
    fn ids(&self, group: usize) -> [u32; MAX_LANES] {
        let mut ids = [0; MAX_LANES];
        for lane in 0..V::LANES {
            ids[lane] = self.envs[group * V::LANES + lane].id;
        }
        ids
    }

    fn observe_group(&mut self, group: usize, disturbed: bool, first: usize, stride: usize) {
        let ids = self.ids(group);
        V::run(Observe {
            config: &self.config,
            state: self.sim.state(group),
            group: &mut self.groups[group],
            robot: &mut self.robot,
            draw: Draw {
                envs: if disturbed { &ids[..V::LANES] } else { &[] },
                seed: self.seed,
                count: self.observations,
                values: &mut self.noise,
            },
            policy: &mut self.policy_rows,
            critic: &mut self.critic_rows,
            style: &mut self.style_rows,
            teacher: &mut self.teacher_rows,
            stride,
            first,
        });
    }

    /// Remembers the sensed terms of the lanes whose bit is set, where the preset has delays.
    pub(super) fn remember(&mut self, group: usize, lanes: u32) {
        if self.groups[group].delays.is_none() {
            return;
        }
        V::run(Remember {
            config: &self.config,
            state: self.sim.state(group),
            group: &mut self.groups[group],
            robot: &mut self.robot,
            lanes,
        });
    }

    /// A control step of the eyes, where the policy's knowledge is perceived.
    pub(super) fn look(&mut self, group: usize) {
        let ids = self.ids(group);
        let task = &mut self.groups[group];
        let Some(eyes) = &mut task.eyes else { return };
        V::run(Look {
            config: &self.config,
            state: self.sim.state(group),
            eyes,
            to_strike_s: task.to_strike_s,
            envs: &ids[..V::LANES],
            seed: self.seed,
            count: self.observations,
        });
    }
}
