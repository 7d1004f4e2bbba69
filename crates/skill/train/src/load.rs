//! Reads run presets: a file over its bases, then `--set`.

use std::fs;
use std::path::{Path, PathBuf};

use paid_learn::Checkpoint;
use paid_play::PRESET_FILE;
use paid_task::layers::{LayerError, Tree};
use paid_task::preset::{BuiltinPreset, PAPER};
use paid_task::{TaskPreset, builtin_presets};
use toml::Value;

use crate::written::known_part;
use crate::{RunPreset, TrainError};

/// Run presets in the binary in addition to the paper's.
const OURS: [BuiltinPreset; 8] = builtin_presets![
    "stage1",
    "stage2",
    "recurrent",
    "stage3",
    "pure_rl",
    "pure_rl_scattered",
    "amp",
    "single_stage",
];

/// The run presets in the binary.
pub fn builtin() -> impl Iterator<Item = BuiltinPreset> {
    PAPER.into_iter().chain(OURS)
}

/// A resolved preset and where each of its values comes from.
#[derive(Clone, Debug)]
pub struct Resolved {
    /// The preset.
    pub preset: RunPreset,
    /// Every value with its origin; those of phases are below `phases.0`, `phases.1` and so on.
    pub origins: Tree,
    /// The preset's files, its own first.
    pub files: Vec<String>,
}

/// The task of a run preset (built-in name or file) with `--set` overrides, whose keys are those of the task.
///
/// # Errors
/// As [`RunPreset::resolve`].
pub fn task_preset(name: &str, overrides: &[String]) -> Result<TaskPreset, TrainError> {
    Ok(Resolved::load(name, overrides, "task")?.preset.task)
}

impl Resolved {
    /// Reads a preset by built-in name or file path, lays it over its bases, and applies `KEY=VALUE` overrides, whose keys are below
    /// `prefix`.
    ///
    /// # Errors
    /// [`TrainError::Preset`] naming file and line or override, key, expected and found.
    pub fn load(name: &str, overrides: &[String], prefix: &str) -> Result<Self, TrainError> {
        let mut files = Vec::new();
        let tree = read(name, Path::new(""), &mut files)?;
        Self::finish(name, tree, files, overrides, prefix)
    }

    /// Reads the resolved preset that a program wrote, and applies overrides. Keys that this program does not know are left out where the
    /// text turns them off.
    ///
    /// # Errors
    /// If the text is not one, turns on what this program does not have, or an override does not apply.
    pub fn of_text(place: &str, text: &str, overrides: &[String]) -> Result<Self, TrainError> {
        let mut tree = known_part(place, text)?;
        tree.expand_surfaces(Path::new(""))?;
        Self::finish(place, tree, vec![place.to_owned()], overrides, "")
    }

    fn finish(
        place: &str,
        mut tree: Tree,
        files: Vec<String>,
        overrides: &[String],
        prefix: &str,
    ) -> Result<Self, TrainError> {
        let typed = |tree: &Tree| tree.typed().map_err(|error| tree.locate(error, place));
        let fill = |tree: &mut Tree, preset: &RunPreset| {
            tree.fill(preset)
                .map_err(|error| LayerError { place: place.to_owned(), message: error.to_string() })
        };
        let mut preset: RunPreset = typed(&tree)?;
        // Through the type and back, so that values that are left to their defaults can be overridden too.
        fill(&mut tree, &preset)?;
        for text in overrides {
            let key = tree.set(text, prefix)?;
            tree.hold_key("phases", &key);
        }
        preset = typed(&tree)?;
        fill(&mut tree, &preset)?;
        preset.check().map_err(|error| tree.locate(error, place))?;
        Ok(Self { preset, origins: tree, files })
    }
}

impl RunPreset {
    /// Reads a preset by built-in name or file path, lays it over its bases, and applies `KEY=VALUE` overrides.
    ///
    /// A preset may say `base = "NAME|FILE"` at the top: a built-in preset, or a path relative to the file. What a preset or an override
    /// says holds in every phase of the presets below.
    ///
    /// # Errors
    /// [`TrainError::Preset`] naming file and line or override, key, expected and found.
    pub fn resolve(name: &str, overrides: &[String]) -> Result<Self, TrainError> {
        Ok(Resolved::load(name, overrides, "")?.preset)
    }

    /// Reads the resolved preset that a program wrote, and applies overrides. Keys that this program does not know are left out where the
    /// text turns them off.
    ///
    /// # Errors
    /// If the text is not one, turns on what this program does not have, or an override does not apply.
    pub fn from_resolved(place: &str, text: &str, overrides: &[String]) -> Result<Self, TrainError> {
        Ok(Resolved::of_text(place, text, overrides)?.preset)
    }

    /// The resolved preset that a run saved in its folder, with overrides.
    ///
    /// # Errors
    /// If the folder holds none, or an override does not apply.
    pub fn of_run(run: &Path, overrides: &[String]) -> Result<Self, TrainError> {
        Ok(Resolved::of_run(run, overrides)?.preset)
    }

    /// What held when a checkpoint was written.
    ///
    /// # Errors
    /// If it holds no preset, one that turns on what this program does not have, or one that is damaged.
    pub fn of_checkpoint(checkpoint: &Checkpoint) -> Result<Self, TrainError> {
        let path = checkpoint.path();
        let fail = |message: String| TrainError::Checkpoint { path: path.to_owned(), message };
        let text = checkpoint
            .blob(PRESET_FILE)
            .ok_or_else(|| fail(format!("expected an entry '{PRESET_FILE}' (text), found none")))?;
        let text = std::str::from_utf8(text).map_err(|error| fail(format!("{PRESET_FILE}: {error}")))?;
        Self::from_resolved(PRESET_FILE, text, &[]).map_err(|error| fail(error.to_string()))
    }
}

impl Resolved {
    /// [`Resolved::of_text`] of a run folder.
    ///
    /// # Errors
    /// If the folder holds no preset, or an override does not apply.
    pub fn of_run(run: &Path, overrides: &[String]) -> Result<Self, TrainError> {
        let path = run.join(PRESET_FILE);
        let text = fs::read_to_string(&path).map_err(TrainError::read(&path))?;
        Self::of_text(&path.to_string_lossy(), &text, overrides)
    }
}

/// Reads a preset and lays it over its bases; `files` gets their names.
fn read(name: &str, folder: &Path, files: &mut Vec<String>) -> Result<Tree, TrainError> {
    let (file, text, folder) = match builtin().find(|(builtin, ..)| *builtin == name) {
        Some((_, file, text)) => (file.to_owned(), text.to_owned(), PathBuf::new()),
        None => {
            let path = folder.join(name);
            // A path has an ending; a built-in name has none.
            if path.extension().is_none_or(|e| e != "toml") {
                let names = builtin().map(|(name, ..)| name).collect::<Vec<_>>().join(", ");
                return Err(TrainError::Preset {
                    place: files.last().map_or(name, String::as_str).to_owned(),
                    message: format!(
                        "expected a built-in preset ({names}) or the path of a .toml file, found '{name}'"
                    ),
                });
            }
            let text = fs::read_to_string(&path).map_err(TrainError::read(&path))?;
            let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
            (path.to_string_lossy().into_owned(), text, folder)
        }
    };
    let mut tree = Tree::parse(&file, &text)?;
    tree.expand_surfaces(&folder)?;
    let place = tree.origin("base").to_string();
    let fail = |message: String| TrainError::Preset { place, message };
    files.push(file);
    match tree.take("base").and_then(|base| base.value("")) {
        None => Ok(tree),
        Some(Value::String(_)) if files.len() > DEPTH => Err(fail(format!(
            "base: expected at most {DEPTH} presets below one another, found {}",
            files.join(", ")
        ))),
        Some(Value::String(base)) => {
            let mut bottom = read(&base, &folder, files)?;
            bottom.hold("phases", &tree);
            bottom.lay(tree);
            Ok(bottom)
        }
        Some(base) => Err(fail(format!("base: expected a name or path, found {base}"))),
    }
}

/// A user's file over a variant over a preset over the paper's, and no deeper: it would be unreadable.
const DEPTH: usize = 4;
