//! The user's clips, before anything is trained.

use std::path::Path;

use paid_motion::MotionLibrary;
use paid_motion::check::doubts;
use paid_play::load_robot;
use paid_train::RunPreset;

use crate::failure::Failure;

/// Refuses clips that cannot be motions of the robot. Unless it is to be `quiet`, a note says which ones fail `paid motion check`. A
/// folder that several presets name is read once; the built-in kicks are good.
pub fn look_at(presets: &[RunPreset], quiet: bool) -> Result<(), Failure> {
    let mut seen = Vec::new();
    for preset in presets {
        let source = (&preset.run.motions, &preset.robot);
        if preset.run.motions.is_empty() || seen.contains(&source) {
            continue;
        }
        seen.push(source);
        let (model, spec) = load_robot(&preset.robot).map_err(Failure::input)?;
        let folder = Path::new(&preset.run.motions);
        let library = MotionLibrary::load_unchanged(folder, &model, &spec).map_err(Failure::input)?;
        library.refuse_implausible(&model, &spec).map_err(Failure::input)?;
        if !quiet && let Some(text) = doubts(&library.clips, &model, &spec).map_err(Failure::input)? {
            eprintln!("note: {}: {text}", folder.display());
        }
    }
    Ok(())
}
