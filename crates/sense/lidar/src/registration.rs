//! Matches the points of a scan with planes of the map.

use nalgebra::{Matrix3, Vector3};

use crate::config::Config;
use crate::map::VoxelMap;
use crate::observability::{Observability, Sight};
use crate::plane::Plane;
use crate::state::{LIDAR_POSITION, LIDAR_ROTATION, POSITION, ROTATION, State};
use crate::update::{NormalEquations, Row};

/// A plane whose normal is within 45 degrees of the vertical is level.
const LEVEL: f64 = 0.7;
/// One point and its plane.
#[derive(Clone, Debug)]
struct Match {
    normal: Vector3<f64>,
    row: Row,
    residual: f64,
}

/// How a scan lay on the map at the last linearization.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Points of the scan.
    pub points: usize,
    /// Points with a plane.
    pub matched: usize,
    /// Points with a plane that is not level.
    pub upright: usize,
    /// What the planes see of translation, with those of the scans before; of the first linearization.
    pub sight: Sight,
}

impl Fit {
    /// Share of points with a plane.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.matched as f64 / self.points.max(1) as f64
    }

    /// Share of the points off the ground that have a plane. Level ground fits wherever the sensor is carried to, so it says nothing of
    /// that.
    #[must_use]
    pub fn upright_share(&self) -> f64 {
        let off_ground = self.points - self.matched + self.upright;
        self.upright as f64 / off_ground.max(1) as f64
    }
}

/// Linearizes the distances of a scan's points from the map's planes. Keeps its memory from scan to scan.
#[derive(Clone, Debug, Default)]
pub struct Registration {
    matches: Vec<Match>,
    normals: Vec<Vector3<f64>>,
    fit: Option<Fit>,
}

impl Registration {
    /// The fit at the last linearization of this scan.
    #[must_use]
    pub fn fit(&self) -> Option<&Fit> {
        self.fit.as_ref()
    }

    /// Normal equations of `points` (LiDAR frame, at the scan's end) at `state`. In the first iteration the observable directions
    /// are found; along an unobservable one no correction is made. `before` is what the scans before saw.
    pub fn linearize(
        &mut self,
        points: &[Vector3<f64>],
        map: &VoxelMap,
        state: &State,
        iteration: usize,
        before: &Sight,
        config: &Config,
    ) -> NormalEquations {
        self.search(points, map, state, config);
        let sight = match &self.fit {
            Some(fit) if iteration > 0 => fit.sight,
            _ => {
                self.normals.clear();
                self.normals.extend(self.matches.iter().map(|m| m.normal));
                before.followed_by(&Observability::of(&self.normals), config.facing_planes)
            }
        };
        let mut equations = NormalEquations::default();
        for m in &self.matches {
            match sight.unobservable {
                None => equations.add(&m.row, m.residual),
                Some(direction) => {
                    let mut row = m.row;
                    let seen = m.normal - direction * m.normal.dot(&direction);
                    row.fixed_rows_mut::<3>(POSITION).copy_from(&seen);
                    equations.add(&row, m.residual);
                }
            }
        }
        let matched = self.matches.len();
        let upright = self.matches.iter().filter(|m| m.normal.z.abs() < LEVEL).count();
        self.fit = Some(Fit { points: points.len(), matched, upright, sight });
        equations
    }

    fn search(&mut self, points: &[Vector3<f64>], map: &VoxelMap, state: &State, config: &Config) {
        self.matches.clear();
        let rotation: Matrix3<f64> = state.rotation.to_rotation_matrix().into_inner();
        let lidar_rotation: Matrix3<f64> = state.lidar_rotation.to_rotation_matrix().into_inner();
        for point in points {
            let in_imu = lidar_rotation * point + state.lidar_position;
            let in_odometry = rotation * in_imu + state.position;
            let Some((neighbors, fifth)) = map.nearest(&in_odometry) else { continue };
            if fifth > config.neighbor_m {
                continue;
            }
            let Some(plane) = Plane::fit(&neighbors, config.plane_thickness_m) else { continue };
            let residual = plane.distance(&in_odometry);
            if 1.0 - 0.9 * residual.abs() / point.norm().sqrt() <= config.match_score {
                continue;
            }
            let normal_in_imu = rotation.tr_mul(&plane.normal);
            let mut row = Row::zeros();
            row.fixed_rows_mut::<3>(POSITION).copy_from(&plane.normal);
            row.fixed_rows_mut::<3>(ROTATION).copy_from(&in_imu.cross(&normal_in_imu));
            if config.estimate_extrinsic {
                let normal_in_lidar = lidar_rotation.tr_mul(&normal_in_imu);
                row.fixed_rows_mut::<3>(LIDAR_ROTATION).copy_from(&point.cross(&normal_in_lidar));
                row.fixed_rows_mut::<3>(LIDAR_POSITION).copy_from(&normal_in_imu);
            }
            self.matches.push(Match { normal: plane.normal, row, residual });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::{DOF, Tangent};

    /// A floor and two walls, points every 0.5 m in the middle of the cubes.
    fn corner() -> VoxelMap {
        let mut map = VoxelMap::new(0.5, 50.0, 100_000);
        for i in -12..12 {
            for k in -12..12 {
                let (a, b) = (f64::from(i) * 0.5 + 0.25, f64::from(k) * 0.5 + 0.25);
                map.insert(Vector3::new(a, b, -1.2));
                if k >= -4 {
                    map.insert(Vector3::new(6.1, a, b));
                    map.insert(Vector3::new(a, -6.1, b));
                }
            }
        }
        map
    }

    fn scan() -> Vec<Vector3<f64>> {
        let grid =
            (0..20).flat_map(|i| (0..20).map(move |k| (f64::from(i) * 0.3 - 3.0, f64::from(k) * 0.3 - 3.0)));
        grid.flat_map(|(a, b)| {
            [Vector3::new(a, b, -1.2), Vector3::new(6.1, a, b + 2.5), Vector3::new(a, -6.1, b + 2.5)]
        })
        .collect()
    }

    #[test]
    fn rows_match_finite_differences_of_the_residuals() {
        let map = corner();
        let config = Config { estimate_extrinsic: true, ..Config::default() };
        let d = Tangent::from_fn(|i, _| if i < 12 { 0.01 * (i as f64 * 1.7).sin() } else { 0.0 });
        let state = State { lidar_position: Vector3::new(0.1, 0.2, -0.1), ..State::default() }.plus(&d);
        let points =
            [Vector3::new(1.0, 2.0, -1.1), Vector3::new(5.9, 1.0, 1.0), Vector3::new(2.0, -6.3, 0.5)];
        for point in points {
            let mut registration = Registration::default();
            registration.search(&[point], &map, &state, &config);
            let row = registration.matches[0].row;
            let h = 1e-6;
            for i in 0..12 {
                let mut e = Tangent::zeros();
                e[i] = h;
                let residual = |s: State| {
                    let mut r = Registration::default();
                    r.search(&[point], &map, &s, &config);
                    r.matches[0].residual
                };
                let slope = (residual(state.plus(&e)) - residual(state.plus(&-e))) / (2.0 * h);
                assert!((slope - row[i]).abs() < 1e-6, "column {i}: {slope} and {}", row[i]);
            }
        }
        assert_eq!(DOF, 23);
    }

    #[test]
    fn the_update_brings_a_moved_sensor_back_to_2_mm() {
        let (map, config, points) = (corner(), Config::default(), scan());
        let mut d = Tangent::zeros();
        d.fixed_rows_mut::<6>(0).copy_from_slice(&[0.05, -0.04, 0.03, 0.01, -0.02, 0.015]);
        let prior = State::default().plus(&d);
        let covariance = crate::state::Covariance::identity() * 0.01;
        let mut registration = Registration::default();
        let posterior = crate::update::iterate(&prior, &covariance, 0.001, 3, |state, iteration| {
            registration.linearize(&points, &map, state, iteration, &Sight::default(), &config)
        })
        .expect("invertible");
        assert!(posterior.state.position.norm() < 0.002, "{}", posterior.state.position);
        assert!(posterior.state.rotation.angle() < 0.001);
        assert!(registration.fit().expect("linearized").share() > 0.9);
        assert_eq!(registration.fit().expect("linearized").sight.unobservable, None);
    }

    #[test]
    fn without_the_wall_ahead_nothing_is_corrected_along_x() {
        let mut map = VoxelMap::new(0.5, 50.0, 100_000);
        for i in -20..20 {
            for k in -4..4 {
                let (a, b) = (f64::from(i) * 0.5 + 0.25, f64::from(k) * 0.5 + 0.25);
                map.insert(Vector3::new(a, b, -1.2));
                map.insert(Vector3::new(a, -2.1, b));
                map.insert(Vector3::new(a, 2.1, b));
            }
        }
        let points: Vec<_> = (0..300)
            .flat_map(|i| {
                let a = (f64::from(i) * 0.618).fract() * 8.0 - 4.0;
                let b = (f64::from(i) * 0.414).fract() * 1.6 - 0.8;
                [Vector3::new(a, b, -1.2), Vector3::new(a, -2.1, b), Vector3::new(a, 2.1, b)]
            })
            .collect();
        let prior = State { position: Vector3::new(0.3, 0.05, 0.0), ..State::default() };
        let covariance = crate::state::Covariance::identity() * 0.01;
        let config = Config::default();
        let mut registration = Registration::default();
        let posterior = crate::update::iterate(&prior, &covariance, 0.001, 3, |state, iteration| {
            registration.linearize(&points, &map, state, iteration, &Sight::default(), &config)
        })
        .expect("invertible");
        let direction = registration.fit().expect("linearized").sight.unobservable.expect("a corridor");
        assert!(direction.x.abs() > 0.999, "{direction}");
        assert!((posterior.state.position.x - 0.3).abs() < 1e-3);
        assert!(posterior.state.position.y.abs() < 2e-3);
        assert!(posterior.covariance[(0, 0)] > 0.009);
    }
}
