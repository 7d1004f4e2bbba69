//! `paid perceive odometry`: the odometry's error, speed and memory in simulated scenes, and what it says of a sensor's faults.

use cpu_time::ThreadTime;
use paid_lidar::sim::{Device, Fault, FaultKind, MeasureOptions, Report, SceneKind, SensorModel, measure};

use crate::failure::Failure;

/// When a fault begins `[s]`.
const FAULT_AT_S: f64 = 8.0;
/// The shortest run in which a fault shows: its first scan ends 0.1 s after its begin `[s]`.
const LEAST_WITH_FAULT_S: f64 = 8.1;

/// Arguments of `paid perceive odometry`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene: hall, pitch, corridor, people or endless [default: all].
    #[arg(long, value_name = "NAME")]
    scene: Option<SceneKind>,
    /// Length of the run [s]; the robot stands for the first 2 s.
    #[arg(long, default_value_t = 60.0, value_parser = seconds)]
    seconds: f64,
    /// Seed of noise, biases, impacts and people.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Kind of Mid-360: quiet or shaking.
    ///
    /// The scanner of a shaking one adds a tone of 77 Hz to its IMU.
    #[arg(long, value_name = "NAME", default_value = "shaking")]
    device: Device,
    /// Points that the LiDAR measures per second; a Mid-360 has 200 000.
    #[arg(long, default_value_t = 200_000, value_parser = clap::value_parser!(u32).range(1_000..=1_000_000))]
    points: u32,
    /// Delay of the IMU's time stamps [ms].
    #[arg(long, default_value_t = 0.0, value_parser = offset)]
    imu_offset: f64,
    /// Sensor fault 8 s after the start; needs --seconds 8.1 or more.
    ///
    /// covered, kidnapped, late, gap, backwards or silent.
    #[arg(long, value_name = "NAME")]
    fault: Option<FaultKind>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    number(text, 3.0, 36_000.0, "a number of seconds from 3 to 36000")
}

fn offset(text: &str) -> Result<f64, String> {
    number(text, -50.0, 50.0, "a number of milliseconds from -50 to 50")
}

fn number(text: &str, low: f64, high: f64, expected: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|x| (low..=high).contains(x));
    found.ok_or_else(|| format!("expected {expected}, found '{text}'"))
}

/// Measures and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    if args.fault.is_some() && args.seconds < LEAST_WITH_FAULT_S {
        return Err(Failure::input(format!(
            "--seconds: expected {LEAST_WITH_FAULT_S} or more with --fault, which begins after {FAULT_AT_S} s, found {}",
            args.seconds
        )));
    }
    let scenes = args.scene.map_or_else(|| SceneKind::ALL.to_vec(), |scene| vec![scene]);
    let begin = ThreadTime::now();
    let clock = || begin.elapsed().as_secs_f64();
    let mut reports = Vec::new();
    for scene in scenes {
        let mut options = MeasureOptions::new(scene, args.seconds, args.seed);
        options.model = SensorModel::of(args.device);
        options.model.points_per_s = f64::from(args.points);
        options.model.imu_offset_s = args.imu_offset * 1e-3;
        options.fault = args.fault.map(|kind| (FAULT_AT_S, Fault::usual(kind)));
        let report = measure(&options, &clock).map_err(Failure::input)?;
        if !args.json {
            if reports.is_empty() {
                head();
            }
            row(&report);
        }
        reports.push(report);
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&reports).map_err(Failure::input)?);
    } else {
        println!(
            "\nerrors of the torso's pose; RMS and largest; 'x real time' by processor time of the odometry on one core"
        );
        reports.iter().for_each(notes);
    }
    Ok(())
}

fn head() {
    println!(
        "{:10}{:>8}{:>9}{:>9}{:>9}{:>9}{:>7}{:>7}{:>7}{:>8}{:>9}{:>8}",
        "scene",
        "path m",
        "rms cm",
        "max cm",
        "rms deg",
        "max deg",
        "scans",
        "degen.",
        "lost",
        "x real",
        "points",
        "map MB"
    );
}

fn row(r: &Report) {
    println!(
        "{:10}{:>8.1}{:>9.1}{:>9.1}{:>9.2}{:>9.2}{:>7}{:>7}{:>7}{:>8.1}{:>9}{:>8.1}",
        r.scene.name(),
        r.path_m,
        100.0 * r.position_rms_m,
        100.0 * r.position_max_m,
        r.rotation_rms_deg,
        r.rotation_max_deg,
        r.scans,
        r.degenerate,
        r.lost,
        r.times_real_time,
        r.map_points,
        r.map_mb,
    );
}

/// What the odometry said of itself.
fn notes(r: &Report) {
    let name = r.scene.name();
    if let (Some(across), Some(along), Some(deviation)) =
        (r.across_rms_m, r.along_error_m, r.along_deviation_m)
    {
        println!(
            "{name}: along the unobservable direction {along:.2} m off at the end with {deviation:.2} m estimated as its deviation; across it {:.1} cm RMS",
            100.0 * across
        );
    }
    if let Some(after) = r.fault_said_after_s {
        let back = r.fault_recovered_after_s.map_or_else(
            || "it did not recover by itself".to_owned(),
            |s| format!("it recovered after {s:.1} s"),
        );
        println!("{name}: the fault was reported after {after:.1} s; {back}");
    }
    for (time_s, said) in &r.said {
        println!("{name}: {time_s:6.1} s  {said}");
    }
}
