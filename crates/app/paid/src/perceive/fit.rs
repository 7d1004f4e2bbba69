//! `paid perceive fit`: the constants of the noise model from what the eyes saw in an evaluation.

use std::path::{Path, PathBuf};

use paid_plot::{Chart, Series};
use paid_track::EyesPreset;
use paid_world::fit::{Find, Fit, fit, read};

use crate::failure::Failure;

/// Arguments of `paid perceive fit`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Detections: files eyes_*_sightings.csv of `paid eval shooting --eyes --out DIR`.
    #[arg(value_name = "CSV", required = true)]
    files: Vec<PathBuf>,
    /// Plot the error over the distance, and the fit, to FILE.png and FILE.svg.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Ranges that training draws from: factor of the noise, and age of an image `[s]`.
const TRAINED_SCALE: [f64; 2] = [0.4, 1.5];
const TRAINED_LATENCY_S: [f64; 2] = [0.04, 0.1];

/// Fits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut finds = Vec::new();
    for path in &args.files {
        finds.extend(read(path).map_err(Failure::input)?);
    }
    let fitted = fit(&finds).map_err(Failure::input)?;
    let noise = EyesPreset::default().noise();
    let scale = fitted.scale(&finds, |speed, distance| noise.deviation(speed, distance));
    if args.json {
        println!("{}", serde_json::to_string_pretty(&fitted).map_err(Failure::input)?);
    } else {
        print(&fitted, scale);
    }
    if let Some(stem) = &args.plot {
        draw(&finds, &fitted, stem)?;
    }
    Ok(())
}

fn print(fit: &Fit, scale: f64) {
    let divisor = |value: f64| if value > 1e4 { "none".to_owned() } else { format!("{value:.1}") };
    println!(
        "{} detections of the ball; {:.1}% of all detections were false",
        fit.finds,
        100.0 * fit.false_share
    );
    println!("c_min   {:.4} m", fit.c_min_m);
    println!("c_vel   {}", divisor(fit.c_vel));
    println!("c_dist  {}", divisor(fit.c_dist));
    println!("latency {:.3} s in the middle, {:.3} s for 95%", fit.latency_s[0], fit.latency_s[1]);
    let within =
        |value: f64, [low, high]: [f64; 2]| if (low..=high).contains(&value) { "within" } else { "outside" };
    println!(
        "that is {scale:.2} times the noise of training (0.01 m + speed/16.7 + distance/100), {} its noise_scale of {} to {}",
        within(scale, TRAINED_SCALE),
        TRAINED_SCALE[0],
        TRAINED_SCALE[1]
    );
    println!(
        "the latency is {} training's {} to {} s",
        within(fit.latency_s[0], TRAINED_LATENCY_S),
        TRAINED_LATENCY_S[0],
        TRAINED_LATENCY_S[1]
    );
    println!(
        "\n{:18}{:>7}{:>8}{:>8}{:>11}{:>11}{:>11}{:>11}{:>8}",
        "group", "number", "dist m", "m/s", "along cm", "across cm", "bias along", "across", "fit cm"
    );
    for g in &fit.groups {
        println!(
            "{:18}{:>7}{:>8.2}{:>8.2}{:>11.1}{:>11.1}{:>11.1}{:>11.1}{:>8.1}",
            g.name,
            g.finds,
            g.mean[0],
            g.mean[1],
            100.0 * g.rms_m[0],
            100.0 * g.rms_m[1],
            100.0 * g.bias_m[0],
            100.0 * g.bias_m[1],
            100.0 * g.fitted_m
        );
    }
}

/// Sizes of the errors over distance; the lines are the fit's standard deviation at rest, and training's.
fn draw(finds: &[Find], fit: &Fit, stem: &Path) -> Result<(), Failure> {
    let near: Vec<[f64; 2]> = finds
        .iter()
        .map(|f| [f.distance_m, 100.0 * f.error_m[0].hypot(f.error_m[1])])
        .filter(|p| p[1] < 30.0)
        .collect();
    let far = near.iter().map(|p| p[0]).fold(0.5, f64::max);
    let line = |sigma: &dyn Fn(f64) -> f64| {
        (0..=20).map(|k| f64::from(k) / 20.0 * far).map(|d| [d, 100.0 * sigma(d)]).collect::<Vec<_>>()
    };
    let noise = EyesPreset::default().noise();
    let series = vec![
        Series { points: near, color: [150, 170, 200], dots: true },
        Series { points: line(&|d| noise.deviation(0.0, d)), color: [200, 60, 40], dots: false },
        Series { points: line(&|d| fit.deviation(0.0, d)), color: [20, 60, 160], dots: false },
    ];
    let chart = Chart {
        title: "error of the ball position; blue: fit at rest, red: training",
        x_label: "distance [m]",
        y_label: "error [cm]",
        logarithmic: false,
        series,
    };
    Ok(chart.draw().save(stem)?)
}
