//! What a plan may contain, and what it may not.

use std::fs;
use std::path::Path;

use super::plan::Plan;

const PLAN: &str = r#"
    title = "two methods"
    samples = 100000
    seeds = [1, 2]

    [judge]
    trials = 2
    knowledge = ["truth", "perceived"]

    [[entry]]
    name = "Ours (two stages)"
    paper = "PAiD"
    stages = [{ preset = "stage1", share = 0.4 }, { preset = "stage2", share = 0.6 }]

    [[entry]]
    name = "AMP"
    seeds = [7]
    stages = [{ preset = "amp" }]
"#;

/// What makes its last entry one that is trained.
const TRAINED: &str = "seeds = [7]\n    stages = [{ preset = \"amp\" }]";

fn refused(text: &str) -> String {
    let plan = toml::from_str::<Plan>(text).map_err(|error| error.to_string());
    match plan {
        Ok(plan) => plan.contenders(Path::new(""), None).expect_err("refused").to_string(),
        Err(error) => error,
    }
}

#[test]
fn a_plan_gives_each_entry_its_seeds_and_its_stages_their_share() {
    let plan: Plan = toml::from_str(PLAN).expect("reads");
    let contenders = plan.contenders(Path::new(""), None).expect("fits");
    let folders: Vec<_> = contenders.iter().map(|c| c.folder.display().to_string()).collect();
    assert_eq!(folders, ["ours-two-stages/seed-1", "ours-two-stages/seed-2", "amp/seed-7"]);
    // 1920 environments and 24 steps are 46,080 samples: 40,000 are one iteration, 60,000 two.
    let iterations: Vec<_> = contenders[1].stages.iter().map(|s| s.run.iterations).collect();
    assert_eq!(iterations, [1, 2]);
    assert_eq!(contenders[1].stages[0].run.seed, 2);
    assert_eq!(contenders[2].stages[0].run.iterations, 3);
    let own = PLAN.replace("seeds = [7]", "seeds = [7]\n        samples = 50000");
    let own: Plan = toml::from_str(&own).expect("reads");
    let own = own.contenders(Path::new(""), None).expect("fits");
    let iterations: Vec<_> =
        own.iter().map(|c| c.stages.iter().map(|s| s.run.iterations).sum::<u64>()).collect();
    assert_eq!(iterations, [3, 3, 2]);
    let begun: Plan = toml::from_str(&PLAN.replace("seeds = [7]", "from = \"src\"")).expect("reads");
    let from: Vec<_> =
        begun.contenders(Path::new(""), None).expect("fits").into_iter().map(|c| c.from).collect();
    assert_eq!(from[1..], [None, Some("src".into()), Some("src".into())]);
}

#[test]
fn an_optional_entry_without_its_file_is_left_out_and_named() {
    let plan = |policy: &str| -> Plan {
        let entry = format!("policy = \"{policy}\"\n        optional = true");
        toml::from_str(&PLAN.replace(TRAINED, &entry)).expect("reads")
    };
    let names = |plan: &Plan| -> Vec<String> {
        plan.contenders(Path::new(""), None).expect("fits").into_iter().map(|c| c.name).collect()
    };
    let absent = plan("no/such/tracker.onnx");
    assert_eq!(names(&absent), ["Ours (two stages)"; 2]);
    assert_eq!(absent.left_out(Path::new("x")), [("AMP", "x/no/such/tracker.onnx".into())]);
    let there = plan("src");
    assert_eq!(names(&there), ["Ours (two stages)", "Ours (two stages)", "AMP"]);
    assert_eq!(there.left_out(Path::new("")), []);
}

#[test]
fn the_shipped_plans_fit() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../configs/compare");
    let read = |name: &str| -> Plan {
        let text = fs::read_to_string(folder.join(name)).expect(name);
        // In the place of a Stage I that is trained before.
        let stage1 = "../../crates/skill/train/tests/samples/stage1.safetensors";
        toml::from_str(&text.replace("../../runs/stage1", stage1)).expect(name)
    };
    for (name, rows) in [("paper.toml", 8), ("ablations.toml", 20)] {
        assert_eq!(read(name).contenders(&folder, None).expect(name).len(), rows, "{name}");
    }
    // Specialists need clips, which are not in the repository; all else fits.
    let error = read("trackers.toml").contenders(&folder, None).expect_err("no clips").to_string();
    assert!(error.contains("found the built-in kicks"), "{error}");
}

#[test]
fn a_plan_that_cannot_be_done_is_refused_before_anything_is_trained() {
    let with = |from: &str, to: &str| refused(&PLAN.replace(from, to));
    assert!(with("samples = 100000", "samples = 0").contains("samples: expected at least 1, found 0"));
    assert!(with("trials = 2", "trails = 2").contains("unknown field `trails`"));
    assert!(with("seeds = [1, 2]", "seeds = [1, 1]").contains("each once"));
    assert!(
        with(r#"name = "AMP""#, r#"name = "ours two stages""#).contains("a different name for each entry")
    );
    assert!(with(r#"preset = "amp""#, r#"preset = "amq""#).contains("amq"));
    assert!(with(r#"stages = [{ preset = "amp" }]"#, "").contains("either stages or a policy, found AMP"));
    let missing = with(TRAINED, r#"policy = "no/such/run""#);
    assert!(missing.contains("expected a run folder or a policy file, found no/such/run"), "{missing}");
    let tracker = with(r#"preset = "amp""#, r#"preset = "stage1""#);
    assert!(
        tracker.contains("judge.tracking_starts") && tracker.contains("a last stage with a ball"),
        "{tracker}"
    );
    let shooter = with("seeds = [7]", "seeds = [7]\n        specialists = true");
    assert!(shooter.contains("expected a folder of motion files (--motions), found the built-in kicks"));
    let tracks = with("seeds = [7]", "seeds = [7]\n        tracks = true");
    assert!(tracks.contains("entry.tracks: expected a policy"), "{tracks}");
    let clips = with("seeds = [7]", "seeds = [7]\n        clips = [\"a\"]");
    assert!(clips.contains("entry.clips: expected specialists = true, found AMP"), "{clips}");
    let none = with("seeds = [7]", "seeds = [7]\n        samples = 0");
    assert!(none.contains("entry.samples: expected at least 1, found 0 in 'AMP'"), "{none}");
    let spent = with(TRAINED, "policy = \"src\"\n        samples = 5");
    assert!(spent.contains("entry.samples: expected stages to spend them on, found AMP"), "{spent}");
    let trained = with("seeds = [7]", "seeds = [7]\n        optional = true");
    assert!(trained.contains("entry.optional: expected a policy whose file may be missing"), "{trained}");
    let both = with("seeds = [7]", "policy = \"src\"");
    assert!(both.contains("either stages or a policy"), "{both}");
    let missing = with("seeds = [7]", "from = \"no/such/run\"");
    assert!(
        missing.contains("entry.from: expected a run folder or a policy file, found no/such/run"),
        "{missing}"
    );
    assert!(with("share = 0.4", "share = 0.0").contains("above zero"));
}

#[test]
fn a_stage_has_values_of_its_own_over_those_of_its_entry() {
    let text = PLAN.replace(
        r#"{ preset = "stage2", share = 0.6 }]"#,
        r#"{ preset = "stage2", share = 0.6, sets = ["learn.ppo.epochs=4"] }]
    sets = ["learn.ppo.epochs=3"]"#,
    );
    let plan: Plan = toml::from_str(&text).expect("reads");
    let contenders = plan.contenders(Path::new(""), None).expect("fits");
    let epochs: Vec<usize> = contenders[0].stages.iter().map(|stage| stage.learn.ppo.epochs).collect();
    assert_eq!(epochs, [3, 4]);
    let error = refused(&text.replace("learn.ppo.epochs=4", "learn.ppo.epoch=4"));
    assert!(error.contains("learn.ppo.epoch=4"), "{error}");
}

#[test]
fn two_stages_in_one_folder_are_refused() {
    let twice = r#"stages = [{ preset = "stage2" }, { preset = "recurrent" }]"#;
    let text = PLAN.replace(r#"stages = [{ preset = "amp" }]"#, twice);
    let error = refused(&text);
    assert!(error.contains("expected a different folder for each stage"), "{error}");
    assert!(error.contains("found amp/seed-7/stage2 twice in 'AMP'"), "{error}");
    let named =
        text.replace(r#"{ preset = "recurrent" }"#, r#"{ preset = "recurrent", sets = ['stage="second"'] }"#);
    let plan: Plan = toml::from_str(&named).expect("reads");
    let stages: Vec<String> = plan.contenders(Path::new(""), None).expect("fits")[2]
        .stages
        .iter()
        .map(|stage| stage.stage.clone())
        .collect();
    assert_eq!(stages, ["stage2", "second"]);

    // Two clips whose names differ in what a folder's name leaves out.
    let folder = tempfile::tempdir().expect("folder");
    for name in ["kick 1.csv", "kick-1.csv"] {
        fs::write(folder.path().join(name), "").expect("writes");
    }
    let specialists = PLAN
        .replace(r#"preset = "amp""#, r#"preset = "stage1""#)
        .replace("seeds = [7]", "seeds = [7]\n    specialists = true")
        .replace("trials = 2", "trials = 2\n    tracking_starts = 1");
    let plan: Plan = toml::from_str(&specialists).expect("reads");
    let motions = format!("run.motions={:?}", folder.path().display().to_string());
    let error = plan.contenders(Path::new(""), Some(&motions)).expect_err("refused").to_string();
    assert!(error.contains("found amp/seed-7/kick-1/stage1 twice in 'AMP'"), "{error}");
}

#[test]
fn what_a_plan_would_ignore_is_refused() {
    let with = |from: &str, to: &str| {
        let text = PLAN.replace(from, to);
        assert_ne!(text, PLAN);
        refused(&text)
    };
    let judged = |more: &str| with(TRAINED, &format!("policy = \"src\"\n    {more}"));
    let sets = judged("sets = [\"learn.ppo.epochs=3\"]");
    assert!(sets.contains("entry.sets: expected stages to train with them, found AMP"), "{sets}");
    let seeds = judged("seeds = [7]");
    assert!(seeds.contains("entry.seeds: expected stages to train with them, found AMP"), "{seeds}");
    let paper = with(r#"paper = "PAiD""#, r#"paper = "PAID""#);
    for part in
        ["entry.paper: expected one of", "Single-Stage", "TWIST2", "found PAID in 'Ours (two stages)'"]
    {
        assert!(paper.contains(part), "{part}: {paper}");
    }
    let told = with(r#"["truth", "perceived"]"#, r#"["truth", "truth"]"#);
    assert!(told.contains("judge.knowledge: expected each once, found [truth, truth]"), "{told}");
    let seed = with("seeds = [7]", "seeds = [7]\n    sets = [\"run.seed = 3\"]");
    assert!(seed.contains("sets: expected seeds instead of run.seed, found run.seed = 3"), "{seed}");
    let length = with("seeds = [1, 2]", "seeds = [1, 2]\n    sets = [\"run.iterations=3\"]");
    assert!(length.contains("sets: expected samples instead of run.iterations"), "{length}");
    let stage = with("share = 0.4", "share = 0.4, sets = [\"run.iterations=3\"]");
    assert!(stage.contains("sets: expected samples instead of run.iterations"), "{stage}");
    let unnamed = with(r#"name = "AMP""#, r#"name = "!!""#);
    assert!(unnamed.contains("entry.name: expected letters or digits"), "{unnamed}");
}

#[test]
fn the_papers_plan_trains_what_the_pilots_chose() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../configs/compare");
    let plan = Plan::read(&folder.join("paper.toml")).expect("reads");
    let contenders = plan.contenders(&folder, None).expect("fits");
    let of = |name: &str| &contenders.iter().find(|c| c.name == name).expect(name).stages;
    let (first, second) = (&of("AMP")[0], &of("AMP")[1]);
    let amp = first.amp.as_ref().expect("a discriminator");
    assert_eq!((amp.style, format!("{:?}", amp.discriminator.formulation).as_str()), (5.0, "Wasserstein"));
    assert_eq!(first.amp, second.amp);
    assert_eq!(first.task.observations.style, second.task.observations.style);
    assert_eq!(first.task.rewards, second.task.rewards);
    let lengths = |name: &str| of(name).iter().map(|stage| stage.run.iterations).collect::<Vec<_>>();
    assert_eq!((lengths("Pure RL"), lengths("AMP")), (vec![6700, 2000], vec![6700, 2000]));
    assert_eq!(lengths("Two stages, the paper's weights, LSTM"), [329, 101]);
    let single = &of("Single-Stage")[0].learn.ppo;
    assert_eq!((single.initial_std, single.max_std), (0.5, 0.5));
}
