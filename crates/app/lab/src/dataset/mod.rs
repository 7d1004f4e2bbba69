//! What a set of kicks covers: the paper's figures of its data (appendix A), and which kick to record next.
//!
//! The *place* of a kick is where its own ball lies, seen from where the robot's torso begins (x ahead, y left): where the torso ends, or ahead of
//! the foot that strikes ([`OwnPlace`]). The task puts the ball there, and an evaluation gives each ball to the kick whose place is nearest.

mod coverage;
mod draw;

use std::path::Path;

use paid_lanes::Vec3;
use paid_motion::generate::BALL_RADIUS;
use paid_motion::{Clip, KickLeg, ball_ahead, displacement_in_heading, kick_facts};
use paid_play::OwnPlace;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::TaskPreset;
use serde::Serialize;

use paid_eval::shooting::Grid;
use paid_eval::{EvalError, Setting};
use paid_files::{FileError, FileSet};
use paid_plot::Figure;

pub use coverage::{Cell, Coverage, Hole, NextKick, REACH_M};

/// Names of the plots.
pub const PICTURES: [&str; 4] = ["coverage", "placement", "trajectories", "foot_speed"];

/// One kick of the set.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Kick {
    /// Name.
    pub name: String,
    /// The leg that kicks.
    pub leg: KickLeg,
    /// Its place `[m]`.
    pub place: [f64; 2],
    /// The strike as a share of the clip, 0 to 1: the stated frame, or the fastest one of the kicking foot.
    pub strike_phase: f64,
    /// Largest speed of the kicking foot's center of mass `[m/s]`.
    pub peak_foot_speed: f64,
    /// The base's way over the floor `[T]`, from where the torso begins, in its heading `[m]`.
    #[serde(skip)]
    pub path: Vec<[f64; 2]>,
    /// Speed of the kicking foot's center of mass `[T]` `[m/s]`.
    #[serde(skip)]
    pub foot_speed: Vec<f64>,
}

impl Kick {
    fn of(clip: &Clip, robot: &RobotModel, spec: &RobotSpec, place: OwnPlace) -> Option<Self> {
        let facts = kick_facts(clip, robot, spec)?;
        let anchor = robot.body_index(&spec.anchor_body)?;
        let foot = robot.body_index(&spec.feet[clip.kick_leg.index()])?;
        let (heading, origin) = (clip.body_quat(0)[anchor], clip.body_pos(0)[anchor]);
        let strike = clip.kick_frame.unwrap_or(facts.kick_frame);
        let place = match place {
            OwnPlace::TorsoEnd => facts.anchor_displacement,
            OwnPlace::Strike => {
                let (pos, quat) = (clip.body_pos(strike)[foot], clip.body_quat(strike)[foot]);
                let velocity = clip.body_lin_vel(strike)[foot];
                let [x, y] = ball_ahead(&robot.bodies[foot], pos, quat, velocity, BALL_RADIUS);
                displacement_in_heading(heading, origin, [x, y, 0.0])
            }
        };
        Some(Self {
            name: clip.name.clone(),
            leg: clip.kick_leg,
            place,
            strike_phase: strike as f64 / (clip.frames - 1).max(1) as f64,
            peak_foot_speed: facts.peak_foot_speed,
            path: (0..clip.frames)
                .map(|t| displacement_in_heading(heading, origin, clip.body_pos(t)[0]))
                .collect(),
            foot_speed: (0..clip.frames).map(|t| Vec3(clip.body_lin_vel(t)[foot]).norm()).collect(),
        })
    }
}

/// The region of balls that the paper's task draws for a kick: angle and distance of its place, each with a half-width.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sector {
    /// Half-width of the angle `[degrees]`.
    pub angle_deg: f64,
    /// Half-width of the distance `[m]`.
    pub radius_m: f64,
}

/// A set of kicks and what it covers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dataset {
    /// The kicks.
    pub kicks: Vec<Kick>,
    /// The regions of balls around their places.
    pub sector: Sector,
    /// What they cover.
    pub coverage: Coverage,
}

impl Dataset {
    /// Looks at clips, whose own balls lie at `place`, and at how they cover a grid of ball places.
    ///
    /// # Errors
    /// If there is no clip, or the robot lacks a body that its TOML names.
    pub fn new(
        clips: &[Clip],
        robot: &RobotModel,
        spec: &RobotSpec,
        grid: Grid,
        place: OwnPlace,
    ) -> Result<Self, EvalError> {
        let kicks: Option<Vec<Kick>> = clips.iter().map(|clip| Kick::of(clip, robot, spec, place)).collect();
        let kicks = kicks.filter(|kicks| !kicks.is_empty()).ok_or_else(|| EvalError::Option {
            option: Setting::Named("motions"),
            expected: "at least one clip of a robot with the bodies that its TOML names".to_owned(),
            found: format!("{} clips of '{}'", clips.len(), robot.name),
        })?;
        let ball = TaskPreset::builtin("paper_stage2")?.ball;
        let sector = Sector { angle_deg: ball.angle_deg, radius_m: ball.radius_m };
        let coverage = Coverage::of(&kicks, grid);
        Ok(Self { kicks, sector, coverage })
    }

    /// The plot of a name in [`PICTURES`]; `None` for another name.
    pub fn picture(&self, name: &str) -> Option<Figure> {
        Some(match name {
            "trajectories" => draw::trajectories(self),
            "placement" => draw::placement(self),
            "foot_speed" => draw::foot_speed(self),
            "coverage" => draw::coverage(self),
            _ => return None,
        })
    }

    /// Writes [`PICTURES`] as PNG and SVG into a folder.
    ///
    /// # Errors
    /// If a file cannot be written; then none is.
    pub fn write(&self, folder: &Path) -> Result<(), EvalError> {
        let mut files = FileSet::default();
        for (name, figure) in PICTURES.into_iter().filter_map(|name| Some((name, self.picture(name)?))) {
            let [png, svg] = ["png", "svg"].map(|extension| folder.join(format!("{name}.{extension}")));
            let bytes = figure.canvas().png();
            let broken = |e| FileError { path: png.clone(), source: std::io::Error::other(e) };
            files.add(png.clone(), bytes.map_err(broken)?);
            files.add(svg, figure.svg().into_bytes());
        }
        Ok(files.write().map(|_| ())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_motion::MotionLibrary;

    #[test]
    fn the_generators_kicks_give_four_pictures_and_a_kick_to_record() {
        let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
        let clips = MotionLibrary::builtin(&robot, &spec, 50.0).expect("built in").clips;
        let set = Dataset::new(&clips, &robot, &spec, Grid::EFFECTIVE, OwnPlace::TorsoEnd).expect("a robot");
        assert_eq!((set.kicks.len(), set.coverage.cells.len()), (13, 63));
        // The generator's kicks end where the ball was: ahead of the toe, which meets it below its middle.
        let at_strike =
            Dataset::new(&clips, &robot, &spec, Grid::EFFECTIVE, OwnPlace::Strike).expect("a robot");
        for (end, strike) in set.kicks.iter().zip(&at_strike.kicks) {
            let off = (end.place[0] - strike.place[0]).hypot(end.place[1] - strike.place[1]);
            assert!((0.0..0.15).contains(&off), "{}: {off} m", end.name);
        }
        let kick = &set.kicks[0];
        assert_eq!((kick.path.len(), kick.foot_speed.len()), (clips[0].frames, clips[0].frames));
        let peak = kick.foot_speed.iter().copied().fold(0.0, f64::max);
        assert!((peak - kick.peak_foot_speed).abs() < 1e-12 && (0.1..0.95).contains(&kick.strike_phase));
        let folder = tempfile::tempdir().expect("a folder");
        set.write(folder.path()).expect("writes");
        for name in PICTURES {
            let svg = std::fs::read_to_string(folder.path().join(format!("{name}.svg"))).expect("written");
            assert!(svg.contains(&kick.name), "{name}: every plot has the legend");
            assert!(folder.path().join(format!("{name}.png")).is_file(), "{name}");
        }
        // A folder is in the way of one of them: none is written.
        let other = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(other.path().join("foot_speed.svg")).expect("a folder");
        let error = set.write(other.path()).expect_err("in the way").to_string();
        assert!(error.contains("foot_speed.svg"), "{error}");
        assert_eq!(std::fs::read_dir(other.path()).expect("lists").count(), 1);
        let error = Dataset::new(&[], &robot, &spec, Grid::EFFECTIVE, OwnPlace::Strike);
        let error = error.expect_err("none").to_string();
        assert!(error.starts_with("motions: expected at least one clip"), "{error}");
    }
}
