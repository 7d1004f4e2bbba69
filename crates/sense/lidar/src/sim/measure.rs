//! The measurement: a robot walks and kicks through a scene, and the odometry is held against the truth.

use nalgebra::{Isometry3, Vector3};

use crate::config::Config;
use crate::error::LidarError;
use crate::estimate::Estimate;
use crate::health::Health;
use crate::odometry::Odometry;
use crate::sim::device::SensorModel;
use crate::sim::fault::Fault;
use crate::sim::scene::{Scene, SceneKind};
use crate::sim::sensor::{SCAN_S, SCANS_PER_S, SimulatedMid360};
use crate::sim::walk::Walk;

/// What to measure.
#[derive(Clone, Debug)]
pub struct MeasureOptions {
    /// Scene.
    pub scene: SceneKind,
    /// Length of the run `[s]`.
    pub seconds: f64,
    /// Seed of noise, biases, impacts and people.
    pub seed: u64,
    /// The sensor.
    pub model: SensorModel,
    /// Settings of the odometry.
    pub config: Config,
    /// A fault and the time at which it begins `[s]`.
    pub fault: Option<(f64, Fault)>,
}

impl MeasureOptions {
    /// The protocol's values for a scene.
    #[must_use]
    pub fn new(scene: SceneKind, seconds: f64, seed: u64) -> Self {
        Self { scene, seconds, seed, model: SensorModel::default(), config: Config::g1(), fault: None }
    }
}

/// What was found. Errors are those of the torso, against the truth moved so that the first estimate has none.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Report {
    /// Scene.
    pub scene: SceneKind,
    /// Length of the run `[s]`.
    pub seconds: f64,
    /// Seed.
    pub seed: u64,
    /// Path of the torso over ground `[m]`.
    pub path_m: f64,
    /// Scans with an estimate.
    pub scans: usize,
    /// Scans that tracked in all directions.
    pub tracking: usize,
    /// Scans with an unobservable direction.
    pub degenerate: usize,
    /// Scans that were lost.
    pub lost: usize,
    /// Root of the mean squared position error `[m]`.
    pub position_rms_m: f64,
    /// Largest position error `[m]`.
    pub position_max_m: f64,
    /// Root of the mean squared rotation error `[deg]`.
    pub rotation_rms_deg: f64,
    /// Largest rotation error `[deg]`.
    pub rotation_max_deg: f64,
    /// Root of the mean squared velocity error `[m/s]`.
    pub velocity_rms: f64,
    /// Mean unobservable direction (odometry frame), its sign free, if there was one.
    pub direction: Option<[f64; 3]>,
    /// Root of the mean squared position error across that direction `[m]`.
    pub across_rms_m: Option<f64>,
    /// Position error along it at the end `[m]`.
    pub along_error_m: Option<f64>,
    /// Standard deviation that the odometry gave for it `[m]`.
    pub along_deviation_m: Option<f64>,
    /// Least share of points that fitted the map while tracking, of all and of those off the ground.
    pub least_shares: [f64; 2],
    /// Processor time of the odometry `[s]`.
    pub cpu_s: f64,
    /// How many times faster than real time it was, by processor time.
    pub times_real_time: f64,
    /// Most points in the map.
    pub map_points: usize,
    /// Most memory of the map `[MB]`.
    pub map_mb: f64,
    /// The last state.
    pub last_state: String,
    /// First states that were not tracking, with their times: the message, and when `[s]`.
    pub said: Vec<(f64, String)>,
    /// Time from the fault to the first lost state `[s]`.
    pub fault_said_after_s: Option<f64>,
    /// Time from the fault to the next tracked scan after a loss `[s]`.
    pub fault_recovered_after_s: Option<f64>,
}

/// One scan's outcome.
struct Outcome {
    position: Vector3<f64>,
    rotation_rad: f64,
    velocity: Vector3<f64>,
}

/// Runs the protocol. `cpu` gives processor time `[s]`; only differences count.
///
/// # Errors
///
/// A setting makes no sense, or the odometry never began to track.
pub fn measure(options: &MeasureOptions, cpu: &dyn Fn() -> f64) -> Result<Report, LidarError> {
    let torso_from_lidar = options.config.body_from_lidar;
    let mut sensor = SimulatedMid360::new(
        Scene::new(options.scene, options.seed),
        Walk::new(options.scene, options.seed),
        options.model,
        torso_from_lidar,
        &options.config.imu_from_lidar,
        options.seed,
    );
    let mut odometry = Odometry::new(options.config.clone())?;
    let mut run = Run::default();
    let frames = (options.seconds / SCAN_S).round().max(1.0) as usize;
    for number in 1..=frames {
        let mut frame = sensor.next_frame();
        let end_s = number as f64 / SCANS_PER_S;
        run.path_m += (sensor.torso(end_s).translation.vector.xy()
            - sensor.torso(end_s - SCAN_S).translation.vector.xy())
        .norm();
        let mut delay_s = 0.002;
        let mut silent = false;
        if let Some((at_s, fault)) = options.fault
            && end_s > at_s + 1e-6
        {
            let since_s = end_s - at_s - 1e-6;
            if let Fault::Kidnapped(by) = fault
                && since_s < SCAN_S
            {
                // The scene moves the other way; the next scan shows it.
                sensor.surround(Scene::new(options.scene, options.seed).moved(&-by));
            }
            let found = fault.apply(&mut frame, at_s, since_s);
            delay_s += found.delay_s;
            silent = found.silent;
        }
        let begin = cpu();
        for sample in frame.imu {
            let arrival_s = sample.time_s.max(end_s - SCAN_S) + delay_s;
            odometry.push_imu(sample, arrival_s);
        }
        if !silent {
            odometry.push_scan(frame.scan, end_s + delay_s);
        }
        let mut estimates = Vec::new();
        while let Some(estimate) = odometry.poll(end_s + delay_s) {
            estimates.push(estimate);
        }
        run.cpu_s += cpu() - begin;
        for estimate in estimates {
            run.add(&estimate, end_s, &sensor, options);
        }
        run.map_points = run.map_points.max(odometry.map().len());
        run.map_bytes = run.map_bytes.max(odometry.map().bytes());
    }
    run.report(options)
}

#[derive(Default)]
struct Run {
    odometry_from_scene: Option<Isometry3<f64>>,
    outcomes: Vec<Outcome>,
    directions: Vec<Vector3<f64>>,
    last: Option<Estimate>,
    said: Vec<(f64, String)>,
    last_kind: Option<core::mem::Discriminant<Health>>,
    path_m: f64,
    cpu_s: f64,
    scans: usize,
    tracking: usize,
    degenerate: usize,
    lost: usize,
    map_points: usize,
    map_bytes: usize,
    least_shares: Option<[f64; 2]>,
    fault_said: Option<f64>,
    fault_recovered: Option<f64>,
}

impl Run {
    fn add(
        &mut self,
        estimate: &Estimate,
        now_s: f64,
        sensor: &SimulatedMid360<Walk>,
        options: &MeasureOptions,
    ) {
        if !estimate.health.is_tracking() && self.said.len() < 20 {
            let kind = core::mem::discriminant(&estimate.health);
            if self.last_kind != Some(kind) {
                self.said.push((now_s, estimate.health.to_string()));
            }
        }
        self.last_kind = Some(core::mem::discriminant(&estimate.health));
        if let Some((at_s, _)) = options.fault
            && now_s > at_s
        {
            if estimate.health.is_lost() {
                self.fault_said.get_or_insert(now_s - at_s);
            } else if self.fault_said.is_some() {
                self.fault_recovered.get_or_insert(now_s - at_s);
            }
        }
        match estimate.health {
            Health::Initializing(_) => return,
            Health::Tracking => self.tracking += 1,
            Health::Degenerate { direction } => {
                self.degenerate += 1;
                let sign =
                    if self.directions.first().is_some_and(|d| d.dot(&direction) < 0.0) { -1.0 } else { 1.0 };
                self.directions.push(direction * sign);
            }
            Health::Lost { .. } => self.lost += 1,
        }
        self.scans += 1;
        if !estimate.health.is_lost() {
            let least = self.least_shares.get_or_insert([1.0; 2]);
            *least = [least[0].min(estimate.share), least[1].min(estimate.off_ground_share)];
        }
        // An estimate is of its time on the clock of the scans, whatever the IMU's stamps are.
        let here = sensor.torso(estimate.time_s);
        let frame =
            *self.odometry_from_scene.get_or_insert_with(|| estimate.odometry_from_body * here.inverse());
        let wanted = frame * here;
        let h = 0.01;
        let velocity = (sensor.torso(estimate.time_s + h).translation.vector
            - sensor.torso(estimate.time_s - h).translation.vector)
            / (2.0 * h);
        // While lost there is no promise to keep.
        if !estimate.health.is_lost() {
            self.outcomes.push(Outcome {
                position: estimate.odometry_from_body.translation.vector - wanted.translation.vector,
                rotation_rad: estimate.odometry_from_body.rotation.angle_to(&wanted.rotation),
                velocity: estimate.velocity - frame.rotation * velocity,
            });
        }
        self.last = Some(estimate.clone());
    }

    fn report(self, options: &MeasureOptions) -> Result<Report, LidarError> {
        let (Some(last), false) = (self.last, self.outcomes.is_empty()) else {
            return Err(LidarError::NeverTracked {
                scene: options.scene.name(),
                seconds_s: options.seconds,
                last: self
                    .said
                    .last()
                    .map_or_else(|| "no estimate at all".to_owned(), |(_, said)| said.clone()),
            });
        };
        let outcomes = &self.outcomes;
        let rms = |f: &dyn Fn(&Outcome) -> f64| {
            (outcomes.iter().map(|o| f(o).powi(2)).sum::<f64>() / outcomes.len() as f64).sqrt()
        };
        let max = |f: &dyn Fn(&Outcome) -> f64| outcomes.iter().map(f).fold(0.0, f64::max);
        let direction = self.directions.iter().sum::<Vector3<f64>>().try_normalize(1e-9);
        let end_error = outcomes.last().map_or_else(Vector3::zeros, |o| o.position);
        Ok(Report {
            scene: options.scene,
            seconds: options.seconds,
            seed: options.seed,
            path_m: self.path_m,
            scans: self.scans,
            tracking: self.tracking,
            degenerate: self.degenerate,
            lost: self.lost,
            position_rms_m: rms(&|o| o.position.norm()),
            position_max_m: max(&|o| o.position.norm()),
            rotation_rms_deg: rms(&|o| o.rotation_rad).to_degrees(),
            rotation_max_deg: max(&|o| o.rotation_rad).to_degrees(),
            velocity_rms: rms(&|o| o.velocity.norm()),
            direction: direction.map(Into::into),
            across_rms_m: direction.map(|d| rms(&|o| (o.position - d * o.position.dot(&d)).norm())),
            along_error_m: direction.map(|d| end_error.dot(&d).abs()),
            along_deviation_m: direction.map(|d| last.position_deviation(&d)),
            least_shares: self.least_shares.unwrap_or_default(),
            cpu_s: self.cpu_s,
            times_real_time: options.seconds / self.cpu_s.max(1e-9),
            map_points: self.map_points,
            map_mb: self.map_bytes as f64 / 1e6,
            last_state: last.health.to_string(),
            said: self.said,
            fault_said_after_s: self.fault_said,
            fault_recovered_after_s: self.fault_recovered,
        })
    }
}
