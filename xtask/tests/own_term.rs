//! ARCHITECTURE.md shows the terms of `examples/own_term` as they are.

const ARCHITECTURE: &str = include_str!("../../ARCHITECTURE.md");

#[test]
fn the_architecture_shows_these_lines() {
    let effort =
        include_str!("../../examples/own_term/src/terms.rs").split("\n\nparameters!").next().expect("a term");
    let (_, effort) = effort.split_once("reward_term! {").expect("a term");
    let (_, names) = include_str!("../../examples/own_term/src/main.rs")
        .split_once("TermSet::builtin()\n")
        .expect("names");
    let (names, _) = names.split_once("\n}").expect("names");
    let (_, value) = include_str!("../../examples/own_term/own_term.toml")
        .split_once("[task.rewards]\n")
        .expect("a value");
    for part in [effort, names, value.lines().next().expect("a value")] {
        assert!(ARCHITECTURE.contains(part.trim()), "ARCHITECTURE.md shows another text than:\n{part}");
    }
}
