//! `paid perceive detect`: how well a detector finds balls in rendered images.

use std::path::{Path, PathBuf};

use paid_vision::detect::Detector;
use paid_vision::judge::{JudgeOptions, judge, sheet};
use paid_vision::{ColorImage, Intrinsics};

use super::load;
use crate::eval::out::writable;
use crate::failure::Failure;

/// Arguments of `paid perceive detect`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Number of images with a ball, and of images without.
    #[arg(long, value_name = "N", default_value_t = 500)]
    held_out: u32,
    /// ONNX file of a detector [default: the network in this program].
    ///
    /// YOLOv8, YOLOv8-seg or YOLOX with raw heads, or a network trained with `paid perceive train`.
    #[arg(long, value_name = "FILE")]
    detector: Option<PathBuf>,
    /// Number of the ball's class in the file.
    ///
    /// Default: the class that the file's metadata names; without names the only one, or COCO's 32.
    #[arg(long, value_name = "K", requires = "detector")]
    class: Option<usize>,
    /// Lowest score of a detection that counts, 0 to 1.
    ///
    /// Default: 0.5 for the network in this program, 0.25 for others.
    #[arg(long)]
    confidence: Option<f64>,
    /// Size of the camera's image [pixels]; its vertical field of view is 42 degrees.
    #[arg(long, value_name = "WxH", default_value = "424x240", value_parser = size)]
    picture: [usize; 2],
    /// Seed of the scenes.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print JSON instead of the table.
    #[arg(long)]
    json: bool,
    /// Write report.json and worst.png, the images with the worst errors, to this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Two numbers with an x between them.
fn size(text: &str) -> Result<[usize; 2], String> {
    let numbers = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match numbers {
        Some([w, h]) if (32..=1920).contains(&w) && (32..=1920).contains(&h) => Ok([w, h]),
        _ => Err(format!("expected a size of 32 to 1920 pixels such as 640x480, found '{text}'")),
    }
}

/// Evaluates and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut detector = match &args.detector {
        Some(path) => load(path, args.class)?,
        None => Detector::own().map_err(Failure::input)?,
    };
    if let Some(confidence) = args.confidence {
        if !(confidence > 0.0 && confidence < 1.0) {
            return Err(Failure::input(format!(
                "--confidence: expected a number between 0 and 1, found {confidence}"
            )));
        }
        detector = detector.with_confidence(confidence);
    }
    if let Some(folder) = &args.out {
        writable("--out", folder)?;
    }
    let [width, height] = args.picture;
    // Square pixels, 42 degrees from top to bottom as in the D435i's color image.
    let upright = Intrinsics::from_angles(width, height, 42.0, 42.0);
    let intrinsics = Intrinsics { focal: [upright.focal[1]; 2], ..upright };
    let options = JudgeOptions { pictures: args.held_out, seed: args.seed, intrinsics, worst: 24 };
    let every = (args.held_out / 10).max(1);
    let report = judge(&detector, &options, |done| {
        if done % every == 0 && !args.json {
            eprintln!("{done} of {} pairs of images", args.held_out);
        }
    })
    .map_err(Failure::input)?;
    let json = serde_json::to_string(&report).map_err(Failure::input)?;
    if let Some(folder) = &args.out {
        write(&folder.join("report.json"), json.as_bytes())?;
        if let Some(image) = sheet(&report.worst, 4) {
            write(&folder.join("worst.png"), &png(&image)?)?;
        }
    }
    if args.json {
        println!("{json}");
    } else {
        print!("{}", report.text());
    }
    Ok(())
}

fn png(image: &ColorImage) -> Result<Vec<u8>, Failure> {
    image.png().map_err(Failure::input)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let failed = |error: std::io::Error| Failure::input(format!("{}: {error}", path.display()));
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(failed)?;
    }
    paid_files::write_atomically(path, bytes).map_err(failed)
}
