//! What becomes of a corrected state: taken, refused or the end of a loss; and its report.

use nalgebra::{Isometry3, SMatrix, Vector3};

use super::{Mode, Odometry};
use crate::estimate::Estimate;
use crate::health::{Health, LostReason};
use crate::observability::Sight;
use crate::registration::Fit;
use crate::scan::Scan;
use crate::state::{POSITION, ROTATION};
use crate::update::Posterior;

/// Below this usual share of points off the ground that fit, as on a pitch of nets and posts, its changes mean nothing.
const USEFUL_OFF_GROUND: f64 = 0.4;
/// How fast the usual share of matches follows: a tenth in five scans.
const USUAL_GAIN: f64 = 0.02;

impl Odometry {
    /// Takes or refuses the corrected state.
    pub(super) fn judge(&mut self, scan: &Scan, posterior: Posterior) -> Estimate {
        let fit = self.registration.fit();
        let share = fit.map_or(0.0, Fit::share);
        let usual = self.usual_share.unwrap_or(share);
        let off_ground = fit.map_or(0.0, Fit::upright_share);
        let usual_off_ground = self.usual_off_ground.unwrap_or(off_ground);
        let sight = fit.map_or_else(Sight::default, |f| f.sight);
        let direction = sight.unobservable;
        let lost = matches!(self.mode, Mode::Lost { .. });
        let moved: Vector3<f64> = posterior.correction.fixed_rows::<3>(POSITION).into();
        // Along an unobservable direction nothing is corrected but by what is learned of the IMU.
        let distance_m = direction.map_or(moved, |d| moved - d * d.dot(&moved)).norm();
        let angle_rad = posterior.correction.fixed_rows::<3>(ROTATION).norm();
        // The way back has to fit better than what is still accepted on the way.
        let least = if lost { self.config.recovery_share } else { self.config.lost_share };
        if share < least * usual {
            self.note(LostReason::Mismatch { share, usual });
            return self.lose(share);
        }
        if usual_off_ground > USEFUL_OFF_GROUND && off_ground < least * usual_off_ground {
            self.note(LostReason::Mismatch { share: off_ground, usual: usual_off_ground });
            return self.lose(share);
        }
        let (most_m, most_rad) = if lost {
            (self.config.recovery_m, self.config.recovery_rad)
        } else {
            (self.config.jump_m, self.config.jump_rad)
        };
        if distance_m > most_m || angle_rad > most_rad {
            self.note(LostReason::Jump { distance_m, angle_rad });
            return self.lose(share);
        }
        if let Mode::Lost { corrected_s, .. } = self.mode
            && self.now_s - corrected_s > self.config.give_up_s
        {
            return self.lose(share);
        }
        let Some(filter) = &mut self.filter else { return self.waiting(scan.end_s) };
        let predicted = filter.state.odometry_from_imu();
        filter.correct(posterior);
        if let Some(direction) = direction {
            filter.expect_usual_speed(&direction, self.config.usual_speed);
        }
        let correction = filter.state.odometry_from_imu() * predicted.inverse();
        self.history.push(&self.motion, scan.end_s, &correction);
        self.sight = sight;
        // The scan fits, so the state is right at its stamps. But late or torn data are reported until they are sound again.
        let mut recovered = None;
        if self.fault.is_some() {
            let mut estimate = self.lose(share);
            if let Mode::Lost { corrected_s, .. } = &mut self.mode {
                *corrected_s = self.now_s;
            }
            estimate.correction_m = distance_m;
            estimate.health = self.health();
            return estimate;
        }
        if let Mode::Lost { since_s, reason, good, .. } = self.mode {
            self.mode = Mode::Lost { since_s, corrected_s: self.now_s, reason, good: good + 1 };
            if good + 1 >= self.config.recovery_scans {
                self.mode = Mode::Tracking;
                recovered = Some(self.now_s - since_s);
            }
        }
        if matches!(self.mode, Mode::Tracking) {
            self.usual_share = Some(usual + USUAL_GAIN * (share - usual));
            self.usual_off_ground = Some(usual_off_ground + USUAL_GAIN * (off_ground - usual_off_ground));
            self.remember();
        }
        self.output(scan.end_s, distance_m, recovered)
    }

    /// Goes or stays lost, for the noted fault or the old reason.
    pub(super) fn lose(&mut self, share: f64) -> Estimate {
        let Some(filter) = &mut self.filter else {
            let time_s = self.last_stamp_s.unwrap_or(0.0);
            return self.waiting(time_s);
        };
        let time_s = filter.time_s();
        let fault = self.fault.take();
        self.mode = match (self.mode, fault) {
            (Mode::Lost { since_s, corrected_s, reason, .. }, fault) => {
                Mode::Lost { since_s, corrected_s, reason: fault.unwrap_or(reason), good: 0 }
            }
            (Mode::Tracking, fault) => {
                let reason = fault.unwrap_or(LostReason::Diverged);
                Mode::Lost { since_s: self.now_s, corrected_s: self.now_s, reason, good: 0 }
            }
        };
        let mut estimate = self.output(time_s, 0.0, None);
        estimate.share = share;
        estimate
    }

    fn health(&self) -> Health {
        match self.mode {
            Mode::Lost { corrected_s, reason, .. } => {
                Health::Lost { reason, refused: self.now_s - corrected_s > self.config.give_up_s }
            }
            Mode::Tracking => {
                self.sight.unobservable.map_or(Health::Tracking, |direction| Health::Degenerate { direction })
            }
        }
    }

    pub(super) fn output(
        &mut self,
        time_s: f64,
        correction_m: f64,
        recovered_after_s: Option<f64>,
    ) -> Estimate {
        let health = self.health();
        let Some(filter) = &self.filter else { return self.waiting(time_s) };
        let imu_from_body = self.imu_from_body(filter);
        let rates = filter.angular_velocity();
        let lever = imu_from_body.translation.vector;
        Estimate {
            time_s: filter.time_s(),
            frame: self.frame,
            odometry_from_body: filter.state.odometry_from_imu() * imu_from_body,
            velocity: filter.state.velocity + filter.state.rotation * rates.cross(&lever),
            angular_velocity: imu_from_body.rotation.inverse() * rates,
            covariance: filter.pose_covariance(),
            health,
            points: self.points.len(),
            share: self.registration.fit().map_or(1.0, Fit::share),
            off_ground_share: self.registration.fit().map_or(1.0, Fit::upright_share),
            correction_m,
            recovered_after_s,
        }
    }

    pub(super) fn waiting(&self, time_s: f64) -> Estimate {
        Estimate {
            time_s,
            frame: self.frame,
            odometry_from_body: Isometry3::identity(),
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
            covariance: SMatrix::identity(),
            health: Health::Initializing(self.initializer.refused()),
            points: 0,
            share: 0.0,
            off_ground_share: 0.0,
            correction_m: 0.0,
            recovered_after_s: None,
        }
    }
}
