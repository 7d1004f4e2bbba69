//! What ranks exchange before anything is written. One that would not do the same work is refused by name.

use std::fmt::{Debug, Display};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::OnceLock;

use paid_learn::Ranks;
use paid_play::{ReferenceClip, ReferenceLibrary};
use paid_task::preset::ReferenceSource;

use crate::setup::clips_of;
use crate::{RunPreset, Scene, TrainError};

/// A rank's description of itself: one thing a line.
#[derive(Clone, Debug, Default)]
pub struct Introduction {
    text: String,
}

impl Introduction {
    /// A thing and its value.
    pub fn tell(&mut self, thing: &str, value: impl Display) {
        self.text.push_str(&format!("{thing} {value}\n"));
    }

    /// All that another introduction holds.
    pub fn tell_all(&mut self, other: &Self) {
        self.text.push_str(&other.text);
    }

    /// The lines of a TOML text, each with its table.
    pub fn tell_toml(&mut self, toml: &str) {
        let mut table = "";
        for line in toml.lines().filter(|line| !line.is_empty()) {
            if line.starts_with('[') {
                table = line;
            } else {
                let space = if table.is_empty() { "" } else { " " };
                self.text.push_str(&format!("{table}{space}{}\n", line.trim()));
            }
        }
    }

    /// Options of a command, a line each.
    pub fn tell_options(&mut self, options: &dyn Debug) {
        self.text.extend(format!("{options:#?}").lines().flat_map(|line| [line.trim(), "\n"]));
    }

    /// The contents of a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn tell_file(&mut self, thing: &str, path: &Path) -> Result<(), TrainError> {
        self.tell(thing, print_of(path)?);
        Ok(())
    }

    /// Preset, instruction set, robot and motions of a run.
    ///
    /// # Errors
    /// If the motions of its style reward cannot be read.
    pub fn tell_run(&mut self, preset: &RunPreset, scene: &Scene) -> Result<(), TrainError> {
        self.tell("instruction set", preset.isa().map_err(TrainError::Setup)?);
        self.tell_toml(&preset.to_toml()?);
        self.tell_robot(&(&scene.model, &scene.spec));
        self.tell_motions(&scene.library);
        if preset.amp.is_some() && preset.task.reference == ReferenceSource::None {
            self.tell_motions(&clips_of(preset, &scene.model, &scene.spec)?);
        }
        Ok(())
    }

    /// A robot's tree and specification.
    pub fn tell_robot(&mut self, robot: &dyn Debug) {
        let text = format!("{robot:?}");
        self.tell("robot", Print::default().with(text.as_bytes()));
    }

    /// The contents of motions: numbers of the clips, and what was derived from them.
    pub fn tell_motions(&mut self, library: &ReferenceLibrary) {
        self.tell("number of motions", library.len());
        for (clip, facts) in library.clips().iter().zip(library.facts()) {
            let thing = format!("motion '{}', {} frames,", clip.name, clip.frames);
            self.tell(&thing, print_of_clip(clip).with(format!("{facts:?}").as_bytes()));
        }
    }
}

/// Refuses ranks that would not do the same: another program, or another of the things that `introduce` adds. Every rank must call it, and
/// each gets the same error. One process alone compares nothing.
///
/// # Errors
/// One sentence naming the rank, its machine, what rank 0 has and what was found; or what `introduce` could not read.
pub fn meet(
    ranks: &dyn Ranks,
    introduce: impl FnOnce(&mut Introduction) -> Result<(), TrainError>,
) -> Result<(), TrainError> {
    if ranks.count() == 1 {
        return Ok(());
    }
    // The machine's name stands first, and is the only thing that may differ.
    let mut own = Introduction { text: format!("{}\n", ranks.host().replace('\n', " ")) };
    own.tell("program", program()?);
    introduce(&mut own)?;
    let all = ranks.gather(own.text.as_bytes());
    let texts: Vec<String> = all.iter().map(|text| String::from_utf8_lossy(text).into_owned()).collect();
    match refusal(&texts) {
        Some(message) => Err(TrainError::Ranks(message)),
        None => Ok(()),
    }
}

/// The names of all ranks' machines. Every rank must call it.
pub(crate) fn hosts(ranks: &dyn Ranks) -> Vec<String> {
    let all = ranks.gather(ranks.host().as_bytes());
    all.iter().map(|host| String::from_utf8_lossy(host).into_owned()).collect()
}

/// The first difference from rank 0, if there is one.
fn refusal(texts: &[String]) -> Option<String> {
    let parts: Vec<(&str, &str)> =
        texts.iter().map(|text| text.split_once('\n').unwrap_or((text, ""))).collect();
    let (first, expected) = *parts.first()?;
    let quoted =
        |line: Option<&str>| line.map_or_else(|| "nothing more".to_owned(), |line| format!("'{line}'"));
    parts.iter().enumerate().find_map(|(rank, (host, found))| {
        let (mut expected, mut found) = (expected.lines(), found.lines());
        loop {
            let (expected, found) = (expected.next(), found.next());
            if expected != found {
                let (expected, found) = (quoted(expected), quoted(found));
                return Some(format!(
                    "rank {rank} on {host}: expected {expected}, as rank 0 on {first} has, found {found}"
                ));
            }
            expected?;
        }
    })
}

/// Length and check sum of contents that should be equal: a difference is an accident, not an attack.
#[derive(Clone, Copy, Default)]
struct Print {
    bytes: usize,
    crc: u32,
}

impl Print {
    /// With these bytes after the others.
    fn with(self, bytes: &[u8]) -> Self {
        Self { bytes: self.bytes + bytes.len(), crc: crc32c::crc32c_append(self.crc, bytes) }
    }
}

impl Display for Print {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "of {} bytes, CRC-32C {:08x}", self.bytes, self.crc)
    }
}

/// The program that runs here. It is read once.
fn program() -> Result<Print, TrainError> {
    static PROGRAM: OnceLock<Print> = OnceLock::new();
    if let Some(print) = PROGRAM.get() {
        return Ok(*print);
    }
    let path = std::env::current_exe()
        .map_err(|error| TrainError::Setup(format!("the program's own file: {error}")))?;
    let print = print_of(&path)?;
    Ok(*PROGRAM.get_or_init(|| print))
}

fn print_of(path: &Path) -> Result<Print, TrainError> {
    let mut file = File::open(path).map_err(TrainError::read(path))?;
    let (mut print, mut part) = (Print::default(), vec![0_u8; 1 << 20]);
    loop {
        match file.read(&mut part).map_err(TrainError::read(path))? {
            0 => return Ok(print),
            length => print = print.with(&part[..length]),
        }
    }
}

fn print_of_clip(clip: &ReferenceClip) -> Print {
    let parts = [
        &clip.joint_pos[..],
        &clip.joint_vel,
        clip.body_pos.as_flattened(),
        clip.body_quat.as_flattened(),
        clip.body_com_vel.as_flattened(),
        clip.body_ang_vel.as_flattened(),
    ];
    parts.iter().fold(Print::default(), |print, part| {
        print.with(&part.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>())
    })
}

#[cfg(test)]
mod tests {
    use paid_learn::Alone;
    use paid_learn::ranks::ThreadRanks;

    use super::*;

    /// The outcome of a meeting of as many ranks as there are introductions.
    fn outcome(introductions: &[&str]) -> Vec<Option<String>> {
        std::thread::scope(|scope| {
            let threads: Vec<_> = ThreadRanks::of(introductions.len())
                .into_iter()
                .zip(introductions)
                .map(|(ranks, toml)| {
                    scope.spawn(move || {
                        let met = meet(&ranks, |own| {
                            own.tell_toml(toml);
                            Ok(())
                        });
                        met.err().map(|error| error.to_string())
                    })
                })
                .collect();
            threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        })
    }

    #[test]
    fn every_rank_learns_which_rank_differs_and_in_what() {
        let first = "seed = 1\n\n[learn.ppo]\nepochs = 2\n";
        assert_eq!(outcome(&[first, first, first]), [None, None, None]);
        let other = "seed = 1\n\n[learn.ppo]\nepochs = 3\n";
        let message = "rank 2 on this machine: expected '[learn.ppo] epochs = 2', as rank 0 on this machine has, \
                       found '[learn.ppo] epochs = 3'";
        assert_eq!(outcome(&[first, first, other]), vec![Some(message.to_owned()); 3]);
    }

    #[test]
    fn one_who_tells_less_or_more_is_refused_as_well() {
        let message = |expected, found| {
            let text = format!("a\nprogram x\n{expected}");
            refusal(&[text, format!("b\nprogram x\n{found}")]).expect("refuses")
        };
        assert_eq!(
            message("seed = 1\n", ""),
            "rank 1 on b: expected 'seed = 1', as rank 0 on a has, found nothing more"
        );
        assert_eq!(
            message("", "seed = 1\n"),
            "rank 1 on b: expected nothing more, as rank 0 on a has, found 'seed = 1'"
        );
        assert_eq!(refusal(&["a\nx".to_owned(), "b\nx".to_owned()]), None, "another machine may be");
    }

    #[test]
    fn a_print_tells_a_changed_byte_and_an_added_one() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("file");
        let of = |bytes: &[u8]| {
            std::fs::write(&path, bytes).expect("writes");
            print_of(&path).expect("reads").to_string()
        };
        // The published check value of CRC-32C.
        assert_eq!(of(b"123456789"), "of 9 bytes, CRC-32C e3069283");
        assert_ne!(of(b"123456780"), of(b"123456789"));
        assert_eq!(of(b""), "of 0 bytes, CRC-32C 00000000");
        assert!(print_of(&folder.path().join("none")).is_err());
    }

    #[test]
    fn a_process_alone_reads_nothing() {
        assert!(meet(&Alone, |_| Err(TrainError::Setup("read".to_owned()))).is_ok());
    }
}
