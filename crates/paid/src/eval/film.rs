//! `paid eval film`: pictures of one episode.

use std::path::PathBuf;

use paid_eval::episodes::run_episodes;
use paid_eval::picture::{Animation, Canvas, Film, Path as BallPath, film_frame, film_strip, plot_paths};
use paid_eval::shooting::{self, Placement, ShootingOptions};
use paid_task::ForcedStart;

use super::subject::{Common, Subject};
use crate::failure::Failure;

/// Arguments of `paid eval film`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Ball place x,y in the robot's first pose [m]; the nearest motion is chosen [default: the motion's own].
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    ball: Option<[f64; 2]>,
    /// Ball velocity x,y [m/s].
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, default_value = "0,0")]
    velocity: [f64; 2],
    /// Index of the motion (see `paid motion info`) [default: the nearest to the ball, or the first].
    #[arg(long)]
    motion: Option<usize>,
    /// Folder for the pictures: strip.png, paths.png and .svg, numbered frames, and film.gif of them.
    #[arg(long, value_name = "DIR")]
    frames: PathBuf,
    /// Pictures a second of the numbered frames; 0 writes none.
    #[arg(long, default_value_t = 10)]
    rate: u32,
    /// Time limit [s].
    #[arg(long, default_value_t = 10.0)]
    limit: f64,
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|t| t.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y] if x.is_finite() && y.is_finite() && text.matches(',').count() == 1 => Ok([x, y]),
        _ => Err(format!("expected two numbers X,Y, found '{text}'")),
    }
}

/// Plays the episode and writes the pictures.
pub fn run(args: &Args) -> Result<(), Failure> {
    let subject = Subject::load(&args.common, "stage2")?;
    let arena = &subject.arena;
    let motion = match (args.motion, args.ball) {
        (Some(motion), _) => motion,
        (None, Some(ball)) => Placement::new(arena).nearest(ball),
        (None, None) => 0,
    };
    let start =
        ForcedStart { ball_xy: args.ball, ball_velocity: args.velocity, ..ForcedStart::nominal(motion) };
    let limits = ShootingOptions { limit_s: args.limit, ..ShootingOptions::default() };
    let dt = arena.preset.control_dt_s();
    let (control, steps) = shooting::control_of(&limits, dt);
    let maker = &*subject.maker;
    let films =
        run_episodes(arena, maker, &[start], control, steps, |_| Film::default()).map_err(Failure::input)?;
    let Some((_, film)) = films.first() else { return Ok(()) };
    let ball = arena.preset.scene.ball.then_some(arena.preset.ball_params.radius_m);
    let half_width = limits.goal_half_width_m;
    let save = |image: Canvas, name: &str| image.save(&args.frames.join(name)).map_err(Failure::input);
    save(film_strip(&arena.robot, film, dt, ball, half_width, 12), "strip.png")?;
    let points = film.path();
    let paths = plot_paths(&[BallPath { points: &points, goal: false }], half_width);
    paths.save(&args.frames.join("paths")).map_err(Failure::input)?;
    if args.rate > 0 {
        let every = (1.0 / (f64::from(args.rate) * dt)).round().max(1.0) as usize;
        let shown: Vec<usize> = (0..film.poses.len()).step_by(every).collect();
        let gif = args.frames.join("film.gif");
        let mut animation = Animation::create(&gif, [640, 480], 1.0 / (every as f64 * dt), shown.len())
            .map_err(Failure::input)?;
        for (i, &t) in shown.iter().enumerate() {
            let image = film_frame(&arena.robot, film, t, ball, half_width, [640, 480]);
            animation.add(&image).map_err(Failure::input)?;
            save(image, &format!("frame_{i:04}.png"))?;
        }
        animation.finish().map_err(Failure::input)?;
    }
    let poses = film.poses.len();
    println!("{poses} control steps of motion {motion}: pictures in {}", args.frames.display());
    Ok(())
}
