//! A policy learns the way of a known motion from the discriminator alone.
#![expect(clippy::vec_box, reason = "the learner takes boxed environments")]

use std::sync::Arc;

use paid_amp::{AmpConfig, Clips, Formulation, GROUP, StyleReward};
use paid_lanes::rng::Rng;
use paid_learn::ranks::ThreadRanks;
use paid_learn::{
    Alone, LearnConfig, Learner, NetworkConfig, ObservationGroup, PpoConfig, Ranks, RewardRole, StepBuffers,
    VecEnv,
};

/// Points in a plane; the action is their velocity, 0.1 s a step, and nothing is paid. The policy sees the place, the discriminator the
/// velocity too.
struct Points {
    rng: Rng,
    /// Place, velocity, steps.
    state: Vec<[f32; 5]>,
}

impl Points {
    fn new(envs: usize, seed: u64) -> Self {
        let mut points = Self { rng: Rng::new(seed, 0, 1), state: vec![[0.0; 5]; envs] };
        for e in 0..envs {
            points.reset(e);
            points.state[e][4] = (e % 40) as f32;
        }
        points
    }

    fn reset(&mut self, e: usize) {
        let (angle, radius) = (self.rng.uniform(0.0, core::f64::consts::TAU), self.rng.uniform(0.8, 1.2));
        let [x, y] = [radius * angle.cos(), radius * angle.sin()].map(|x| x as f32);
        self.state[e] = [x, y, 0.0, 0.0, 0.0];
    }
}

impl VecEnv for Points {
    fn num_envs(&self) -> usize {
        self.state.len()
    }
    fn observation_groups(&self) -> Vec<ObservationGroup> {
        let mut groups = ObservationGroup::policy_and_critic(2, 2);
        groups.push(ObservationGroup::new(GROUP, 4));
        groups
    }
    fn action_dim(&self) -> usize {
        2
    }
    fn observe(&mut self, groups: &mut [&mut [f32]]) {
        let n = self.state.len();
        for group in groups {
            for (k, row) in group.chunks_exact_mut(n).enumerate() {
                for (x, state) in row.iter_mut().zip(&self.state) {
                    *x = state[k];
                }
            }
        }
    }
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
        let n = self.state.len();
        out.reward.fill(0.0);
        for e in 0..n {
            let [x, y, u, v, t] = &mut self.state[e];
            (*u, *v) = (actions[e].clamp(-3.0, 3.0), actions[n + e].clamp(-3.0, 3.0));
            *x += 0.1 * *u;
            *y += 0.1 * *v;
            *t += 1.0;
            out.terminated[e] = u8::from(x.hypot(*y) > 2.0);
            out.truncated[e] = u8::from(*t >= 40.0) * (1 - out.terminated[e]);
            if out.terminated[e] + out.truncated[e] > 0 {
                self.reset(e);
            }
        }
    }
    fn save(&self) -> Vec<u8> {
        let numbers = self.state.iter().flatten().flat_map(|x| x.to_le_bytes());
        self.rng.position().to_le_bytes().into_iter().chain(numbers).collect()
    }
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.rng.seek(u64::from_le_bytes(core::array::from_fn(|i| bytes[i])));
        for (k, word) in bytes[8..].chunks_exact(4).enumerate() {
            self.state[k / 5][k % 5] = f32::from_le_bytes(core::array::from_fn(|i| word[i]));
        }
        Ok(())
    }
}

/// The unit circle at 1 rad/s, counterclockwise.
fn circle() -> Arc<Clips> {
    let frame = |t: i32| {
        let (y, x) = (0.1 * t as f32).sin_cos();
        [x, y, -y, x]
    };
    Arc::new(Clips::new(4, &[(0..126).flat_map(frame).collect()]).expect("frames"))
}

fn learner(formulation: Formulation) -> Learner {
    learner_of(circle(), formulation)
}

fn learner_of(clips: Arc<Clips>, formulation: Formulation) -> Learner {
    let network = NetworkConfig { hidden: vec![32, 32], ..NetworkConfig::default() };
    let ppo = PpoConfig {
        minibatches: 4,
        epochs: 4,
        block: 32,
        entropy: 0.0,
        initial_std: 0.5,
        ..PpoConfig::default()
    };
    let config = LearnConfig { actor: network.clone(), critic: network, ppo, ..LearnConfig::default() };
    let amp = AmpConfig {
        formulation,
        hidden: vec![64, 32],
        learning_rate: 1e-3,
        gradient_penalty: 1.0,
        batch: 256,
        replay: 20_000,
        ..AmpConfig::default()
    };
    let style = StyleReward::new(clips, &amp, 1).expect("valid");
    let role = RewardRole::Mixed { task: 0.0, learned: 0.1 };
    Learner::new(2, 2, 2, &config, 3)
        .expect("valid")
        .with_learned_reward(Box::new(style), role)
        .expect("fits")
}

fn shards(count: usize) -> Vec<Box<Points>> {
    (0..count).map(|k| Box::new(Points::new(64, k as u64))).collect()
}

/// Mean angular speed `[rad/s]` and mean distance of the radius from 1 over the last horizon.
fn way(learner: &Learner) -> [f64; 2] {
    let (mut turn, mut off, mut count) = (0.0, 0.0, 0.0);
    for shard in learner.shards() {
        let transitions = &shard.transitions;
        let group = transitions.group(GROUP).expect("the group");
        for t in 0..transitions.steps() {
            let (before, after) = (transitions.before(group, t), transitions.after(group, t));
            for (e, done) in transitions.done(t).iter().enumerate() {
                if *done == 0 {
                    let [x, y] = [0, 1].map(|i| f64::from(before.row(i)[e]));
                    let [u, v] = [0, 1].map(|i| f64::from(after.row(i)[e]));
                    turn += (x * v - y * u).atan2(x * u + y * v) / 0.1;
                    off += (u.hypot(v) - 1.0).abs();
                    count += 1.0;
                }
            }
        }
    }
    [turn / count, off / count]
}

#[test]
fn a_policy_learns_to_circle_from_the_style_reward_alone() {
    for formulation in [Formulation::LeastSquares, Formulation::Wasserstein] {
        let (mut learner, mut envs) = (learner(formulation), shards(2));
        learner.iterate(&mut envs, 2).expect("iterates");
        let before = way(&learner);
        assert!(before[0].abs() < 0.3, "nothing circles yet: {before:?}");
        for _ in 0..130 {
            learner.iterate(&mut envs, 2).expect("iterates");
        }
        let after = way(&learner);
        assert!(
            (after[0] - 1.0).abs() < 0.2 && after[1] < 0.25,
            "{formulation:?}: {before:?} became {after:?}"
        );
    }
}

#[test]
fn threads_and_a_resume_change_no_weight() {
    let run = |threads: usize| {
        let (mut learner, mut envs) = (learner(Formulation::LeastSquares), shards(3));
        for _ in 0..3 {
            learner.iterate(&mut envs, threads).expect("iterates");
        }
        (learner.learned_reward().expect("a reward").save(), learner.actor().params.clone())
    };
    let one = run(1);
    assert_eq!(one, run(4));

    let mut fresh =
        StyleReward::new(circle(), &AmpConfig { hidden: vec![64, 32], ..AmpConfig::default() }, 9)
            .expect("valid");
    paid_learn::LearnedReward::restore(&mut fresh, &one.0).expect("fits");
    assert_eq!(paid_learn::LearnedReward::save(&fresh), one.0);
    assert!(paid_learn::LearnedReward::restore(&mut fresh, &one.0[..one.0.len() - 4]).is_err());
    let mut damaged = one.0.clone();
    damaged[24..32].fill(0xFF);
    let error = paid_learn::LearnedReward::restore(&mut fresh, &damaged).expect_err("too many");
    assert!(error.contains(&format!("{} of earlier pairs", u64::MAX)), "{error}");
    assert_eq!(paid_learn::LearnedReward::save(&fresh), one.0, "a refused state changes nothing");
}

#[test]
fn ranks_that_share_the_shards_learn_what_one_process_with_all_of_them_learns() {
    let course = |ranks: Arc<dyn Ranks>, iterations: usize| {
        let (each, rank) = (4 / ranks.count(), ranks.rank());
        let mut envs: Vec<_> = shards(4).into_iter().skip(each * rank).take(each).collect();
        let mut learner = learner(Formulation::Wasserstein).with_ranks(ranks);
        for _ in 0..iterations {
            learner.iterate(&mut envs, 1).expect("iterates");
        }
        let style = learner.learned_reward().expect("a reward");
        (style.save(), style.figures(), learner.actor().params.clone())
    };
    let on_each = |count: usize, iterations: usize| -> Vec<_> {
        std::thread::scope(|scope| {
            let start = |ranks: ThreadRanks| {
                scope.spawn(move || course(Arc::new(ranks) as Arc<dyn Ranks>, iterations))
            };
            let threads: Vec<_> = ThreadRanks::of(count).into_iter().map(start).collect();
            threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        })
    };
    let params = paid_amp::Perceptron::new(8, &[64, 32]).params();
    let (alone, figures, _) = course(Arc::new(Alone), 1);
    for count in [2, 4] {
        let (found, sums, _) = &on_each(count, 1)[0];
        // Four counts, the policy's usual score, then weights and two moments of each, then the replay.
        let (weights, replay) = (48 + 4 * params, 48 + 12 * params);
        assert_eq!(found[..32], alone[..32], "as many steps and draws");
        assert!(replay < alone.len() && found[replay..] == alone[replay..], "the same pairs of frames");
        for (a, b) in found[48..weights].chunks_exact(4).zip(alone[48..weights].chunks_exact(4)) {
            let [a, b] = [a, b].map(|word| f32::from_le_bytes(core::array::from_fn(|i| word[i])));
            assert!((a - b).abs() < 2e-5, "{a} {b}");
        }
        for ((name, a), (_, b)) in sums.iter().zip(&figures) {
            assert!((a - b).abs() < 1e-4 * (1.0 + b.abs()), "{name}: {a} {b}");
        }
        let ranks = on_each(count, 3);
        assert!(ranks.iter().all(|rank| *rank == ranks[0]), "every rank has the same weights");
    }
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let bad = AmpConfig { learning_rate: 0.0, ..AmpConfig::default() };
    let error = StyleReward::new(circle(), &bad, 1).expect_err("refused").to_string();
    assert_eq!(error, "amp.learning_rate: expected above zero, found 0");
    let bad = AmpConfig { hidden: vec![], ..AmpConfig::default() };
    let error = StyleReward::new(circle(), &bad, 1).expect_err("refused").to_string();
    assert_eq!(error, "amp.hidden: expected one or more widths above zero, found []");
}

/// Clips that are far from the policy, as those of a robot with many joints are: the raw scores are where tanh is flat.
#[test]
fn wasserstein_still_rewards_by_the_distance_when_the_policy_is_far_off() {
    let far = |t: i32| (0..4).map(move |i| 30.0 + 6.0 * (0.1 * (t + 9 * i) as f32).sin());
    let clips = Arc::new(Clips::new(4, &[(0..126).flat_map(far).collect()]).expect("frames"));
    let mut learner = learner_of(clips, Formulation::Wasserstein);
    let mut envs = shards(2);
    for _ in 0..60 {
        learner.iterate(&mut envs, 2).expect("iterates");
    }
    let style = learner.learned_reward().expect("a reward");
    let figures = style.figures();
    let of = |name: &str| figures.iter().find(|(n, _)| n == name).expect(name).1;
    // tanh(0.4 x -20) is -1 in single precision.
    assert!(of("score_clips") - of("score_policy") > 20.0 && of("score_policy") < -20.0, "{figures:?}");
    let transitions = &learner.shards()[0].transitions;
    let mut reward = vec![0.0; transitions.envs() * transitions.steps()];
    style.reward(transitions, &mut reward);
    let paid: Vec<f32> = reward.into_iter().filter(|r| *r != 0.0).collect();
    let mean = paid.iter().sum::<f32>() / paid.len() as f32;
    let deviation = (paid.iter().map(|r| (r - mean).powi(2)).sum::<f32>() / paid.len() as f32).sqrt();
    assert!((mean - 1.0).abs() < 0.3 && deviation > 0.1, "{mean} {deviation}");
}
