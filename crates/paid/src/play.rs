//! `paid play`: moving pictures of a motion, or of a human beside the robot that follows it.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_eval::picture::{Animation, Camera, Canvas, Scene, draw_robot};
use paid_lanes::{Quat, Vec3};
use paid_motion::{Clip, JointOrder, MotionLibrary, ReadOptions, read_motion};
use paid_retarget::{HumanMotion, is_human_file};
use paid_robot::{RobotModel, RobotSpec};

use crate::failure::Failure;
use crate::motion::{How, retarget_file};

/// Arguments of `paid play`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Motion of the robot (.npz, .csv, .pkl), of a human (.bvh, .amc: retargeted, shown beside the robot), or a folder of motions
    /// [default: the built-in kicks].
    input: Option<PathBuf>,
    /// Which clip of a folder or of the built-in kicks: its name, or its number from 0.
    #[arg(long, value_name = "CLIP", default_value = "0")]
    clip: String,
    /// File or folder to write: .gif, .png (animated), or a name without an extension for numbered pictures.
    #[arg(long, value_name = "OUT")]
    record: PathBuf,
    /// Width and height of the pictures [pixels].
    #[arg(long, value_name = "WxH", default_value = "480x360", value_parser = size)]
    size: [usize; 2],
    /// Pictures a second of the recording; motions run at their own speed.
    #[arg(long, value_name = "HZ", default_value_t = 20.0)]
    pictures: f64,
    /// Joint order of a CSV or pickle file that does not state it: model (depth-first) or policy (breadth-first).
    #[arg(long, value_name = "ORDER")]
    joint_order: Option<JointOrder>,
    #[command(flatten)]
    how: How,
}

fn size(text: &str) -> Result<[usize; 2], String> {
    let side = |part: &str| part.trim().parse().ok().filter(|n| (64..=2000).contains(n));
    match text.split_once('x').map(|(w, h)| (side(w), side(h))) {
        Some((Some(w), Some(h))) => Ok([w, h]),
        _ => Err(format!("expected two sizes from 64 to 2000 such as 640x480, found '{text}'")),
    }
}

/// Where the human stands from the robot [m].
const BESIDE: [f64; 3] = [0.0, 1.2, 0.0];
const BONE: [u8; 3] = [70, 120, 190];
const TRAIL: [u8; 3] = [235, 150, 60];

/// Reads the motion and writes the pictures.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    if !(2.0..=50.0).contains(&args.pictures) {
        return Err(Failure::input(format!("--pictures: expected 2 to 50 Hz, found {}", args.pictures)));
    }
    let (clip, human) = open(args, &model, &spec)?;
    let count = (clip.duration_s() * args.pictures + 1e-9).floor() as usize + 1;
    let mut animation =
        Animation::create(&args.record, args.size, args.pictures, count).map_err(Failure::input)?;
    let foot = model.body_index(&spec.feet[clip.kick_leg.index()]).unwrap_or(0);
    let stage = Stage { model: &model, clip: &clip, human: human.as_ref(), foot };
    for k in 0..count {
        let t = ((k as f64 * clip.fps / args.pictures).round() as usize).min(clip.frames - 1);
        animation.add(&stage.picture(t, args.size)).map_err(Failure::input)?;
    }
    animation.finish().map_err(Failure::input)?;
    println!("{}: {count} pictures of {}, {:.2} s", args.record.display(), clip.name, clip.duration_s());
    Ok(ExitCode::SUCCESS)
}

fn open(args: &Args, model: &RobotModel, spec: &RobotSpec) -> Result<(Clip, Option<HumanMotion>), Failure> {
    match &args.input {
        Some(path) if path.is_dir() => pick(MotionLibrary::load_unchanged(path, model, spec), &args.clip),
        None => pick(MotionLibrary::builtin(model, spec, paid_motion::generate::FPS), &args.clip),
        Some(path) if is_human_file(path) => {
            let out = retarget_file(path, &args.how, model, spec)?;
            Ok((out.clip, Some(out.human)))
        }
        Some(path) => {
            let options = ReadOptions { fps: args.how.fps(), kick_leg: None, joint_order: args.joint_order };
            Ok((read_motion(path, model, spec, &options).map_err(Failure::input)?, None))
        }
    }
}

fn pick(
    library: Result<MotionLibrary, paid_motion::MotionError>,
    wanted: &str,
) -> Result<(Clip, Option<HumanMotion>), Failure> {
    let mut clips = library.map_err(Failure::input)?.clips;
    let index = clips.iter().position(|c| c.name == wanted).or_else(|| wanted.parse().ok());
    match index.filter(|i| *i < clips.len()) {
        Some(i) => Ok((clips.swap_remove(i), None)),
        None => {
            let names: Vec<&str> = clips.iter().map(|c| c.name.as_str()).collect();
            let expected = format!("0 to {} or one of {}", clips.len() - 1, names.join(", "));
            Err(Failure::input(format!("--clip: expected {expected}, found '{wanted}'")))
        }
    }
}

struct Stage<'a> {
    model: &'a RobotModel,
    clip: &'a Clip,
    human: Option<&'a HumanMotion>,
    foot: usize,
}

impl Stage<'_> {
    fn picture(&self, t: usize, [width, height]: [usize; 2]) -> Canvas {
        let clip = self.clip;
        let middle = self.centre(t);
        let aside = if self.human.is_some() { 0.5 * BESIDE[1] } else { 0.0 };
        let far = if self.human.is_some() { 1.35 } else { 1.0 };
        let at = |x: f64, y: f64, z: f64| [middle[0] + x, middle[1] + aside + y, z];
        let camera = Camera { eye: at(2.1 * far, -2.3 * far, 1.4), target: at(0.0, 0.0, 0.68), field: 0.62 };
        // Drawn at twice the size and halved: smooth edges.
        let mut scene = Scene::new(2 * width, 2 * height, camera);
        for k in t.saturating_sub((0.5 * clip.fps) as usize)..t {
            scene.sphere(clip.body_pos(k)[self.foot], 0.012, TRAIL);
        }
        if let Some(human) = self.human {
            draw_human(&mut scene, human, t.min(human.frames - 1));
        }
        let rot: Vec<[[f64; 3]; 3]> = clip.body_quat(t).iter().map(|q| Quat(*q).to_mat().0).collect();
        draw_robot(&mut scene, self.model, clip.body_pos(t), &rot);
        let mut image = scene.finish().halved();
        image.text(8, 8, 2, [30; 3], &format!("{:.2} S", t as f64 / clip.fps));
        let speed = Vec3(clip.body_lin_vel(t)[self.foot]).norm();
        image.text(8, 24, 2, [120, 70, 20], &format!("FOOT {speed:.1} M/S"));
        if clip.kick_frame.is_some_and(|kick| t >= kick && (t - kick) as f64 <= 0.4 * clip.fps) {
            image.text(8, 40, 2, [190, 50, 20], "KICK");
        }
        image
    }

    /// Where the camera looks: the base's place, averaged over a second.
    fn centre(&self, t: usize) -> [f64; 2] {
        let reach = (0.5 * self.clip.fps) as usize;
        let range = t.saturating_sub(reach)..(t + reach + 1).min(self.clip.frames);
        let count = range.len() as f64;
        range.fold([0.0; 2], |sum, k| {
            let base = self.clip.body_pos(k)[0];
            [sum[0] + base[0] / count, sum[1] + base[1] / count]
        })
    }
}

/// A stick for every bone.
fn draw_human(scene: &mut Scene, human: &HumanMotion, t: usize) {
    let place = |p: [f64; 3]| (Vec3(p) + Vec3(BESIDE)).0;
    let pos = human.pos(t);
    for p in pos {
        scene.shadow(place(*p), 0.06);
    }
    for (i, bone) in human.skeleton.bones.iter().enumerate() {
        let Some(parent) = bone.parent else { continue };
        // A root that lies on the floor below the hips is no part of the body.
        if parent == 0 && pos[parent][2] < 0.2 {
            continue;
        }
        scene.capsule([place(pos[parent]), place(pos[i])], 0.028, BONE);
        if bone.name.eq_ignore_ascii_case("head") {
            scene.sphere(place(pos[i]), 0.1, BONE);
        }
    }
}
