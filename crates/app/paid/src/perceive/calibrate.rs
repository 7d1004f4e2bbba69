//! `paid perceive calibrate`: camera on torso from views of a ball.

use std::path::PathBuf;

use paid_lanes::{Quat, Vec3};
use paid_vision::{BallView, Pose, calibrate};
use serde::Deserialize;

use crate::failure::Failure;

/// Arguments of `paid perceive calibrate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Views of the ball, a JSON file.
    ///
    /// [{"place": 0, "torso_m": [x, y, z], "torso_quat": [w, x, y, z], "ball_in_camera_m": [right, down, ahead]}, ...]. The torso's pose
    /// is given in any frame that does not move, the ball's center in the camera's optical frame.
    views: PathBuf,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct View {
    place: usize,
    torso_m: [f64; 3],
    torso_quat: [f64; 4],
    ball_in_camera_m: [f64; 3],
}

impl View {
    fn read(&self, index: usize) -> Result<BallView, String> {
        let norm = self.torso_quat.iter().map(|v| v * v).sum::<f64>().sqrt();
        if (norm - 1.0).abs() > 0.01 {
            return Err(format!(
                "view {index}: torso_quat: expected a unit quaternion w, x, y, z, found {:?}",
                self.torso_quat
            ));
        }
        if self.place > 1000 {
            return Err(format!("view {index}: place: expected 0 to 1000, found {}", self.place));
        }
        let rot = Quat(self.torso_quat.map(|v| v / norm)).to_mat();
        let torso = Pose { rot, pos: Vec3(self.torso_m) };
        Ok(BallView { torso, in_camera: self.ball_in_camera_m, place: self.place })
    }
}

/// Calibrates and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let told = |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", args.views.display()));
    let text = std::fs::read_to_string(&args.views).map_err(|error| told(&error))?;
    let views: Vec<View> = serde_json::from_str(&text).map_err(|error| told(&error))?;
    let views: Vec<BallView> = views
        .iter()
        .enumerate()
        .map(|(k, view)| view.read(k))
        .collect::<Result<_, _>>()
        .map_err(|error| told(&error))?;
    let found = calibrate(&views, &Pose::g1_camera()).map_err(|error| told(&error))?;
    let camera = &found.torso_from_camera;
    let axis = camera.rot.col(2).0;
    let down_deg = (-axis[2]).atan2(axis[0].hypot(axis[1])).to_degrees();
    let aside_deg = axis[1].atan2(axis[0]).to_degrees();
    let right = camera.rot.col(0).0;
    let roll_deg = (-right[2]).atan2(right[0].hypot(right[1])).to_degrees();
    if args.json {
        let json = serde_json::json!({
            "mount_m": camera.pos.0,
            "rotation": camera.rot.0,
            "down_deg": down_deg,
            "aside_deg": aside_deg,
            "roll_deg": roll_deg,
            "residual_across_rad": found.residual_rad,
            "residual_along_m": found.residual_m,
            "moved_m": found.change[0],
            "turned_rad": found.change[1],
        });
        println!("{json}");
        return Ok(());
    }
    let [x, y, z] = camera.pos.0;
    println!("camera in the torso's frame: {x:.4}, {y:.4}, {z:.4} m");
    println!(
        "looks {down_deg:.2} degrees down, {aside_deg:.2} to the left, rolled by {roll_deg:.2} to its right"
    );
    println!(
        "moved by {:.1} mm and turned by {:.2} degrees from the robot's description",
        1e3 * found.change[0],
        found.change[1].to_degrees()
    );
    println!(
        "residual of {} views: {:.2} degrees across the ray, {:.1} mm along it",
        views.len(),
        found.residual_rad.to_degrees(),
        1e3 * found.residual_m
    );
    Ok(())
}
