//! PPO on shards of environments: collect a horizon, update, repeat.

mod collect;

use std::sync::Arc;
use std::time::Instant;

use paid_lanes::rng::Rng;

use crate::config::{ConfigError, LearnConfig, PpoConfig};
use crate::gaussian::entropy;
use crate::learned_reward::{LearnedReward, RewardRole, RewardStream};
use crate::model::Model;
use crate::net::{GateStats, TrainWorkspace, gate_stats};
use crate::operands::Operands;
use crate::ranks::{Alone, Ranks};
use crate::rollout::World;
use crate::shard::Shard;
use crate::stats::{IterationStats, UpdateStats};
use crate::teacher::Teacher;
use crate::transitions::Transitions;
use crate::update::{Gradients, Horizon, Networks, Schedule, Worker, sequence, update};
use paid_policy::Policy;
use paid_policy::normalizer::Normalizer;
use paid_policy::{Mirrors, VecEnv};

/// Streams of the random number generator.
const INIT_STREAM: u32 = 0x696E_6974;
const SHUFFLE_STREAM: u32 = 0x7368_7566;

/// Actor, critic, normalizers, optimizer and the shards' carried states.
///
/// Same seed and same shards (number and sizes, in order) give the same weights bit for bit, whatever the thread count.
#[derive(Clone, Debug)]
pub struct Learner {
    pub(crate) config: LearnConfig,
    /// The largest standard deviation now.
    std_limit: f64,
    pub(crate) seed: u64,
    pub(crate) actor: Model,
    /// The task's critic, then that of the learned reward if it has its own.
    pub(crate) critics: Vec<Model>,
    pub(crate) learned: Option<RewardStream>,
    /// A policy to imitate, and the weight of that now.
    teacher: Option<(Teacher, f64)>,
    pub(crate) policy_normalizer: Normalizer,
    pub(crate) critic_normalizer: Normalizer,
    pub(crate) schedule: Schedule,
    pub(crate) iteration: u64,
    /// Control steps collected in each environment.
    pub(crate) env_steps: u64,
    pub(crate) shards: Vec<Shard>,
    /// The processes that train together.
    pub(crate) ranks: Arc<dyn Ranks>,
    /// All shards of all ranks.
    pub(crate) world: World,
    /// How observations and actions read in a mirrored world, and the same for what the last horizon's observations are.
    mirrors: Option<Mirrors>,
    collected: Option<Mirrors>,
    /// Sum, sum of squares and number of the last horizon's advantages over all shards.
    advantages: [f64; 3],
    workers: Vec<Worker>,
    gradients: Gradients,
    operands: Operands,
}

/// Environments that a learner cannot work with.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("shard {shard}: expected {expected}, found {found}")]
pub struct ShardError {
    /// Number of the shard.
    pub shard: usize,
    /// What the learner was made for.
    pub expected: String,
    /// What the shard has.
    pub found: String,
}

impl Learner {
    /// A learner with fresh weights for observations of `policy_obs` and `critic_obs` features and `actions` actions.
    ///
    /// # Errors
    /// The first value of the configuration that is out of range.
    pub fn new(
        policy_obs: usize,
        critic_obs: usize,
        actions: usize,
        config: &LearnConfig,
        seed: u64,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        config.check_for(policy_obs, critic_obs)?;
        let std = Some(config.ppo.initial_std);
        let actor = Model::new(policy_obs, actions, &config.actor, std, &mut Rng::new(seed, 0, INIT_STREAM));
        let critic = Model::new(critic_obs, 1, &config.critic, None, &mut Rng::new(seed, 1, INIT_STREAM));
        let schedule = fresh_schedule(config, seed);
        Ok(Self {
            config: config.clone(),
            std_limit: config.ppo.max_std,
            seed,
            actor,
            critics: vec![critic],
            learned: None,
            teacher: None,
            policy_normalizer: Normalizer::new(policy_obs),
            critic_normalizer: Normalizer::new(critic_obs),
            schedule,
            iteration: 0,
            env_steps: 0,
            shards: Vec::new(),
            ranks: Arc::new(Alone),
            world: World::default(),
            mirrors: None,
            collected: None,
            advantages: [0.0; 3],
            workers: Vec::new(),
            gradients: Gradients::default(),
            operands: Operands::new(config.precision.kernel()),
        })
    }

    /// The same learner as one of several processes, each with shards of its own: the first ranks have the first shards. All of them must
    /// have been made alike.
    #[must_use]
    pub fn with_ranks(mut self, ranks: Arc<dyn Ranks>) -> Self {
        self.ranks = ranks;
        self.shards.clear();
        self
    }

    /// The same learner with a reward that it computes itself. The environments must have the observation groups that the reward
    /// reads.
    ///
    /// # Errors
    /// If it has one already, a factor or weight is not finite, or the second critic's configuration is out of range.
    pub fn with_learned_reward(
        mut self,
        reward: Box<dyn LearnedReward>,
        role: RewardRole,
    ) -> Result<Self, ConfigError> {
        let fail = |key: &str, expected, found| Err(ConfigError { key: key.to_owned(), expected, found });
        if let Some(stream) = &self.learned {
            return fail("learned_reward", "none yet", stream.reward.name().to_owned());
        }
        let (RewardRole::Mixed { task, learned } | RewardRole::OwnCritic { task, learned, .. }) = role;
        if !(task.is_finite() && learned.is_finite()) {
            return fail("learned_reward.role", "finite factors", format!("{task} and {learned}"));
        }
        if let RewardRole::OwnCritic { critic, .. } = &role {
            // The configuration's check is the critic's.
            let features = self.critics[0].net.input;
            let config = LearnConfig { critic: critic.clone(), ..self.config.clone() };
            config.check()?;
            config.check_for(self.actor.net.input, features)?;
            let mut rng = Rng::new(self.seed, 2, INIT_STREAM);
            self.critics.push(Model::new(features, 1, critic, None, &mut rng));
        }
        self.learned = Some(RewardStream { reward, role });
        self.shards.clear();
        Ok(self)
    }

    /// The same learner with a policy to imitate. The environments must have its observation group ([`Teacher`]).
    ///
    /// # Errors
    /// If it takes other actions.
    pub fn with_teacher(mut self, teacher: Teacher) -> Result<Self, ConfigError> {
        if teacher.actions() != self.actor.net.output {
            let found = format!("{} for {}", teacher.actions(), self.actor.net.output);
            return Err(ConfigError { key: "teacher".to_owned(), expected: "as many actions", found });
        }
        let weight = teacher.weight(0.0);
        self.teacher = Some((teacher, weight));
        Ok(self)
    }

    /// The same learner with the mirror images of observations and actions, which the mirror symmetry loss needs
    /// ([`crate::MirrorConfig`]).
    ///
    /// # Errors
    /// If they are of other sizes.
    pub fn with_mirrors(mut self, mirrors: Mirrors) -> Result<Self, ConfigError> {
        let want = (self.actor.net.input, self.actor.net.output);
        let found = (mirrors.observation.len(), mirrors.action.len());
        if found != want {
            let found = format!("one of {found:?} for {want:?}");
            return Err(ConfigError { key: "mirrors".to_owned(), expected: "one for this policy", found });
        }
        self.mirrors = Some(mirrors);
        Ok(self)
    }

    /// The configuration it was made from.
    pub fn config(&self) -> &LearnConfig {
        &self.config
    }

    /// What computes the products of hidden layers: `f32`, or the name of a bfloat16 kernel ([`paid_policy::bf16::Kernel::name`]).
    pub fn products(&self) -> &'static str {
        self.operands.products()
    }

    /// Iterations done.
    pub fn iteration(&self) -> u64 {
        self.iteration
    }

    /// Actor with its optimizer state.
    pub fn actor(&self) -> &Model {
        &self.actor
    }

    /// The task's critic with its optimizer state.
    pub fn critic(&self) -> &Model {
        &self.critics[0]
    }

    /// All critics: the task's, then that of the learned reward if it has its own.
    pub fn critics(&self) -> &[Model] {
        &self.critics
    }

    /// The reward that this learner computes, if any.
    pub fn learned_reward(&self) -> Option<&dyn LearnedReward> {
        self.learned.as_ref().map(|stream| &*stream.reward)
    }

    /// The learning rate now.
    pub fn learning_rate(&self) -> f64 {
        self.schedule.learning_rate
    }

    /// What the last horizon collected, per shard.
    pub fn shards(&self) -> &[Shard] {
        &self.shards
    }

    /// The policy as it is now, for evaluation and export.
    pub fn policy(&self) -> Policy {
        Policy {
            net: self.actor.net.clone(),
            params: self.actor.weights().to_vec(),
            normalizer: self.policy_normalizer.clone(),
            std: self.actor.log_std().iter().map(|x| x.exp()).collect(),
        }
    }

    /// Collects a horizon and updates.
    ///
    /// # Errors
    /// If a shard does not fit the learner.
    pub fn iterate<E: VecEnv + ?Sized>(
        &mut self,
        envs: &mut [Box<E>],
        threads: usize,
    ) -> Result<IterationStats, ShardError> {
        let collect = self.collect(envs, threads)?;
        let start = Instant::now();
        let update = self.update(threads);
        let log_std = self.actor.log_std();
        let stds: f64 = log_std.iter().map(|x| f64::from(*x).exp()).sum();
        Ok(IterationStats {
            iteration: self.iteration,
            collect,
            update,
            learn_s: start.elapsed().as_secs_f64(),
            learning_rate: self.schedule.learning_rate,
            mean_std: stds / log_std.len().max(1) as f64,
            entropy: entropy(log_std),
        })
    }

    /// Sets the largest standard deviation to what holds when `share` (0 to 1) of a run is over
    /// ([`crate::PpoConfig::std_limit`]). A larger one is cut at once, before the next horizon is collected with it: cut
    /// in the update, it would read as a divergence there. A new learner is at 0.
    pub fn anneal(&mut self, share: f64) {
        if let Some((teacher, weight)) = &mut self.teacher {
            *weight = teacher.weight(share);
        }
        self.std_limit = self.config.ppo.std_limit(share);
        let limit = self.std_limit.ln() as f32;
        for log_std in self.actor.log_std_mut() {
            *log_std = log_std.min(limit);
        }
    }

    /// How much the actions that the teacher took in the last horizon count.
    fn teaching(&self) -> f64 {
        let taught = self.shards.first().is_some_and(|shard| !shard.rollout.taught.is_empty());
        self.teacher.as_ref().filter(|_| taught).map_or(0.0, |(_, weight)| *weight)
    }

    /// The gates of the recurrent networks, by name, over the first unit of the last horizon; nothing before the first.
    pub fn gates(&self) -> Vec<(&'static str, GateStats)> {
        let Some(shard) = self.shards.first() else { return Vec::new() };
        let r = &shard.rollout;
        let actor = ("actor", &self.actor, &r.policy_obs, &shard.actor_start);
        let critic = ("critic", &self.critics[0], &r.critic_obs, &shard.critic_starts[0]);
        let stats = [actor, critic].into_iter().filter_map(|(name, model, observations, starts)| {
            let sequence = sequence(shard, observations, model.net.input, 0, starts);
            let work = &mut TrainWorkspace::default();
            Some((name, gate_stats(&model.net, model.weights(), sequence, work)?))
        });
        stats.collect()
    }

    /// Clears the memory of all shards, whose environments begin new episodes.
    pub fn forget(&mut self) {
        // The next horizon makes them again. Until then there is no state that a checkpoint could carry.
        self.shards.clear();
        self.world = World::default();
    }

    /// Updates actor and critics from the last horizon, then the learned reward.
    pub fn update(&mut self, threads: usize) -> UpdateStats {
        self.prepare_workers(threads);
        if self.shards.is_empty() {
            return UpdateStats::default();
        }
        self.iteration += 1;
        let teacher = self.teaching();
        let ppo = PpoConfig { max_std: self.std_limit, ..self.config.ppo.clone() };
        let stats = update(
            &ppo,
            Networks { actor: &mut self.actor, critics: &mut self.critics, operands: &mut self.operands },
            &mut self.schedule,
            Horizon {
                shards: &self.shards,
                world: &self.world,
                ranks: &*self.ranks,
                advantage: moments(self.advantages),
                mirrors: self.collected.as_ref(),
                teacher,
            },
            &mut self.gradients,
            &mut self.workers,
        );
        if let Some(stream) = &mut self.learned {
            let transitions: Vec<&Transitions> = self.shards.iter().map(|shard| &shard.transitions).collect();
            stream.reward.train(&transitions, &*self.ranks, threads);
        }
        stats
    }

    /// The schedule at the start of training.
    pub(crate) fn fresh_schedule(&self) -> Schedule {
        fresh_schedule(&self.config, self.seed)
    }

    /// Sets the standard deviation of every action, for example at the start of a stage.
    ///
    /// # Errors
    /// If it is outside the configured bounds.
    pub fn set_std(&mut self, std: f64) -> Result<(), ConfigError> {
        let mut config = self.config.clone();
        config.ppo.initial_std = std;
        config.check()?;
        self.actor.log_std_mut().fill(std.ln() as f32);
        Ok(())
    }

    fn prepare_workers(&mut self, threads: usize) {
        self.workers.resize_with(threads.max(1), Worker::default);
    }
}

/// Mean of all advantages and one over their standard deviation.
fn moments([sum, squares, count]: [f64; 3]) -> (f64, f64) {
    let mean = sum / count;
    let variance = (squares / count - mean * mean).max(0.0);
    (mean, 1.0 / (variance.sqrt() + 1e-8))
}

fn fresh_schedule(config: &LearnConfig, seed: u64) -> Schedule {
    Schedule {
        learning_rate: config.ppo.learning_rate,
        adam_step: 0,
        shuffle: Rng::new(seed, 0, SHUFFLE_STREAM),
    }
}
