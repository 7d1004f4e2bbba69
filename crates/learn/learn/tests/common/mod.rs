//! Small known problems as environments.
#![allow(missing_docs)]

use paid_lanes::rng::Rng;
use paid_learn::{ObservationGroup, StepBuffers, VecEnv};

/// A point mass on a line, pushed by the action: reward `1 - x^2 - 0.1 v^2 - 0.01 a^2`, 0.1 s a step, cut after 50.
/// Policy and critic see position and velocity; the critic sees the step number too.
pub struct PointMass {
    rng: Rng,
    state: Vec<[f64; 3]>,
}

impl PointMass {
    pub fn new(envs: usize, seed: u64) -> Self {
        let mut env = Self { rng: Rng::new(seed, 0, 7), state: vec![[0.0; 3]; envs] };
        for e in 0..envs {
            env.reset(e);
            env.state[e][2] = (e % 50) as f64;
        }
        env
    }

    fn reset(&mut self, e: usize) {
        self.state[e] = [self.rng.uniform(-1.0, 1.0), self.rng.uniform(-1.0, 1.0), 0.0];
    }
}

impl VecEnv for PointMass {
    fn num_envs(&self) -> usize {
        self.state.len()
    }
    fn observation_groups(&self) -> Vec<ObservationGroup> {
        ObservationGroup::policy_and_critic(2, 3)
    }
    fn action_dim(&self) -> usize {
        1
    }
    fn observe(&mut self, groups: &mut [&mut [f32]]) {
        let n = self.state.len();
        for (group, size) in groups.iter_mut().zip([2, 3]) {
            for (e, state) in self.state.iter().enumerate() {
                for k in 0..size {
                    group[k * n + e] = state[k] as f32;
                }
            }
        }
    }
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
        for e in 0..self.state.len() {
            let a = f64::from(actions[e]).clamp(-5.0, 5.0);
            let [x, v, t] = &mut self.state[e];
            *v += 0.1 * a;
            *x += 0.1 * *v;
            *t += 1.0;
            out.reward[e] = (1.0 - *x * *x - 0.1 * *v * *v - 0.01 * a * a) as f32;
            out.terminated[e] = u8::from(x.abs() > 3.0);
            out.truncated[e] = u8::from(*t >= 50.0);
            if out.terminated[e] + out.truncated[e] > 0 {
                self.reset(e);
            }
        }
    }
    fn save(&self) -> Vec<u8> {
        let mut bytes = self.rng.position().to_le_bytes().to_vec();
        for value in self.state.iter().flatten() {
            bytes.extend(value.to_le_bytes());
        }
        bytes
    }
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        if bytes.len() != 8 + 24 * self.state.len() {
            return Err(format!("{} bytes do not fit", bytes.len()));
        }
        let word = |k: usize| -> [u8; 8] { core::array::from_fn(|i| bytes[8 * k + i]) };
        self.rng.seek(u64::from_le_bytes(word(0)));
        for e in 0..self.state.len() {
            self.state[e] = core::array::from_fn(|k| f64::from_le_bytes(word(1 + 3 * e + k)));
        }
        Ok(())
    }
}

/// A sign is shown at the first step of an episode of six and must be played back at all others: reward `1 - (a - sign)^2`.
/// Without memory the best mean reward is 0 (action 0); with it, 1 minus the variance of the actions.
pub struct Recall {
    rng: Rng,
    state: Vec<(f32, u32)>,
}

impl Recall {
    pub const STEPS: u32 = 6;

    pub fn new(envs: usize, seed: u64) -> Self {
        let mut env = Self { rng: Rng::new(seed, 0, 8), state: vec![(1.0, 0); envs] };
        for e in 0..envs {
            env.reset(e);
        }
        env
    }

    fn reset(&mut self, e: usize) {
        self.state[e] = (if self.rng.below(2) == 0 { -1.0 } else { 1.0 }, 0);
    }
}

impl VecEnv for Recall {
    fn num_envs(&self) -> usize {
        self.state.len()
    }
    fn observation_groups(&self) -> Vec<ObservationGroup> {
        ObservationGroup::policy_and_critic(2, 2)
    }
    fn action_dim(&self) -> usize {
        1
    }
    fn observe(&mut self, groups: &mut [&mut [f32]]) {
        let n = self.state.len();
        for group in groups {
            for (e, &(sign, t)) in self.state.iter().enumerate() {
                group[e] = if t == 0 { sign } else { 0.0 };
                group[n + e] = if t == 0 { 1.0 } else { 0.0 };
            }
        }
    }
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
        for e in 0..self.state.len() {
            let (sign, t) = self.state[e];
            out.reward[e] = if t == 0 { 0.0 } else { 1.0 - (actions[e] - sign).clamp(-3.0, 3.0).powi(2) };
            self.state[e].1 += 1;
            let ended = self.state[e].1 >= Self::STEPS;
            out.terminated[e] = u8::from(ended);
            out.truncated[e] = 0;
            if ended {
                self.reset(e);
            }
        }
    }
    fn save(&self) -> Vec<u8> {
        let mut bytes = self.rng.position().to_le_bytes().to_vec();
        for (sign, t) in &self.state {
            bytes.extend([u8::from(*sign > 0.0), *t as u8]);
        }
        bytes
    }
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        if bytes.len() != 8 + 2 * self.state.len() {
            return Err(format!("{} bytes do not fit", bytes.len()));
        }
        self.rng.seek(u64::from_le_bytes(core::array::from_fn(|i| bytes[i])));
        for (e, pair) in bytes[8..].chunks(2).enumerate() {
            self.state[e] = (if pair[0] == 1 { 1.0 } else { -1.0 }, u32::from(pair[1]));
        }
        Ok(())
    }
}

/// [`Recall`] with a critic that sees the sign at every step, as its third number.
pub struct WithSign(pub Recall);

impl VecEnv for WithSign {
    fn num_envs(&self) -> usize {
        self.0.num_envs()
    }
    fn observation_groups(&self) -> Vec<ObservationGroup> {
        ObservationGroup::policy_and_critic(2, 3)
    }
    fn action_dim(&self) -> usize {
        self.0.action_dim()
    }
    fn observe(&mut self, groups: &mut [&mut [f32]]) {
        let [policy, critic] = groups else { return };
        let (known, sign) = critic.split_at_mut(2 * self.0.num_envs());
        for (out, (of, _)) in sign.iter_mut().zip(&self.0.state) {
            *out = *of;
        }
        self.0.observe(&mut [&mut **policy, known]);
    }
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
        self.0.step(actions, out);
    }
    fn save(&self) -> Vec<u8> {
        self.0.save()
    }
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.0.restore(bytes)
    }
}

/// [`PointMass`] with a further observation group of this name: position and velocity.
pub struct WithGroup(pub PointMass, pub &'static str);

impl VecEnv for WithGroup {
    fn num_envs(&self) -> usize {
        self.0.num_envs()
    }
    fn observation_groups(&self) -> Vec<ObservationGroup> {
        let mut groups = self.0.observation_groups();
        groups.push(ObservationGroup::new(self.1, 2));
        groups
    }
    fn action_dim(&self) -> usize {
        self.0.action_dim()
    }
    fn observe(&mut self, groups: &mut [&mut [f32]]) {
        let (known, further) = groups.split_at_mut(2);
        self.0.observe(known);
        for group in further {
            group.copy_from_slice(known[0]);
        }
    }
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
        self.0.step(actions, out);
    }
    fn save(&self) -> Vec<u8> {
        self.0.save()
    }
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.0.restore(bytes)
    }
}
