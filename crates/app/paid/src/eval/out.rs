//! Where the results of an evaluation go.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use paid_eval::EvalError;
use paid_eval::monitor::{Monitor, Timing};

use crate::failure::Failure;

/// Where the results go.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Output {
    /// Print one line of JSON per report instead of tables.
    #[arg(long, help_heading = "Output")]
    pub json: bool,
    /// Write JSON, CSV, tables, images and report.html to this folder.
    #[arg(long, help_heading = "Output", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// True if another process writes and prints.
    #[arg(skip)]
    pub silent: bool,
    /// True if nothing is to be printed. The files are written.
    #[arg(skip)]
    pub mute: bool,
}

impl Output {
    /// Makes the folder, before work is done whose results could not be written.
    ///
    /// # Errors
    /// If it cannot be made or written to.
    pub fn prepare(&self) -> Result<(), Failure> {
        self.folder().map_or(Ok(()), |folder| writable("--out", folder))
    }

    /// Writes to the folder, if there is one.
    pub fn write(&self, write: impl FnOnce(&Path) -> Result<(), EvalError>) -> Result<(), Failure> {
        Ok(self.folder().map_or(Ok(()), write)?)
    }

    /// The folder to write to.
    pub fn folder(&self) -> Option<&Path> {
        self.out.as_deref().filter(|_| !self.silent)
    }

    /// True if no progress is to be printed.
    pub fn quiet(&self) -> bool {
        self.json || self.silent || self.mute
    }

    /// Prints the one form or the other.
    pub fn print(&self, text: &str, json: &str) {
        if !(self.silent || self.mute) {
            println!("{}", if self.json { json } else { text });
        }
    }

    /// True if the evaluation was stopped before its first trial ended. There is no report then, and this says so.
    pub fn nothing(&self, monitor: &Monitor, timing: &Timing) -> bool {
        let nothing = monitor.stopped() && timing.effort.trials == 0;
        if nothing && !(self.silent || self.mute) {
            eprintln!("stopped before the first trial ended: there is nothing to report");
        }
        nothing
    }
}

/// Makes a folder and tries to write to it.
///
/// # Errors
/// If that fails, with the `option` that names the folder.
pub fn writable(option: &str, folder: &Path) -> Result<(), Failure> {
    let place = folder.display();
    if folder.exists() && !folder.is_dir() {
        return Err(Failure::input(format!("{option}: expected a folder, found the file {place}")));
    }
    fs::create_dir_all(folder).and_then(|()| probe(folder)).map_err(|error| {
        Failure::input(format!("{option} {place}: expected a folder that can be written to: {error}"))
    })
}

/// Tries to write into the folder of a file that is to be written later.
///
/// # Errors
/// If that fails, with the file as it was named.
pub fn writable_file(option: &str, file: &Path) -> Result<(), Failure> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    probe(folder).map_err(|error| {
        Failure::input(format!(
            "{option} {}: expected a place that can be written to: {error}",
            file.display()
        ))
    })
}

/// Makes and removes an empty file.
fn probe(folder: &Path) -> io::Result<()> {
    let file = folder.join(format!(".paid-{}.part", std::process::id()));
    fs::File::create(&file)?;
    fs::remove_file(&file)
}

#[cfg(test)]
mod tests {
    use paid_eval::monitor::Effort;

    use super::*;

    #[test]
    fn a_folder_that_cannot_be_written_to_is_told_with_its_option_and_a_new_one_stays_empty() {
        let folder = tempfile::tempdir().expect("folder");
        let of = |name: &str| Output { out: Some(folder.path().join(name)), ..Output::default() }.prepare();
        of("new/one").expect("made");
        assert_eq!(fs::read_dir(folder.path().join("new/one")).expect("a folder").count(), 0);
        fs::write(folder.path().join("file"), "precious").expect("written");
        let error = of("file").expect_err("a file").to_string();
        assert!(error.starts_with("--out: expected a folder, found the file"), "{error}");
        let error = of("file/below").expect_err("below a file").to_string();
        assert!(error.contains("file/below: expected a folder that can be written to"), "{error}");
        let error = writable_file("--out", &folder.path().join("nowhere/a.onnx")).expect_err("no folder");
        let error = error.to_string();
        assert!(error.contains("nowhere/a.onnx: expected") && !error.contains(".part"), "{error}");
        assert_eq!(fs::read_to_string(folder.path().join("file")).expect("reads"), "precious");
    }

    #[test]
    fn a_mute_evaluation_tells_no_progress_and_writes_its_files() {
        let output = Output { mute: true, out: Some(PathBuf::from("eval")), ..Output::default() };
        assert!(output.quiet() && output.folder().is_some());
        assert!(!Output::default().quiet());
    }

    #[test]
    fn an_evaluation_that_was_stopped_before_its_first_trial_has_nothing_to_report() {
        let output = Output { silent: true, ..Output::default() };
        let timing = |trials| Timing::of(Effort { trials, ..Effort::default() }, 1.0);
        let monitor = Monitor::default();
        assert!(!output.nothing(&monitor, &timing(0)));
        monitor.stop();
        assert!(output.nothing(&monitor, &timing(0)));
        assert!(!output.nothing(&monitor, &timing(1)));
    }
}
