//! `cargo xtask pictures`: the README's pictures, made by the program that they show.

mod browser;
mod speed;

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use paid_files::FileError;
use tempfile::TempDir;
use thiserror::Error;

use browser::Browser;

const HELP: &str = "usage: cargo xtask pictures [--paid FILE] [--browser FILE] [NAME]...\n\n\
    Makes the pictures in docs/src/pictures again, or only those named, with fixed seeds, in about 5 minutes on two cores.\n\
    It prints what it made, and the reason for each picture that it could not make; that file stays as it was.\n\n  \
    --paid FILE      the program [default: target/release/paid]; build it with\n                   \
    'cargo build --release --features full'\n  \
    --browser FILE   a Chromium [default: chromium or google-chrome on the PATH]\n\n\
    speed        the speed chart, from the figures in xtask/src/pictures/speed.rs; runs nothing\n\
    score        paths of 63 shots in MuJoCo; needs MuJoCo ('cargo mujoco')\n\
    perception   onboard perception's estimate of the ball in one shot; needs MuJoCo and 'full'\n\
    own-kick     a human's kick and the robot's; needs mocap.cs.cmu.edu's 10_02.amc and 10.asf in data/mocap/cmu\n             \
    of the folder that PAID_SHARED names\n\
    page         the page of 'paid demo --live'; needs a browser\n\
    train        the page of 'paid train --live' after two minutes; needs a browser\n\
    robot        the page of 'paid robot sim --lockstep --live'; needs a browser, MuJoCo and 'full'\n\n\
    shot.gif is not made here: it was recorded from the page of 'paid demo --live', frame by frame. The pictures of a page\n\
    show a moment that depends on the machine's speed.";

/// All pictures together may have this size `[B]`.
const MOST: u64 = 3_000_000;
/// Ports of the pages, away from the program's own.
const PORT: u16 = 47_470;
const DEMO: [&str; 2] = ["--policy", "policies/demo/policy.onnx"];
/// How long a page may take to show what is waited for. A loaded machine is slow.
const LONGEST: Duration = Duration::from_secs(300);

/// Why a picture could not be made.
#[derive(Debug, Error)]
pub enum Error {
    /// Something is missing that the user can provide.
    #[error("{0}")]
    Missing(String),
    /// The program failed.
    #[error("'paid {command}' failed: {stderr}")]
    Program {
        /// Its arguments.
        command: String,
        /// The end of what it wrote to its standard error.
        stderr: String,
    },
    /// The browser failed.
    #[error("the browser failed: {0}")]
    Browser(String),
    /// A file could not be read or written, or a program could not be started.
    #[error(transparent)]
    File(#[from] FileError),
}

/// What the pictures are made with.
struct Studio {
    /// The repository.
    root: PathBuf,
    paid: PathBuf,
    browser: Option<PathBuf>,
    scratch: TempDir,
}

/// A program that is stopped when its picture is taken.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

type Make = fn(&Studio) -> Result<Vec<u8>, Error>;

/// Each picture: its name, its file and how it is made. The cheap ones come first.
const PICTURES: [(&str, &str, Make); 7] = [
    ("speed", "speed.svg", |_| Ok(speed::svg().into_bytes())),
    ("score", "score.svg", score),
    ("own-kick", "own-kick.png", own_kick),
    ("page", "page.png", page),
    ("robot", "robot.png", robot),
    ("train", "train.png", train),
    ("perception", "perception.svg", perception),
];

/// Makes the pictures that `options` name.
pub fn command(options: &[&str]) -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_owned).unwrap_or_default();
    let (mut paid, mut browser) = (root.join("target/release/paid"), browser::find());
    let mut names = Vec::new();
    let mut rest = options.iter();
    while let Some(option) = rest.next() {
        match *option {
            "--help" | "-h" => {
                println!("{HELP}");
                return ExitCode::SUCCESS;
            }
            "--paid" | "--browser" => {
                let Some(file) = rest.next().map(PathBuf::from) else {
                    return refused(&format!("{option}: expected a file, found nothing"));
                };
                if !file.is_file() {
                    return refused(&format!("{option}: {} is no file", file.display()));
                }
                let file = std::path::absolute(&file).unwrap_or(file);
                if *option == "--paid" {
                    paid = file;
                } else {
                    browser = Some(file);
                }
            }
            name if PICTURES.iter().any(|p| p.0 == name) => names.push(name),
            other => return refused(&format!("'{other}' is neither an option nor a picture")),
        }
    }
    let scratch = match tempfile::tempdir() {
        Ok(folder) => folder,
        Err(error) => return refused(&format!("no temporary folder: {error}")),
    };
    let studio = Studio { root, paid, browser, scratch };
    let folder = studio.root.join("docs/src/pictures");
    let mut whole = true;
    for (name, file, make) in PICTURES.iter().filter(|p| names.is_empty() || names.contains(&p.0)) {
        let path = folder.join(file);
        let made = make(&studio).and_then(|bytes| {
            fs::write(&path, &bytes).map_err(FileError::at(&path))?;
            Ok(bytes.len())
        });
        match made {
            Ok(size) => println!("{name}: docs/src/pictures/{file}, {} kB", size.div_ceil(1000)),
            Err(error) => {
                whole = false;
                eprintln!("{name}: not made: {error}");
            }
        }
    }
    match total(&folder) {
        Ok(size) if size <= MOST => {
            println!("all pictures: {:.2} MB of {} MB", size as f64 * 1e-6, MOST / 1_000_000);
        }
        Ok(size) => {
            whole = false;
            eprintln!("all pictures: {:.2} MB, expected at most {} MB", size as f64 * 1e-6, MOST / 1_000_000);
        }
        Err(error) => return refused(&error.to_string()),
    }
    if whole { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn refused(message: &str) -> ExitCode {
    eprintln!("error: {message}; 'cargo xtask pictures --help' lists the options");
    ExitCode::from(2)
}

/// Size of the files of a folder `[B]`.
fn total(folder: &Path) -> Result<u64, Error> {
    let mut size = 0;
    for file in fs::read_dir(folder).map_err(FileError::at(folder))? {
        let file = file.map_err(FileError::at(folder))?;
        size += file.metadata().map_err(FileError::at(&file.path()))?.len();
    }
    Ok(size)
}

impl Studio {
    /// The program, to be run in the repository.
    fn command(&self, arguments: &[&str]) -> Result<Command, Error> {
        if !self.paid.is_file() {
            return Err(Error::Missing(format!(
                "{} does not exist; run 'cargo build --release --features full', or name the program with --paid",
                self.paid.display()
            )));
        }
        let mut command = Command::new(&self.paid);
        command.args(arguments).current_dir(&self.root).stdin(Stdio::null());
        Ok(command)
    }

    /// Runs the program to its end.
    fn run(&self, arguments: &[&str]) -> Result<(), Error> {
        let output = self.command(arguments)?.output().map_err(FileError::at(&self.paid))?;
        if output.status.success() {
            return Ok(());
        }
        let stderr = String::from_utf8_lossy(&output.stderr);
        let mut lines = stderr.trim_end().lines();
        let error = lines.clone().find(|line| line.starts_with("error")).or_else(|| lines.next_back());
        let tail = error.unwrap_or("it says nothing").to_owned();
        Err(Error::Program { command: arguments.join(" "), stderr: tail })
    }

    /// Starts the program with its output in the scratch folder.
    fn start(&self, arguments: &[&str]) -> Result<Running, Error> {
        let log = self.scratch.path().join("log");
        let file = fs::File::options().create(true).append(true).open(&log).map_err(FileError::at(&log))?;
        let twin = file.try_clone().map_err(FileError::at(&log))?;
        let child = self.command(arguments)?.stdout(file).stderr(twin).spawn();
        Ok(child.map(Running).map_err(FileError::at(&self.paid))?)
    }

    /// A file or folder of the scratch folder.
    fn out(&self, name: &str) -> String {
        self.scratch.path().join(name).to_string_lossy().into_owned()
    }

    fn read(&self, name: &str) -> Result<Vec<u8>, Error> {
        let path = self.scratch.path().join(name);
        Ok(fs::read(&path).map_err(FileError::at(&path))?)
    }

    /// A browser that shows the page of a program at `port`.
    fn visit(&self, port: u16) -> Result<Browser, Error> {
        let program = self.browser.as_deref().ok_or_else(|| {
            Error::Missing(format!(
                "no Chromium found (looked for {} on the PATH); name one with --browser",
                browser::NAMES.join(", ")
            ))
        })?;
        // A page of 1120 pixels, drawn at three quarters.
        let mut browser = Browser::start(program, self.scratch.path(), [1120, 700], 0.75)?;
        let start = Instant::now();
        while std::net::TcpStream::connect(("127.0.0.1", port)).is_err() {
            if start.elapsed() > Duration::from_secs(60) {
                return Err(Error::Missing(format!("the program serves no page at port {port}")));
            }
            std::thread::sleep(Duration::from_millis(200));
        }
        browser.open(&format!("http://127.0.0.1:{port}/"))?;
        browser.wait("typeof paid == 'object' && paid.link", LONGEST)?;
        Ok(browser)
    }
}

/// `paid eval shooting` in MuJoCo: where each ball went.
fn score(studio: &Studio) -> Result<Vec<u8>, Error> {
    let out = studio.out("scores");
    let what = ["--engine", "mujoco", "--effective", "--trials", "1", "--strips", "0", "--out", &out];
    studio.run(&[&["eval", "shooting"], &DEMO[..], &what].concat())?;
    studio.read("scores/mujoco_static_paths.svg")
}

/// `paid eval shooting --eyes`: truth, what was seen and what was estimated, in one shot.
fn perception(studio: &Studio) -> Result<Vec<u8>, Error> {
    // Says so where the program was built without it.
    studio.run(&["perceive", "--help"])?;
    let out = studio.out("seen");
    let what = ["--engine", "mujoco", "--effective", "--trials", "1", "--eyes", "--plot", "31", "--out"];
    studio.run(&[&["eval", "shooting"], &DEMO[..], &what, &[&out]].concat())?;
    let kick = String::from_utf8_lossy(&studio.read("seen/eyes_static_kick.svg")?).into_owned();
    // The upper of two diagrams: the distance ahead.
    Ok(kick
        .replacen(r#"height="1200" viewBox="0 0 900 1200""#, r#"height="600" viewBox="0 0 900 600""#, 1)
        .into_bytes())
}

/// `paid play kick.amc`: a moment of a human's kick and the robot's.
fn own_kick(studio: &Studio) -> Result<Vec<u8>, Error> {
    let shared = std::env::var_os("PAID_SHARED").unwrap_or_else(|| OsString::from("../shared"));
    let kick = studio.root.join(shared).join("data/mocap/cmu/10_02.amc");
    if !kick.is_file() {
        return Err(Error::Missing(format!(
            "{} does not exist; set PAID_SHARED to a folder that has data/mocap/cmu/10_02.amc and 10.asf, \
             which mocap.cs.cmu.edu offers",
            kick.display()
        )));
    }
    let (kick, out) = (kick.to_string_lossy(), studio.out("both"));
    studio.run(&["play", &kick, "--from", "2", "--size", "640x400", "--record", &out])?;
    studio.read("both/frame_0020.png")
}

/// `paid demo --live`, in the fifth kick.
fn page(studio: &Studio) -> Result<Vec<u8>, Error> {
    let _demo =
        studio.start(&["demo", "--live", "--out", &studio.out("demo"), "--port", &PORT.to_string()])?;
    let mut browser = studio.visit(PORT)?;
    browser
        .wait("paid.panel.shots >= 4 && paid.course.newest.kicking && paid.course.newest.touched", LONGEST)?;
    browser.screenshot()
}

/// `paid train --live`, after two minutes.
fn train(studio: &Studio) -> Result<Vec<u8>, Error> {
    let (port, out) = ((PORT + 1).to_string(), studio.out("stage1"));
    let what =
        ["train", "stage1", "--live", "--port", &port, "--out", &out, "--set", "run.checkpoint_interval=25"];
    let _training = studio.start(&what)?;
    let begun = Instant::now();
    let mut browser = studio.visit(PORT + 1)?;
    while begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_secs(1));
    }
    browser.wait("paid.state.moment != null && paid.course.newest.fallen === false", LONGEST)?;
    browser.screenshot()
}

/// `paid robot sim --lockstep --live`: the second ball of a match on its way, and where the runtime estimates it.
fn robot(studio: &Studio) -> Result<Vec<u8>, Error> {
    studio.run(&["robot", "--help"])?;
    let port = (PORT + 2).to_string();
    let _sim =
        studio.start(&[&["robot", "sim", "--lockstep", "--live", "--port", &port], &DEMO[..]].concat())?;
    let mut browser = studio.visit(PORT + 2)?;
    browser.wait("paid.view.scene && (document.getElementById('layer-belief').click(), true)", LONGEST)?;
    browser.wait(
        "paid.panel.shots >= 1 && paid.course.newest.kicking && paid.course.newest.ballSpeed > 1.5",
        LONGEST,
    )?;
    browser.screenshot()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_pictures_are_small() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src/pictures");
        let size = total(&folder).expect("the pictures");
        assert!(size <= MOST, "{size} bytes of pictures, expected at most {MOST}");
        for (name, file, _) in PICTURES {
            assert!(folder.join(file).is_file(), "{file}");
            assert!(HELP.contains(&format!("\n{name} ")), "the help does not explain {name}");
        }
    }
}
