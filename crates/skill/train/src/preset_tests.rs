//! Tests of run presets: the built-in ones, files over them, and what is refused.

use std::collections::BTreeMap;
use std::fs;

use paid_learn::NetworkKind;
use paid_task::TaskPreset;
use paid_task::layers::{Origin, Tree};
use toml::Value;

use crate::load::builtin;
use crate::{Resolved, RunPreset};

fn resolved(name: &str) -> Resolved {
    Resolved::load(name, &[], "").expect(name)
}

fn refused(name: &str, sets: &[&str]) -> String {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    RunPreset::resolve(name, &sets).expect_err("refused").to_string()
}

/// The values of a preset without its phases.
fn values(resolved: &Resolved) -> BTreeMap<String, Value> {
    let tree = Tree::of(&resolved.preset).expect("writes");
    let all = tree.leaves().into_iter().filter(|(key, ..)| !key.starts_with("phases"));
    all.map(|(key, value, _)| (key, value.clone())).collect()
}

/// The text of a built-in preset as a tree, and its base.
fn own(file: &str, text: &str) -> (Tree, Option<String>) {
    let mut tree = Tree::parse(file, text).expect("valid TOML");
    let base = tree.take("base").map(|base| base.leaves()[0].1.as_str().expect("a name").to_owned());
    tree.expand_surfaces("".as_ref()).expect("surfaces");
    (tree, base)
}

/// True if the key stands in a table of which the file names another kind, so that nothing comes from the base.
fn in_another_kind(tree: &Tree, key: &str) -> bool {
    let mut tables = key.match_indices('.').map(|(at, _)| &key[..at]);
    tables.any(|table| tree.contains(&format!("{table}.kind")))
}

#[test]
fn builtin_presets_resolve_and_survive_a_round_trip() {
    for (name, ..) in builtin() {
        let preset = resolved(name).preset;
        assert_eq!(preset.task.name, preset.stage);
        let text = preset.to_toml().expect("writes");
        assert_eq!(RunPreset::from_resolved(name, &text, &[]).expect("reads"), preset);
    }
}

#[test]
fn a_preset_differs_from_its_base_only_where_its_own_file_says_so() {
    for (name, file, text) in builtin() {
        let (tree, Some(base)) = own(file, text) else { continue };
        let (mine, below) = (values(&resolved(name)), values(&resolved(&base)));
        for (key, value) in &mine {
            let differs = below.get(key) != Some(value);
            assert!(
                !differs || (tree.contains(key) || in_another_kind(&tree, key)),
                "{name}: {key} = {value} is neither named nor {base}'s"
            );
        }
        assert!(
            below
                .keys()
                .all(|key| mine.contains_key(key) || (tree.contains(key) || in_another_kind(&tree, key))),
            "{name}"
        );
    }
}

#[test]
fn a_preset_names_nothing_that_its_base_says_already() {
    for (name, file, text) in builtin() {
        let (tree, Some(base)) = own(file, text) else { continue };
        let below = values(&resolved(&base));
        for (key, value, _) in tree.leaves() {
            if in_another_kind(&tree, &key) && !key.ends_with(".kind") {
                continue;
            }
            let typed = values(&resolved(name)).get(&key).cloned();
            let repeated = typed.as_ref().is_some_and(|typed| below.get(&key) == Some(typed));
            assert!(!repeated, "{name}: {key} = {value} is {base}'s");
        }
    }
}

#[test]
fn a_phase_names_nothing_that_holds_already() {
    for (name, file, text) in builtin() {
        let preset = resolved(name).preset;
        let base = own(file, text).1.map(|base| resolved(&base).preset);
        for (k, phase) in preset.phases.iter().enumerate() {
            let before = Tree::of(&preset.in_phase(k).expect("valid")).expect("writes");
            let below = base.as_ref().and_then(|base| base.phases.get(k));
            let below = below.map(|phase| Tree::of(&phase.values).expect("writes"));
            for (key, value, _) in Tree::of(&phase.values).expect("writes").leaves() {
                // What the same phase of the base changes has to be named to stay.
                let kept =
                    below.as_ref().and_then(|tree| tree.value(&key)).is_some_and(|below| below != *value);
                assert!(kept || before.value(&key).as_ref() != Some(value), "{name}: phases.{k}.{key}");
            }
        }
    }
}

#[test]
fn the_papers_presets_are_complete_and_a_chain_has_three_files_at_most() {
    for (name, ..) in builtin() {
        let resolved = resolved(name);
        assert!(resolved.files.len() <= 3, "{name}: {:?}", resolved.files);
        assert!(resolved.files.last().expect("a file").starts_with("paper_stage"), "{name}");
        if name.starts_with("paper_") {
            let left_out: Vec<_> = resolved
                .origins
                .leaves()
                .into_iter()
                .filter(|(key, _, origin)| {
                    // Terms without noise need not be listed, and there are no phases.
                    **origin == Origin::Default
                        && !key.starts_with("task.observations.noise.")
                        && key != "phases"
                })
                .collect();
            assert!(left_out.is_empty(), "{name}: {left_out:?}");
            assert_eq!(TaskPreset::builtin(name).expect("built in"), resolved.preset.task);
        }
    }
}

#[test]
fn the_papers_presets_train_with_the_papers_networks_and_settings() {
    for name in ["paper_stage1", "paper_stage2"] {
        let RunPreset { run, learn, task, phases, .. } = resolved(name).preset;
        assert_eq!((run.envs, learn.ppo.horizon, learn.ppo.epochs, learn.ppo.minibatches), (4096, 24, 5, 4));
        // The release resumes the first stage's policy, deviation included.
        assert!(learn.ppo.keep_std);
        for net in [&learn.actor, &learn.critic] {
            assert_eq!((net.kind, net.lstm.layers, net.lstm.size), (NetworkKind::Lstm, 2, 128));
            assert_eq!(net.hidden, [128, 64, 32]);
        }
        assert!((0..10).all(|part| learn.ppo.std_limit(f64::from(part) / 10.0) == learn.ppo.max_std));
        assert_eq!(phases, []);
        assert!(!task.randomization.robot && !task.perceives());
    }
}

#[test]
fn overrides_reach_every_part_and_a_misspelled_key_is_refused() {
    let sets = ["run.envs=64", "run.shards=4", "learn.ppo.gamma=0.9", "task.rewards.action_rate.weight=-1"];
    let preset = RunPreset::resolve("stage1", &sets.map(str::to_owned)).expect("resolves");
    assert_eq!((preset.run.envs, preset.learn.ppo.gamma), (64, 0.9));
    assert_eq!(preset.task.rewards.action_rate.weight, -1.0);
    for (set, hint) in [
        ("run.evns=64", "run.envs"),
        ("learn.ppo.gama=1", "learn.ppo.gamma"),
        ("run.envs=1000", "multiple of 64"),
        ("run.envs=many", "integer"),
        ("learn.ppo.clip=-1", "learn.ppo.clip: expected a positive number, found -1"),
        ("run.isa=mmx", "avx2"),
        ("run.average_last=1.0", "run.average_last"),
        ("task.ball.rule=circle", "task.ball.rule"),
    ] {
        let error = refused("stage1", &["run.isa=portable", set]);
        assert!(error.contains(&format!("--set {set}: ")) && error.contains(hint), "{error}");
    }
}

#[test]
fn a_file_inherits_from_a_builtin_and_errors_name_its_line() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("mine.toml");
    let name = path.to_string_lossy();
    fs::write(&path, "base = \"stage2\"\n[run]\nseed = 7\n[task.goal]\nwidth_m = 3\n").expect("write");
    let preset = RunPreset::resolve(&name, &[]).expect("resolves");
    assert_eq!((preset.run.seed, preset.task.goal.width_m), (7, 3.0));
    assert_eq!(preset.task.name, "stage2");
    for (text, hint) in [
        ("[run]\nsede = 7", "mine.toml:3: run.sede: unknown key; did you mean 'run.seed'?"),
        ("[run]\nseed = 'x'", "mine.toml:3: run.seed: invalid type: string \"x\", expected u64"),
        ("[run]\nenvs = 0", "mine.toml:3: run.envs: expected at least 1, found 0"),
        ("[task.goal]\nwidth_m = true", "mine.toml:3: task.goal.width_m: "),
        ("task.pushes.interval_s = [3.0, 1.0]", "mine.toml:2: task.pushes.interval_s: expected [lo, hi]"),
        ("task.ball_params = 'mud'", "mine.toml:2: expected a surface (hard, grass)"),
        ("[run", "mine.toml:2: "),
        ("task.rewards.wave.weight = 0.0", "mine.toml:2: task.rewards.wave: unknown key"),
    ] {
        fs::write(&path, format!("base = \"stage2\"\n{text}\n")).expect("write");
        let error = refused(&name, &[]);
        assert!(error.contains(hint), "{text}: {error}");
    }
    assert!(refused("stage9", &[]).contains("paper_stage1"));
    assert!(refused("absent.toml", &[]).contains("absent.toml"));
}

#[test]
fn a_surface_can_be_chosen_by_name_in_an_override() {
    let sets = ["task.ball_params=grass", "task.randomization.surfaces=[\"hard\"]"].map(str::to_owned);
    let task = RunPreset::resolve("stage1", &sets).expect("resolves").task;
    assert_eq!(task.ball_params.angular_damping, 4.95);
    assert_eq!(task.randomization.surfaces[0].dynamic_friction, 0.07);
}

#[test]
fn a_policy_with_memory_plays_in_the_mirror_but_its_state_has_no_image() {
    for kind in ["learn.actor.kind=lstm", "learn.actor.kind=memory"] {
        let sets = ["task.mirror_left_kicks=true", kind, "learn.ppo.mirror.weight=0"];
        let preset = RunPreset::resolve("stage2", &sets.map(str::to_owned)).expect("one world an episode");
        assert!(preset.task.mirror_left_kicks && preset.learn.actor.is_recurrent());
        let error = refused("stage2", &[kind, "learn.ppo.mirror.weight=0.1"]);
        assert!(error.contains("ppo.mirror.weight: expected 0 for a recurrent policy"), "{error}");
    }
}
