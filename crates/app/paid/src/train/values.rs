//! Values of a run preset that come from the command line.

use std::path::Path;

use crate::failure::Failure;

/// The folder of the motions as a preset value.
pub fn motions_value(motions: &Path) -> String {
    // A string of JSON is one of TOML; a debug-formatted one is not, where an accent is a character of its own.
    format!("run.motions={}", serde_json::Value::from(motions.to_string_lossy()))
}

/// Refuses a file where a folder of motions is expected.
pub fn motion_folder(motions: &Path) -> Result<(), Failure> {
    if motions.is_file() {
        let found = motions.display();
        return Err(Failure::input(format!(
            "--motions: expected a folder of motion files, found the file {found}"
        )));
    }
    Ok(())
}

/// The changes of a run preset's values, if each of them has a key and a value.
pub fn whole(sets: &[String]) -> Result<Vec<String>, Failure> {
    match sets.iter().find(|set| !set.contains('=')) {
        None => Ok(sets.to_vec()),
        Some(found) => Err(Failure::input(format!(
            "--set: expected KEY=VALUE, such as learn.ppo.epochs=5, found '{found}'"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_any_name_is_the_folder_of_the_motions() {
        for name in ["clips", "U\u{308}bung", "my \"clips\"", r"C:\clips"] {
            let preset = paid_train::RunPreset::resolve("stage1", &[motions_value(Path::new(name))]);
            assert_eq!(preset.expect(name).run.motions, name);
        }
    }

    #[test]
    fn a_change_without_a_value_is_told_with_one_that_a_run_preset_has() {
        let error = whole(&["learn.ppo.epochs".to_owned()]).expect_err("refused").to_string();
        assert!(
            error.starts_with("--set: expected KEY=VALUE") && error.ends_with("'learn.ppo.epochs'"),
            "{error}"
        );
        let example =
            error.split("such as ").nth(1).and_then(|rest| rest.split(',').next()).expect("an example");
        let preset = paid_train::RunPreset::resolve("stage1", &[example.to_owned()]);
        assert!(preset.is_ok(), "{example}");
    }
}
