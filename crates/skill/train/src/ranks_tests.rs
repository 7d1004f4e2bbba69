//! Several processes that train together, as threads, on the toy task.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use paid_learn::ranks::ThreadRanks;
use paid_learn::{Alone, Checkpoint, Ranks};

use crate::folder::checkpoints;
use crate::stage::run_stage;
use crate::toy::Toy;
use crate::{End, Limits, RunPreset, StageJob, Start, Trainer};

/// Largest difference of a weight from one process's, after some steps of a rate of a thousandth: sums are rounded in another order.
const BOUND: f32 = 2e-5;

/// A rank's trainer, with its part of the shards.
fn trainer(preset: &RunPreset, ranks: Arc<dyn Ranks>) -> Trainer<Toy> {
    let (each, rank) = (preset.run.shards / ranks.count(), ranks.rank());
    let shards = Toy::shards(preset).into_iter().skip(each * rank).take(each).collect();
    let trainer = Trainer::new(preset, shards, vec!["toy".to_owned()]).expect("trainer");
    trainer.with_ranks(ranks)
}

/// Runs `work` on every rank at once.
fn on_each<T: Send>(count: usize, work: impl Fn(Arc<dyn Ranks>) -> T + Sync) -> Vec<T> {
    std::thread::scope(|scope| {
        let work = &work;
        let start = |ranks: ThreadRanks| scope.spawn(move || work(Arc::new(ranks)));
        let threads: Vec<_> = ThreadRanks::of(count).into_iter().map(start).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    })
}

fn weights(trainer: &Trainer<Toy>) -> Vec<f32> {
    let learner = trainer.learner();
    learner.actor().params.iter().chain(&learner.critic().params).copied().collect()
}

fn near(a: &[f32], b: &[f32]) {
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(a.len() == b.len() && off < BOUND, "{off}");
}

#[test]
fn ranks_that_share_the_shards_train_what_one_process_with_all_of_them_trains() {
    for sets in [&[][..], &["learn.ppo.balanced=true"], &["learn.actor.kind=lstm", "learn.critic.kind=lstm"]]
    {
        let preset = Toy::preset(sets);
        let course = |ranks: Arc<dyn Ranks>| {
            let mut trainer = trainer(&preset, ranks);
            let records: Vec<_> = (0..3).map(|_| trainer.iterate(1).expect("iterates")).collect();
            (weights(&trainer), records)
        };
        let (alone, expected) = course(Arc::new(Alone));
        for count in [2, 4] {
            let ranks = on_each(count, course);
            for (found, records) in &ranks {
                assert_eq!(found, &ranks[0].0, "every rank has the same weights");
                near(found, &alone);
                // The first horizon is collected with the same weights and the same noise.
                assert_eq!(records[0].mean_reward, expected[0].mean_reward);
                assert_eq!(records[2].samples, expected[2].samples);
                let (a, b) = (&records[0].loss, &expected[0].loss);
                assert!(
                    (a.surrogate - b.surrogate).abs() < 1e-6 && (a.kl - b.kl).abs() < 1e-6,
                    "{a:?} {b:?}"
                );
            }
            assert_eq!(on_each(count, course)[0].0, ranks[0].0, "and again the same");
        }
    }
}

#[test]
fn a_run_continues_with_another_number_of_ranks() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("model.safetensors");
    for sets in [&[][..], &["learn.actor.kind=lstm", "learn.critic.kind=lstm"]] {
        let preset = Toy::preset(sets);
        let straight = on_each(2, |ranks| {
            let mut trainer = trainer(&preset, ranks);
            (0..2).for_each(|_| drop(trainer.iterate(1).expect("iterates")));
            trainer.save(&path).expect("saves");
            (0..2).for_each(|_| drop(trainer.iterate(1).expect("iterates")));
            weights(&trainer)
        });
        for count in [1, 2, 4] {
            let resumed = on_each(count, |ranks| {
                let mut trainer = trainer(&preset, ranks);
                trainer.resume(&Checkpoint::load(&path).expect("reads")).expect("resumes");
                (0..2).for_each(|_| drop(trainer.iterate(1).expect("iterates")));
                weights(&trainer)
            });
            near(&resumed[0], &straight[0]);
            if count == 2 {
                assert_eq!(resumed, straight);
            }
        }
    }
}

#[test]
fn a_minibatch_of_a_balanced_shuffle_has_as_much_of_every_rank() {
    let preset = Toy::preset(&["learn.ppo.balanced=true"]);
    let mut one = trainer(&preset, Arc::new(Alone));
    let mut other = trainer(&Toy::preset(&[]), Arc::new(Alone));
    (0..2).for_each(|_| drop((one.iterate(1).expect("iterates"), other.iterate(1).expect("iterates"))));
    assert_ne!(weights(&one), weights(&other), "another order of the samples");
}

#[test]
fn the_first_rank_writes_and_anybody_stops_all() {
    let folder = tempfile::tempdir().expect("folder");
    let preset = Toy::preset(&["run.iterations=40"]);
    let stops = [AtomicBool::new(false), AtomicBool::new(false)];
    let seen = on_each(2, |ranks| {
        let rank = ranks.rank();
        let job = StageJob {
            preset: preset.clone(),
            out: folder.path().join("run"),
            start: Start::Fresh,
            limits: Limits::default(),
            threads: 1,
            ranks: Arc::clone(&ranks),
        };
        let build = |preset: &RunPreset| Ok(trainer(preset, Arc::clone(&ranks)));
        let mut reported = 0;
        let mut report = |record: &crate::Record| {
            reported += 1;
            // The second rank is stopped while the first one reports.
            if record.iteration == 3 {
                stops[1].store(true, std::sync::atomic::Ordering::SeqCst);
            }
        };
        let outcome = run_stage(&job, &build, &stops[rank], &mut report, None).expect("trains");
        (outcome.end, outcome.iteration, reported)
    });
    assert_eq!((seen[0].0, seen[1].0), (End::Stopped, End::Stopped));
    assert_eq!(seen[0].1, seen[1].1);
    assert!((3..=4).contains(&seen[0].1), "{}", seen[0].1);
    assert_eq!((seen[0].2, seen[1].2), (seen[0].1, 0), "one log");
    assert!(!checkpoints(&folder.path().join("run")).expect("a folder").is_empty());
}
