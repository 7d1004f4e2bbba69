//! What the end-to-end tests share: the program, and a motion of our own.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use paid_motion::{Clip, KickLeg, resample, write_npz};
use paid_robot::{RobotModel, RobotSpec};

/// Runs the program in `folder`.
pub fn paid(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_paid"))
        .args(args)
        .current_dir(folder)
        .output()
        .expect("the program starts")
}

/// True if MuJoCo is here; without it the test, or its part, is skipped.
pub fn mujoco(test: &str) -> bool {
    paid_testing::mujoco(test, paid_mujoco::Library::get()).is_some()
}

/// Sends a process a signal, such as `-INT`. The shell has the command, where no package has brought it.
pub fn kill(signal: &str, process: u32) {
    let status = Command::new("sh").args(["-c", &format!("kill {signal} {process}")]).status();
    assert!(status.expect("a shell").success(), "kill {signal} {process}");
}

/// Standard output as text.
pub fn text(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

/// Standard output after a run that must have succeeded.
pub fn succeeds(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    text(output)
}

/// The one error of a run that must have failed because of its input: exit code 2 and exactly one `error:`.
pub fn refuses(output: &Output) -> String {
    let error = String::from_utf8(output.stderr.clone()).expect("UTF-8");
    assert_eq!(output.status.code(), Some(2), "{error}{}", text(output));
    assert_eq!(error.matches("error:").count(), 1, "{error}");
    assert!(!error.contains("panicked"), "{error}");
    error
}

/// A robot that stands in its default pose and swings a leg: two seconds, made here, without recorded motions.
pub fn swing(kick_leg: KickLeg) -> Clip {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let default_pos = spec.resolve(&model).expect("the built-in robot").default_pos;
    let foot = model.body_index(&spec.feet[kick_leg.index()]).expect("a foot");
    // The first joint of the kicking leg.
    let mut hip = foot;
    while let Some(parent) = model.bodies[hip].parent.filter(|&p| p > 0) {
        hip = parent;
    }
    let (frames, fps) = (60, 30.0);
    let angles = (0..frames).flat_map(|t| {
        let mut angles = default_pos.clone();
        let phase = core::f64::consts::TAU * f64::from(t) / f64::from(frames);
        angles[hip - 1] -= 0.3 * (1.0 - phase.cos());
        angles
    });
    let angles: Vec<f64> = angles.collect();
    let base = vec![([0.0, 0.0, spec.nominal_height_m], [1.0, 0.0, 0.0, 0.0]); frames as usize];
    let clip = Clip::from_poses(&model, fps, &base, &angles);
    let labels = Clip {
        name: "swing".to_owned(),
        path: "swing.npz".into(),
        kick_leg,
        license: Some("CC0".to_owned()),
        ..clip
    };
    resample(&labels, &model, 50.0)
}

/// Writes a clip into `folder/motions`.
pub fn write_clip(folder: &Path, clip: &Clip) {
    let motions = folder.join("motions");
    std::fs::create_dir_all(&motions).expect("a folder");
    let path = motions.join(format!("{}.npz", clip.name));
    write_npz(&path, clip, &RobotModel::g1(), &RobotSpec::g1()).expect("a motion file");
}

/// Writes a swing of each leg into `folder/motions`.
pub fn write_motions(folder: &Path) {
    for leg in [KickLeg::Left, KickLeg::Right] {
        let clip = swing(leg);
        write_clip(folder, &Clip { name: format!("swing_{leg}"), ..clip });
    }
}

/// Arguments that make a stage small enough for a test.
pub const SMALL: [&str; 12] = [
    "--set",
    "run.envs=32",
    "--set",
    "run.shards=2",
    "--set",
    "learn.actor.hidden=[16]",
    "--set",
    "learn.critic.hidden=[16]",
    "--set",
    "learn.ppo.minibatches=2",
    "--set",
    "run.checkpoint_interval=1",
];

/// `args` and [`SMALL`].
pub fn small<'a>(args: &[&'a str]) -> Vec<&'a str> {
    [args, &SMALL].concat()
}

/// A folder with motions and a policy of two iterations in `run`. It is trained once and copied for each test.
pub fn folder() -> tempfile::TempDir {
    static TRAINED: OnceLock<PathBuf> = OnceLock::new();
    let trained = TRAINED.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("trained-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        write_motions(&folder);
        let train =
            ["train", "stage1", "--motions", "motions", "--iterations", "2", "--out", "run", "--quiet"];
        succeeds(&paid(&folder, &small(&train)));
        folder
    });
    let folder = tempfile::tempdir().expect("folder");
    copy(trained, folder.path());
    folder
}

/// Copies what is in a folder.
fn copy(from: &Path, to: &Path) {
    for entry in std::fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        let target = to.join(path.file_name().expect("a name"));
        if path.is_dir() {
            std::fs::create_dir(&target).expect("a folder");
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).expect("a copy");
        }
    }
}
