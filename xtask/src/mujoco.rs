//! `cargo mujoco`: the MuJoCo library out of its Python wheel.
//!
//! pip chooses and verifies the wheel of this platform (the library inside does not depend on the Python version); the one
//! file that is needed is copied to `<target folder>/mujoco/`, where `paid-mujoco` looks for it. No build script downloads
//! anything: who does not run this command gets a build and tests without MuJoCo.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use paid_files::FileError;
use thiserror::Error;

/// The version that the bindings in `paid-mujoco` are written for.
const VERSION: &str = "3.17.0";
/// The wheel for this Python is taken whatever Python runs pip.
const WHEEL_PYTHON: &str = "3.12";

/// Why the library could not be fetched.
#[derive(Debug, Error)]
pub enum Error {
    /// No Python with pip.
    #[error(
        "pip was not found (tried {tried}); install Python 3 with pip, or set the environment variable MUJOCO_LIB to a \
         libmujoco {VERSION} that you have"
    )]
    NoPip {
        /// The commands that were tried.
        tried: String,
    },
    /// pip did not deliver.
    #[error("'{command}' failed:\n{stderr}")]
    Pip {
        /// The command line.
        command: String,
        /// What it wrote to its standard error.
        stderr: String,
    },
    /// The download holds no wheel, or the wheel no library.
    #[error("{place}: expected {expected}, found none")]
    Missing {
        /// Folder or file.
        place: PathBuf,
        /// What should be there.
        expected: String,
    },
    /// The wheel is damaged.
    #[error("{file}: {source}")]
    Wheel {
        /// The wheel.
        file: PathBuf,
        /// What is wrong.
        source: zip::result::ZipError,
    },
    /// A file could not be read or written, or a program could not be started.
    #[error(transparent)]
    File(#[from] FileError),
}

/// File name of the library on this platform, as in the wheel.
fn library_name() -> String {
    match std::env::consts::OS {
        "macos" => format!("libmujoco.{VERSION}.dylib"),
        "windows" => "mujoco.dll".to_owned(),
        _ => format!("libmujoco.so.{VERSION}"),
    }
}

/// Fetches the library unless it is there already; returns its path.
///
/// # Errors
/// If pip is missing or fails, the wheel is not as expected, or a file cannot be written.
pub fn install() -> Result<PathBuf, Error> {
    let program = std::env::current_exe().map_err(FileError::at(Path::new("the running program")))?;
    // The program lies in <target folder>/<profile>/.
    let target = program.ancestors().nth(2).unwrap_or(Path::new("target"));
    let folder = target.join("mujoco");
    let library = folder.join(library_name());
    if library.is_file() {
        return Ok(library);
    }
    let download = folder.join("download.tmp");
    if download.exists() {
        fs::remove_dir_all(&download).map_err(FileError::at(&download))?;
    }
    fs::create_dir_all(&download).map_err(FileError::at(&download))?;
    let result = download_wheel(&download).and_then(|wheel| extract(&wheel, &library));
    fs::remove_dir_all(&download).map_err(FileError::at(&download))?;
    result.map(|()| library)
}

/// Lets pip download the wheel into `folder`; returns the wheel.
fn download_wheel(folder: &Path) -> Result<PathBuf, Error> {
    let candidates: [&[&str]; 4] = [&["python3", "-m", "pip"], &["python", "-m", "pip"], &["pip3"], &["pip"]];
    let has_pip = |pip: &&&[&str]| {
        Command::new(pip[0]).args(&pip[1..]).arg("--version").output().is_ok_and(|o| o.status.success())
    };
    let Some(pip) = candidates.iter().find(has_pip) else {
        let tried = candidates.iter().map(|c| format!("'{}'", c.join(" "))).collect::<Vec<_>>().join(", ");
        return Err(Error::NoPip { tried });
    };
    let requirement = format!("mujoco=={VERSION}");
    let mut command = Command::new(pip[0]);
    command.args(&pip[1..]).args(["download", &requirement, "--no-deps", "--only-binary=:all:"]);
    command.args(["--python-version", WHEEL_PYTHON, "--disable-pip-version-check", "--no-input", "--quiet"]);
    command.arg("--dest").arg(folder);
    eprintln!("fetching MuJoCo {VERSION} with '{}'", pip.join(" "));
    let output = command.output().map_err(FileError::at(Path::new(pip[0])))?;
    if !output.status.success() {
        return Err(Error::Pip {
            command: format!("{} download {requirement}", pip.join(" ")),
            stderr: String::from_utf8_lossy(&output.stderr).trim_end().to_owned(),
        });
    }
    let entries = fs::read_dir(folder).map_err(FileError::at(folder))?;
    let wheel =
        entries.filter_map(Result::ok).map(|e| e.path()).find(|p| p.extension() == Some(OsStr::new("whl")));
    wheel.ok_or_else(|| Error::Missing { place: folder.to_owned(), expected: "a wheel (*.whl)".to_owned() })
}

/// Copies the library out of `wheel` to `library`, whole or not at all.
fn extract(wheel: &Path, library: &Path) -> Result<(), Error> {
    let wheel_error = |source| Error::Wheel { file: wheel.to_owned(), source };
    let file = File::open(wheel).map_err(FileError::at(wheel))?;
    let mut archive = zip::ZipArchive::new(file).map_err(wheel_error)?;
    let suffix = format!("/{}", library_name());
    let names = archive.file_names().filter_map(Result::ok).map(std::borrow::Cow::into_owned);
    let inside = names.into_iter().find(|n| n.ends_with(&suffix));
    let Some(inside) = inside else {
        return Err(Error::Missing { place: wheel.to_owned(), expected: library_name() });
    };
    let mut source = archive.by_name(&inside).map_err(wheel_error)?;
    let copied = paid_files::replace(library, |out| io::copy(&mut source, out).map(drop));
    Ok(copied.map_err(FileError::at(library))?)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn wheel_with(folder: &Path, name: &str) -> PathBuf {
        let path = folder.join("x.whl");
        let mut writer = zip::ZipWriter::new(File::create(&path).unwrap());
        writer.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        writer.write_all(b"library").unwrap();
        writer.finish().unwrap();
        path
    }

    #[test]
    fn the_library_is_copied_out_of_the_wheel() {
        let folder = tempfile::tempdir().unwrap();
        let wheel = wheel_with(folder.path(), &format!("mujoco/{}", library_name()));
        let library = folder.path().join(library_name());
        extract(&wheel, &library).unwrap();
        assert_eq!(fs::read(library).unwrap(), b"library");
    }

    #[test]
    fn a_wheel_without_library_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let wheel = wheel_with(folder.path(), "mujoco/other.so");
        let error = extract(&wheel, &folder.path().join("l")).unwrap_err().to_string();
        assert!(error.contains("x.whl") && error.contains(&library_name()), "{error}");
        assert!(!folder.path().join("l").exists());
    }

    #[test]
    fn a_damaged_wheel_is_refused_and_leaves_no_library() {
        let folder = tempfile::tempdir().unwrap();
        let wheel = folder.path().join("x.whl");
        fs::write(&wheel, b"no zip").unwrap();
        let error = extract(&wheel, &folder.path().join("l")).unwrap_err().to_string();
        assert!(error.contains("x.whl"), "{error}");
        assert!(!folder.path().join("l").exists());
    }
}
