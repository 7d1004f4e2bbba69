//! `paid train --explain`: where every value of a run comes from.

use crate::common::{paid, refuses, succeeds};

#[test]
fn every_value_is_printed_with_its_origin_and_nothing_is_trained() {
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join("mine.toml"), "base = \"stage2\"\n[run]\nseed = 7\n").expect("file");
    let args = ["train", "stage2", "--preset", "mine.toml", "--set", "run.shards=4", "--explain"];
    let text = succeeds(&paid(folder.path(), &args));
    assert!(text.starts_with("# mine.toml, over stage2.toml, over paper_stage2.toml\n"), "{text}");
    let line = |name: &str| text.lines().find(|line| line.starts_with(name)).expect(name);
    assert!(line("seed").ends_with("# mine.toml:3"), "{text}");
    assert!(line("shards").ends_with("# --set"), "{text}");
    assert!(text.contains("from 60% : "), "{text}");
    let both = succeeds(&paid(folder.path(), &["train", "--explain"]));
    assert!(both.contains("# stage1.toml, over") && both.contains("# stage2.toml, over"), "{both}");
    assert!(!folder.path().join("runs").exists());
}

#[test]
fn a_mistake_in_a_preset_file_is_told_with_its_line() {
    let folder = tempfile::tempdir().expect("folder");
    std::fs::write(folder.path().join("mine.toml"), "base = \"stage2\"\n[run]\nsede = 7\n").expect("file");
    let error = refuses(&paid(folder.path(), &["train", "stage2", "--preset", "mine.toml", "--explain"]));
    assert!(error.contains("mine.toml:3: run.sede: unknown key; did you mean 'run.seed'?"), "{error}");
}
