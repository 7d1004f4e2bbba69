//! How far the exits of impacts are apart.

use std::fmt::Write;

use paid_lanes::Vec3;
use paid_lanes::stats::quantile;
use paid_plot::{Table, number};
use serde::Serialize;

use super::ImpactOptions;
use super::draw::Impact;
use super::run::Exit;

/// Spin below which the spin's error is not relative any more `[rad/s]`.
const LEAST_SPIN: f64 = 1.0;
/// The quantiles that are reported.
const QUANTILES: [f64; 4] = [0.5, 0.75, 0.9, 0.95];

/// Differences of one exit from MuJoCo's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Speed over MuJoCo's, less 1.
    pub speed: f64,
    /// Angle between the velocities `[deg]`.
    pub direction_deg: f64,
    /// Length of the difference of the spins `[rad/s]`.
    pub spin_rad_s: f64,
    /// The same over MuJoCo's spin, or over 1 rad/s if that is larger.
    pub spin: f64,
}

impl Errors {
    /// Of `found` from `reference`.
    pub fn of(reference: &Exit, found: &Exit) -> Self {
        let (a, b) = (Vec3(reference.velocity), Vec3(found.velocity));
        let cross = a.cross(b).norm();
        let difference = (Vec3(found.spin) - Vec3(reference.spin)).norm();
        Self {
            speed: b.norm() / a.norm().max(1e-9) - 1.0,
            direction_deg: cross.atan2(a.dot(b)).to_degrees(),
            spin_rad_s: difference,
            spin: difference / Vec3(reference.spin).norm().max(LEAST_SPIN),
        }
    }
}

/// A simulator against MuJoCo.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImpactRow {
    /// Which.
    pub name: String,
    /// Its physics step `[s]`.
    pub physics_dt_s: f64,
    /// Impacts that both hit.
    pub hits: usize,
    /// Impacts that only one of the two hit.
    pub missed: usize,
    /// Median of the signed error of the speed.
    pub speed_bias: f64,
    /// Quantiles (50, 75, 90, 95%) of the speed's error without sign.
    pub speed: [f64; 4],
    /// The same of the direction `[deg]`.
    pub direction_deg: [f64; 4],
    /// The same of the spin, relative.
    pub spin: [f64; 4],
    /// The same of the spin `[rad/s]`.
    pub spin_rad_s: [f64; 4],
    /// Median duration of the contact `[s]`.
    pub contact_s: f64,
}

/// All rows, and what was thrown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImpactReport {
    /// Impacts that were drawn.
    pub trials: usize,
    /// Seed of the draws.
    pub seed: u64,
    /// MuJoCo's physics step `[s]`.
    pub mujoco_dt_s: f64,
    /// MuJoCo's ball in words.
    pub ball: String,
    /// Median approach speed of the surfaces `[m/s]`.
    pub approach: f64,
    /// Median exit speed in MuJoCo `[m/s]`.
    pub exit_speed: f64,
    /// Median duration of the contact in MuJoCo `[s]`.
    pub contact_s: f64,
    /// The rows.
    pub rows: Vec<ImpactRow>,
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    quantile(&mut values.collect::<Vec<_>>(), 0.5).unwrap_or(0.0)
}

impl ImpactReport {
    pub(super) fn new(options: &ImpactOptions, impacts: &[Impact], reference: &[Option<Exit>]) -> Self {
        let ball = options.scene.ball.unwrap_or_default();
        let exits = || reference.iter().flatten();
        Self {
            trials: impacts.len(),
            seed: options.seed,
            mujoco_dt_s: options.scene.physics_dt_s,
            ball: format!(
                "friction {:?}, time constant {} s, damping ratio {}",
                ball.friction, ball.solref[0], ball.solref[1]
            ),
            approach: median(impacts.iter().map(|i| i.approach)),
            exit_speed: median(exits().map(|e| Vec3(e.velocity).norm())),
            contact_s: median(exits().map(|e| e.contact_s)),
            rows: Vec::new(),
        }
    }

    pub(super) fn add(
        &mut self,
        name: &str,
        physics_dt_s: f64,
        reference: &[Option<Exit>],
        found: &[Option<Exit>],
    ) {
        let pairs: Vec<(&Exit, &Exit)> =
            reference.iter().zip(found).filter_map(|(a, b)| Some((a.as_ref()?, b.as_ref()?))).collect();
        let errors: Vec<Errors> = pairs.iter().map(|(a, b)| Errors::of(a, b)).collect();
        let all = |of: fn(&Errors) -> f64| {
            let mut values: Vec<f64> = errors.iter().map(of).collect();
            QUANTILES.map(|q| quantile(&mut values, q).unwrap_or(0.0))
        };
        self.rows.push(ImpactRow {
            name: name.to_owned(),
            physics_dt_s,
            hits: pairs.len(),
            missed: reference.iter().zip(found).filter(|(a, b)| a.is_some() != b.is_some()).count(),
            speed_bias: median(errors.iter().map(|e| e.speed)),
            speed: all(|e| e.speed.abs()),
            direction_deg: all(|e| e.direction_deg),
            spin: all(|e| e.spin),
            spin_rad_s: all(|e| e.spin_rad_s),
            contact_s: median(pairs.iter().map(|(_, b)| b.contact_s)),
        });
    }

    /// The row of that name.
    pub fn row(&self, name: &str) -> Option<&ImpactRow> {
        self.rows.iter().find(|row| row.name == name)
    }

    /// The rows as text.
    pub fn table(&self) -> String {
        let mut out = format!(
            "{} impacts (seed {}) against MuJoCo {} at steps of {} s; ball: {}\n\
             medians: approach {:.2} m/s, exit {:.2} m/s, contact {:.0} ms\n\
             quantiles 50, 75, 90, 95%\n\n",
            self.trials,
            self.seed,
            paid_mujoco::MUJOCO_VERSION,
            self.mujoco_dt_s,
            self.ball,
            self.approach,
            self.exit_speed,
            1e3 * self.contact_s
        );
        let mut table = Table::new(&[
            "engine",
            "step [ms]",
            "hits",
            "missed",
            "speed [%]",
            "bias",
            "direction [deg]",
            "spin [%]",
            "spin [rad/s]",
            "contact [ms]",
        ]);
        let list = |values: &[f64; 4], scale: f64| values.map(|v| number(scale * v, 1)).join(" ");
        for row in &self.rows {
            table.row([
                row.name.clone(),
                number(1e3 * row.physics_dt_s, 1),
                row.hits.to_string(),
                row.missed.to_string(),
                list(&row.speed, 100.0),
                number(100.0 * row.speed_bias, 1),
                list(&row.direction_deg, 1.0),
                list(&row.spin, 100.0),
                list(&row.spin_rad_s, 1.0),
                number(1e3 * row.contact_s, 0),
            ]);
        }
        // Writing to a string cannot fail.
        let _ = write!(out, "{table}");
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exit(velocity: [f64; 3], spin: [f64; 3]) -> Exit {
        Exit { velocity, spin, contact_s: 0.02 }
    }

    #[test]
    fn errors_are_those_worked_out_by_hand() {
        let reference = exit([2.0, 0.0, 0.0], [0.0, 4.0, 0.0]);
        let errors = Errors::of(&reference, &exit([0.0, 3.0, 0.0], [3.0, 4.0, 0.0]));
        assert!((errors.speed - 0.5).abs() < 1e-12);
        assert!((errors.direction_deg - 90.0).abs() < 1e-12);
        assert!((errors.spin_rad_s - 3.0).abs() < 1e-12 && (errors.spin - 0.75).abs() < 1e-12);
        // A ball that hardly spins: over 1 rad/s.
        let still = exit([2.0, 0.0, 0.0], [0.0, 0.1, 0.0]);
        let errors = Errors::of(&still, &exit([2.0, 0.0, 0.0], [0.0, 0.3, 0.0]));
        assert!((errors.spin - 0.2).abs() < 1e-12);
    }

    #[test]
    fn an_impact_that_only_one_engine_hits_is_missed_and_not_compared() {
        let hit = Some(exit([1.0, 0.0, 0.0], [0.0; 3]));
        let mut report = ImpactReport::new(&ImpactOptions::default(), &[], &[]);
        report.add("row", 0.005, &[hit, hit, None, None], &[hit, None, hit, None]);
        let row = report.row("row").expect("added");
        assert_eq!((row.hits, row.missed), (1, 2));
        assert_eq!(row.speed, [0.0; 4]);
    }
}
