//! What `--policy` names, where it is no policy.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use paid_play::is_onnx;
use paid_train::folder::checkpoints;

use crate::failure::Failure;

/// How a ZIP archive begins, and with it an NPZ file.
const ZIP: &[u8] = b"PK\x03\x04";

/// Refuses a file of another kind, and a folder without a run, with a helpful message. The reader checks the rest.
pub fn check(policy: &Path) -> Result<(), Failure> {
    let place = policy.display();
    if policy.is_dir() {
        let others = files_in(policy);
        if !others.is_empty() && checkpoints(policy).is_ok_and(|found| found.is_empty()) {
            return Err(Failure::input(format!(
                "--policy {place}: expected a run folder with model_<iteration>.safetensors, found {}; name one of them",
                others.join(", ")
            )));
        }
        return Ok(());
    }
    match kind(policy) {
        Some(found) if !is_onnx(policy) => Err(Failure::input(format!(
            "--policy {place}: expected a checkpoint (.safetensors) or .onnx, found {found}"
        ))),
        _ => Ok(()),
    }
}

/// The policy files of a folder, by name.
fn files_in(folder: &Path) -> Vec<String> {
    let is_policy = |name: &String| {
        let extension = Path::new(name).extension();
        extension.is_some_and(|extension| extension == "safetensors" || extension == "onnx")
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(is_policy).collect();
    names.sort();
    names
}

/// What a file is, if it is certainly not a checkpoint: a checkpoint starts with an eight-byte number, which contains zeros.
fn kind(file: &Path) -> Option<&'static str> {
    let mut begin = Vec::new();
    File::open(file).ok()?.take(64).read_to_end(&mut begin).ok()?;
    let is_text = |byte: &u8| !byte.is_ascii_control() || byte.is_ascii_whitespace();
    if begin.starts_with(ZIP) {
        Some("a zip archive")
    } else if begin.is_empty() {
        Some("an empty file")
    } else {
        begin.iter().all(is_text).then_some("a text file")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_policy_is_named_for_what_it_is() {
        let folder = tempfile::tempdir().expect("folder");
        let place = |name: &str| folder.path().join(name);
        fs::write(place("kick.npz"), b"PK\x03\x04\x14\x00").expect("written");
        fs::write(place("preset.toml"), "base = \"stage2\"\n").expect("written");
        let error = |name: &str| check(&place(name)).expect_err("refused").to_string();
        let end = "kick.npz: expected a checkpoint (.safetensors) or .onnx, found a zip archive";
        assert!(error("kick.npz").ends_with(end), "{}", error("kick.npz"));
        assert!(error("preset.toml").ends_with("found a text file"), "{}", error("preset.toml"));
        // What may be a checkpoint, and what is not there, is for the reader.
        fs::write(place("cut.safetensors"), b"\x10\x00\x00\x00\x00\x00\x00\x00{").expect("written");
        check(&place("cut.safetensors")).expect("perhaps one");
        check(&place("absent")).expect("the reader says so");
        fs::create_dir(place("demo")).expect("folder");
        check(&place("demo")).expect("the reader says that it is empty");
        fs::write(place("demo/policy.onnx"), b"x").expect("written");
        assert!(error("demo").ends_with("found policy.onnx; name one of them"), "{}", error("demo"));
        fs::write(place("demo/model_5.safetensors"), b"x").expect("written");
        check(&place("demo")).expect("a run");
    }
}
