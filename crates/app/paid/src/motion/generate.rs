//! `paid motion generate`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_motion::generate::{
    GenerateError, GeneratedKick, KickRequest, KickStyle, Look as Looks, generate_builtin, generate_kick,
};
use paid_motion::{KickLeg, write_motion};
use paid_robot::{RobotModel, RobotSpec};
use serde::Serialize;

use super::robot_file::expect_folder;
use crate::failure::Failure;

/// Arguments of `paid motion generate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Output folder; the library goes to its folders standard and powerful.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// One kick for a ball X m ahead and Y m to the left, instead of the library.
    #[arg(long, value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    ball: Option<[f64; 2]>,
    /// Kicking leg of that kick [default: that on the ball's side].
    #[arg(long, requires = "ball")]
    leg: Option<KickLeg>,
    /// How hard that kick is.
    #[arg(long, value_enum, default_value_t = Style::Standard, requires = "ball")]
    style: Style,
    /// How the kicks look. Training without motion files uses plain.
    #[arg(long, value_enum, default_value_t = Look::Plain)]
    look: Look,
    /// Speed of its toe at the ball [m/s] [default: the style's].
    #[arg(long, value_name = "M/S", requires = "ball")]
    speed: Option<f64>,
    /// File format.
    #[arg(long, value_enum, default_value_t = Format::Npz)]
    format: Format,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Style {
    /// Inside of the foot.
    Standard,
    /// Instep, harder.
    Powerful,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Look {
    /// Hips that face the shot, high back-swing.
    Plain,
    /// Closer to people: hips that turn through the strike, straighter legs, arms ahead.
    Natural,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Arrays, as read by training.
    Npz,
    /// Base and joints, for other programs.
    Csv,
}

#[derive(Debug, Serialize)]
struct Written {
    file: String,
    kick_leg: KickLeg,
    ball: [f64; 2],
    duration_s: f64,
    kick_frame: usize,
    /// Least distance of the center of pressure from the edge of the standing soles [m].
    pressure_margin_m: f64,
}

/// Makes the kicks and writes them.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    expect_folder(&args.out)?;
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let kicks = match args.ball {
        Some(ball) => vec![generate_kick(&model, &spec, &request(args, ball)?).map_err(|e| refusal(&e))?],
        None => {
            let look = match args.look {
                Look::Plain => Looks::Plain,
                Look::Natural => Looks::Natural,
            };
            generate_builtin(&model, &spec, look).map_err(Failure::input)?
        }
    };
    let mut lines = Vec::new();
    for kick in &kicks {
        let path = place(args, kick);
        write_motion(&path, &kick.clip, &model, &spec).map_err(Failure::input)?;
        lines.push(Written {
            file: path.display().to_string(),
            kick_leg: kick.clip.kick_leg,
            ball: kick.ball,
            duration_s: kick.clip.duration_s(),
            kick_frame: kick.contact_frame,
            pressure_margin_m: kick.margins().into_iter().fold(f64::INFINITY, f64::min),
        });
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&lines).map_err(Failure::input)?);
        return Ok(ExitCode::SUCCESS);
    }
    for line in &lines {
        println!(
            "{}: {} foot, ball ({:.2}, {:.2}) m, {:.2} s, kick in frame {}, pressure at least {:.1} mm inside",
            line.file,
            line.kick_leg,
            line.ball[0],
            line.ball[1],
            line.duration_s,
            line.kick_frame,
            1e3 * line.pressure_margin_m
        );
    }
    Ok(ExitCode::SUCCESS)
}

/// Why the kick that was asked for cannot be made, with the option that asked.
fn refusal(error: &GenerateError) -> Failure {
    match error {
        // Both start with "ball".
        GenerateError::Ball { .. } | GenerateError::Reach { .. } => Failure::input(format!("--{error}")),
        GenerateError::Robot(_) => Failure::input(error),
    }
}

fn request(args: &Args, ball: [f64; 2]) -> Result<KickRequest, Failure> {
    let mut style = match (args.look, args.style) {
        (Look::Plain, Style::Standard) => KickStyle::standard(),
        (Look::Plain, Style::Powerful) => KickStyle::powerful(),
        (Look::Natural, Style::Standard) => KickStyle::natural(),
        (Look::Natural, Style::Powerful) => KickStyle::natural_powerful(),
    };
    if let Some(speed) = args.speed {
        if !(1.0..=9.0).contains(&speed) {
            return Err(Failure::input(format!("--speed: expected 1 to 9 m/s, found {speed}")));
        }
        style.speed = speed;
    }
    let leg = args.leg.unwrap_or(if ball[1] > 0.0 { KickLeg::Left } else { KickLeg::Right });
    Ok(KickRequest { name: format!("kick_{leg}"), ball, leg, style })
}

fn place(args: &Args, kick: &GeneratedKick) -> PathBuf {
    let extension = match args.format {
        Format::Npz => "npz",
        Format::Csv => "csv",
    };
    let set = kick.clip.path.parent().and_then(Path::file_name).filter(|_| args.ball.is_none());
    let folder = set.map_or_else(|| args.out.clone(), |set| args.out.join(set));
    folder.join(format!("{}.{extension}", kick.clip.name))
}

fn point(text: &str) -> Result<[f64; 2], String> {
    let number = |part: &str| part.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    match text.split_once(',').map(|(x, y)| (number(x), number(y))) {
        Some((Some(x), Some(y))) => Ok([x, y]),
        _ => Err(format!("expected two numbers such as 0.8,-0.3, found '{text}'")),
    }
}
