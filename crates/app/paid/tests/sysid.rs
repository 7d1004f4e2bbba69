//! `paid sysid` from end to end: simulated films in, a surface out.

use std::fs;
use std::path::Path;

use crate::common::{paid, refuses, succeeds};
use serde_json::Value;

/// Searches short enough for a test.
const QUICK: [&str; 4] = ["--restarts", "3", "--starts", "refined"];

fn json(line: &str) -> Value {
    serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"))
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .expect("folder")
        .map(|e| e.expect("entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

fn film(folder: &Path, more: &[&str]) -> String {
    succeeds(&paid(folder, &[&["sysid", "simulate", "--out", "film"], more].concat()))
}

#[test]
fn a_filmed_surface_comes_back_with_its_pictures() {
    let folder = tempfile::tempdir().expect("folder");
    let made = json(&film(folder.path(), &["--surface", "grass", "--json"]));
    assert_eq!(made["truth"][4], 4.95);
    let files = ["--drop", "film/drop.csv", "--roll", "film/roll.csv"];
    let out = ["--out", "yard.toml", "--plots", "plots"];
    let truth = ["--truth", "0.98,0.15,0.71,0.01,4.95"];
    let args = [&["sysid"][..], &files, &out, &truth, &QUICK].concat();
    let table = succeeds(&paid(folder.path(), &args));
    for part in
        ["restitution", "sharp", "dynamic_friction cannot be identified", "correlation", "wrote yard.toml"]
    {
        assert!(table.contains(part), "{part}: {table}");
    }
    assert_eq!(
        names(&folder.path().join("plots")),
        ["drop.png", "drop.svg", "loss.png", "loss.svg", "roll.png", "roll.svg"]
    );
    assert_eq!(names(folder.path()), ["film", "plots", "yard.toml"]);

    // The same as JSON, with the file that was written.
    let report = json(&succeeds(&paid(folder.path(), &[&args[..], &["--json"]].concat())));
    assert_eq!((&report["surface"]["name"], &report["truth"][4]), (&Value::from("yard"), &Value::from(4.95)));
    let found = report["ball"]["angular_damping"].as_f64().expect("a number");
    assert!((found - 4.95).abs() < 0.05 * 4.95, "{found}");
    assert_eq!(report["confidence"]["estimates"].as_array().expect("a list").len(), 5);
    assert!(report["searches"][0]["curve"].as_array().expect("a list").len() > 10);

    // The surface file is a ball for the next film.
    let again = json(&film(folder.path(), &["--surface", "yard.toml", "--json"]));
    let back = again["truth"][4].as_f64().expect("a number");
    assert!((back - found).abs() < 1e-5, "{back} {found}");
    // ... and a ball that a run can train with.
    let args = ["train", "stage2", "--explain", "--json", "--set", "task.ball_params=yard.toml"];
    let explained = json(&succeeds(&paid(folder.path(), &args)));
    let rows = explained["values"].as_array().expect("rows");
    let row = rows.iter().find(|row| row["key"] == "task.ball_params.angular_damping").expect("a row");
    assert_eq!(row["value"].as_f64().expect("a number"), back);
}

#[test]
fn a_sliding_start_is_an_experiment_of_its_own() {
    let folder = tempfile::tempdir().expect("folder");
    film(folder.path(), &["--surface", "hard", "--slide", "4"]);
    assert_eq!(names(&folder.path().join("film")), ["drop.csv", "roll.csv", "slide.csv"]);
    let args = [
        &["sysid", "--drop", "film/drop.csv", "--roll", "film/roll.csv", "--slide", "film/slide.csv"][..],
        // Starting from the true values: this is about the files, not about the search.
        &["--initial", "0.77,0.07,0.75,0.01,4.28", "--scale", "0.02", "--restarts", "1", "--json"],
        &["--starts", "refined"],
    ]
    .concat();
    let report = json(&succeeds(&paid(folder.path(), &args)));
    let rolls = report["rolls"].as_array().expect("a list");
    assert_eq!((rolls.len(), &rolls[7]["run"]), (10, &Value::from("slide 3")));
    let friction = &report["confidence"]["estimates"][1];
    let error = friction["value"].as_f64().expect("a number") - 0.07;
    assert!(error.abs() < 0.05 * 0.07 && friction["verdict"] != "unseen", "{friction}");
    // FIFA has no such test.
    let turf = ["sysid", "simulate", "--from", "turf", "--slide", "4", "--out", "turf"];
    assert!(refuses(&paid(folder.path(), &turf)).contains("--slide"));
    assert!(!folder.path().join("turf").exists());
}

#[test]
fn every_source_makes_files_that_read_back() {
    let folder = tempfile::tempdir().expect("folder");
    film(folder.path(), &["--from", "turf", "--rate", "30"]);
    assert_eq!(names(&folder.path().join("film")), ["drop.csv", "roll.csv"]);
    let args = [
        &["sysid", "--drop", "film/drop.csv", "--roll", "film/roll.csv", "--json"][..],
        &["--restarts", "2", "--repeats", "mean", "--set", "scene.ground.restitution=1"],
    ]
    .concat();
    let report = json(&succeeds(&paid(folder.path(), &args)));
    assert_eq!(report["ground"]["restitution"], 1.0);
    assert_eq!(report["drops"].as_array().expect("a list").len(), 1);

    let steel = folder.path().join("steel");
    fs::create_dir(&steel).expect("folder");
    film(&steel, &["--from", "steel"]);
    assert_eq!(names(&steel.join("film")), ["drop.csv"]);
}

#[test]
fn bad_measurements_name_file_line_column_expected_and_found() {
    let folder = tempfile::tempdir().expect("folder");
    film(folder.path(), &[]);
    let path = folder.path().join("film/roll.csv");
    let text = fs::read_to_string(&path).expect("file");
    // Comments and header come first: the fifth line is the second sample.
    let lines: Vec<&str> = text.lines().collect();
    let broken = text.replace(lines[4], "1,0.1,fast");
    fs::write(&path, broken).expect("file");
    fs::write(folder.path().join("yard.toml"), "precious").expect("file");
    let args = [
        "sysid",
        "--drop",
        "film/drop.csv",
        "--roll",
        "film/roll.csv",
        "--out",
        "yard.toml",
        "--plots",
        "plots",
    ];
    let error = refuses(&paid(folder.path(), &args));
    for part in ["film/roll.csv, line 5, column 'distance_m'", "expected a finite number", "found 'fast'"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    assert_eq!(fs::read_to_string(folder.path().join("yard.toml")).expect("file"), "precious");
    assert_eq!(names(folder.path()), ["film", "yard.toml"]);
}

#[test]
fn films_with_a_wrong_clock_and_fits_far_off_write_nothing() {
    let folder = tempfile::tempdir().expect("folder");
    film(folder.path(), &["--from", "steel", "--rate", "60"]);
    let fit = |drop: &str| {
        let args =
            [&["sysid", "--drop", drop, "--out", "yard.toml", "--plots", "plots"][..], &QUICK].concat();
        refuses(&paid(folder.path(), &args))
    };
    // Steel returns more than the task's ground can.
    let error = fit("film/drop.csv");
    assert!(error.contains("nothing was written") && error.contains("scene.ground.restitution=1"), "{error}");
    // 240 frames a second, played at 60.
    let text = fs::read_to_string(folder.path().join("film/drop.csv")).expect("file");
    let slow = text.lines().map(|line| match line.split(',').collect::<Vec<_>>()[..] {
        [run, time, height] => match time.parse::<f64>() {
            Ok(time) => format!("{run},{:.4},{height}\n", 4.0 * time),
            Err(_) => format!("{line}\n"),
        },
        _ => format!("{line}\n"),
    });
    fs::write(folder.path().join("slow.csv"), slow.collect::<String>()).expect("writes");
    let error = fit("slow.csv");
    assert!(error.contains("slow.csv, the drops: expected a ball that falls at 9.81 m/s^2"), "{error}");
    assert!(error.contains("slow motion"), "{error}");
    assert_eq!(names(folder.path()), ["film", "slow.csv"]);
}

#[test]
fn results_that_cannot_be_written_leave_nothing_behind() {
    let folder = tempfile::tempdir().expect("folder");
    film(folder.path(), &[]);
    fs::write(folder.path().join("file"), "precious").expect("file");
    let quick = ["--restarts", "1"];
    let args = ["sysid", "--drop", "film/drop.csv", "--plots", "plots", "--out", "file/yard.toml"];
    let error = refuses(&paid(folder.path(), &[&args[..], &quick].concat()));
    assert!(error.contains("file/yard.toml"), "{error}");
    assert_eq!(fs::read_to_string(folder.path().join("file")).expect("file"), "precious");
    let left = folder.path().join("plots");
    assert!(!left.exists() || names(&left).is_empty(), "{:?}", names(&left));
}

#[test]
fn wrong_options_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    film(folder.path(), &[]);
    let files = ["sysid", "--drop", "film/drop.csv", "--roll", "film/roll.csv"];
    for (more, parts) in [
        (&["--population", "1"][..], ["population", "2 to 1024"]),
        (&["--range", "bounce=0,1"], ["bounce", "restitution"]),
        (&["--range", "restitution=1,0"], ["range of restitution", "low < high"]),
        (&["--initial", "1,2,3"], ["five numbers", "1,2,3"]),
        (&["--initial", "0.5,0.5,0.5,1,9"], ["initial angular_damping", "found 9"]),
        (&["--set", "scene.ground.bounce=1"], ["bounce", "scene"]),
        (&["--lambda1", "0", "--lambda2", "0"], ["weight_drop", "above 0"]),
    ] {
        let error = refuses(&paid(folder.path(), &[&files[..], more].concat()));
        for part in parts {
            assert!(error.contains(part), "{part}: {error}");
        }
    }
    let error = refuses(&paid(folder.path(), &["sysid"]));
    assert!(error.contains("--drop") && error.contains("simulate"), "{error}");
    let error = refuses(&paid(folder.path(), &["sysid", "--drop", "absent.csv"]));
    assert!(error.contains("absent.csv"), "{error}");
    let error = refuses(&paid(folder.path(), &["sysid", "simulate", "--out", "x", "--surface", "mud"]));
    assert!(error.contains("mud") && error.contains("grass"), "{error}");
    // What the source does not look at.
    for (more, expected) in [
        (&["--from", "turf", "--surface", "grass"][..], "--surface: expected --from parameters or mujoco"),
        (&["--from", "steel", "--parameters", "1,1,1,1,1"], "--parameters: expected --from parameters or"),
        (&["--rebound", "1"], "--rebound: expected --from turf or steel, found --from parameters"),
        (&["--from", "mujoco", "--roll-length", "5"], "--roll-length: expected --from turf or steel"),
        (&["--from", "turf", "--damping-ratio", "0.2"], "--damping-ratio: expected --from mujoco"),
        (
            &["--from", "turf", "--spin", "0"],
            "--spin: expected --from parameters or mujoco, found --from turf",
        ),
        (&["--from", "turf", "--task", "stage2"], "--task: expected --from parameters or mujoco"),
        (
            &["--from", "mujoco", "--isa", "portable"],
            "--isa: expected --from parameters, found --from mujoco",
        ),
        (&["--from", "steel", "--set", "scene.ground.restitution=1"], "--set: expected --from parameters or"),
    ] {
        let error = refuses(&paid(folder.path(), &[&["sysid", "simulate", "--out", "x"], more].concat()));
        assert!(error.contains(expected), "{error}");
    }
    assert!(!folder.path().join("x").exists());
}
