//! `paid eval film`: images of one episode.

use std::path::PathBuf;

use paid_eval::footage::film_path;
use paid_eval::subject::Subject;
use paid_plot::{Animation, Canvas, Film, Path as BallPath, film_frame, film_strip, plot_paths};

use super::episode::ShotArgs;
use super::out::writable;
use super::subject::Common;
use crate::failure::Failure;

/// Arguments of `paid eval film`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    shot: ShotArgs,
    /// Index of the motion (see `paid motion info`) [default: nearest to the ball].
    ///
    /// Without a ball, the default is the first motion.
    #[arg(long)]
    motion: Option<usize>,
    /// Folder for the images.
    ///
    /// It gets strip.png, paths.png and .svg, numbered frames, and film.gif made from them.
    #[arg(long, value_name = "DIR")]
    frames: PathBuf,
    /// Rate of the numbered frames [Hz]; 0 writes none.
    #[arg(long, default_value_t = 10)]
    rate: u32,
}

/// Plays the episode and writes the images.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.common.setting.one_engine()?;
    let subject = Subject::load(&args.common.spec("paper_stage2")?)?;
    writable("--frames", &args.frames)?;
    let setup = &subject.setup;
    let watched = args.shot.shot(args.motion).watch(&subject, |_| Film::default())?;
    let (film, half_width, dt) = (&watched.kept, watched.goal_half_width_m, setup.preset.control_dt_s());
    let ball = setup.preset.scene.ball.then_some(setup.preset.ball_params.radius_m);
    let save = |image: Canvas, name: &str| image.save(&args.frames.join(name));
    save(film_strip(&setup.robot, film, dt, ball, half_width, 12), "strip.png")?;
    let points = film_path(film);
    let paths = plot_paths(&[BallPath { points: &points, goal: false }], half_width);
    paths.save(&args.frames.join("paths"))?;
    if args.rate > 0 {
        let every = (1.0 / (f64::from(args.rate) * dt)).round().max(1.0) as usize;
        let shown: Vec<usize> = (0..film.poses.len()).step_by(every).collect();
        let gif = args.frames.join("film.gif");
        let mut animation = Animation::create(&gif, [640, 480], 1.0 / (every as f64 * dt), shown.len())?;
        for (i, &t) in shown.iter().enumerate() {
            let image = film_frame(&setup.robot, film, t, ball, half_width, [640, 480]);
            animation.add(&image)?;
            save(image, &format!("frame_{i:04}.png"))?;
        }
        animation.finish()?;
    }
    let poses = film.poses.len();
    println!("{poses} control steps of motion {}: images in {}", watched.motion, args.frames.display());
    Ok(())
}
