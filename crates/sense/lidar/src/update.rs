//! The iterated update: measurements of distances to planes correct state and covariance.
//!
//! Source of the method: FAST-LIO2, section IV. With `A = H'H + R P^-1` the gain is `K = A^-1 H'`; the prior is carried to each
//! iterate by the manifold's Jacobian.

use nalgebra::{SMatrix, SVector};

use crate::state::{Covariance, State, Tangent};

/// Columns of H that are not zero: position, rotation and the LiDAR's pose.
pub const MEASURED: usize = 12;

/// One row of H.
pub type Row = SVector<f64, MEASURED>;

/// Normal equations of all measurements at one iterate.
#[derive(Clone, Debug, Default)]
pub struct NormalEquations {
    /// `H'H`.
    pub information: SMatrix<f64, MEASURED, MEASURED>,
    /// `H'z`.
    pub gradient: SVector<f64, MEASURED>,
}

impl NormalEquations {
    /// Adds a measurement: residual `[m]` and its derivative by the tangent vector.
    pub fn add(&mut self, row: &Row, residual: f64) {
        self.information.ger(1.0, row, row, 1.0);
        self.gradient.axpy(residual, row, 1.0);
    }
}

/// A corrected state.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// The state.
    pub state: State,
    /// Its covariance.
    pub covariance: Covariance,
    /// From the prior state to this one.
    pub correction: Tangent,
}

/// Corrects `prior` by measurements of variance `noise` `[m^2]`, linearized again `iterations` times. `None` if the covariance cannot
/// be inverted: then nothing is known of the state and the caller must report it.
pub fn iterate(
    prior: &State,
    covariance: &Covariance,
    noise: f64,
    iterations: usize,
    mut linearize: impl FnMut(&State, usize) -> NormalEquations,
) -> Option<Posterior> {
    let prior_information = covariance.cholesky()?.inverse() * noise;
    let mut state = prior.clone();
    let mut last = None;
    for iteration in 0..iterations.max(1) {
        let equations = linearize(&state, iteration);
        let jacobian = state.minus_jacobian(prior);
        let carried = jacobian.transpose() * prior_information;
        let mut a = carried * jacobian;
        let mut right = carried * state.minus(prior);
        let mut corner = a.fixed_view_mut::<MEASURED, MEASURED>(0, 0);
        corner += equations.information;
        let mut head = right.fixed_rows_mut::<MEASURED>(0);
        head += equations.gradient;
        let factor = ((a + a.transpose()) * 0.5).cholesky()?;
        let step = -factor.solve(&right);
        let reset = state.reset_jacobian(&step);
        state = state.plus(&step);
        last = Some(reset * (factor.inverse() * noise) * reset.transpose());
        // Smaller than 1e-6 m and rad: the next linearization would be the same.
        if step.amax() < 1e-6 {
            break;
        }
    }
    let covariance = last?;
    let correction = state.minus(prior);
    let covariance = (covariance + covariance.transpose()) * 0.5;
    (state.is_finite() && covariance.iter().all(|x| x.is_finite())).then_some(Posterior {
        state,
        covariance,
        correction,
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;
    use crate::so3::{exp, skew};
    use crate::state::{POSITION, ROTATION};

    #[test]
    fn one_measurement_of_height_weighs_prior_and_measurement_by_their_variances() {
        // Prior 0 with variance 0.04, measured 1 with variance 0.01: mean 0.8, variance 0.008.
        let prior = State::default();
        let posterior = iterate(&prior, &(Covariance::identity() * 0.04), 0.01, 3, |state, _| {
            let mut equations = NormalEquations::default();
            let mut row = Row::zeros();
            row[POSITION + 2] = 1.0;
            equations.add(&row, state.position.z - 1.0);
            equations
        })
        .expect("invertible");
        assert!((posterior.state.position.z - 0.8).abs() < 1e-12, "{}", posterior.state.position);
        assert!((posterior.covariance[(2, 2)] - 0.008).abs() < 1e-12);
        assert!((posterior.covariance[(0, 0)] - 0.04).abs() < 1e-12);
        assert!((posterior.correction[2] - 0.8).abs() < 1e-12);
    }

    #[test]
    fn iterations_find_a_rotation_that_one_linearization_misses() {
        // Three walls seen from the origin, the sensor turned by 0.6 rad: residuals are not linear in the turn.
        let truth = exp(&Vector3::new(0.1, -0.2, 0.6));
        let points: Vec<Vector3<f64>> = (0..60)
            .map(|i| {
                let angle = f64::from(i) * 0.37;
                Vector3::new(angle.cos() * 3.0, angle.sin() * 2.0, (angle * 1.7).sin())
            })
            .collect();
        let solve = |iterations| {
            let prior = State::default();
            iterate(&prior, &(Covariance::identity() * 4.0), 1e-6, iterations, |state, _| {
                let mut equations = NormalEquations::default();
                for point in &points {
                    for normal in Matrix3::<f64>::identity().column_iter() {
                        let normal: Vector3<f64> = normal.into();
                        let mut row = Row::zeros();
                        let turned =
                            -(state.rotation.to_rotation_matrix() * skew(point)).transpose() * normal;
                        row.fixed_rows_mut::<3>(POSITION).copy_from(&normal);
                        row.fixed_rows_mut::<3>(ROTATION).copy_from(&turned);
                        let found = state.rotation * point + state.position;
                        equations.add(&row, normal.dot(&(found - truth * point)));
                    }
                }
                equations
            })
            .expect("invertible")
            .state
            .rotation
            .angle_to(&truth)
        };
        assert!(solve(1) > 0.01, "{}", solve(1));
        assert!(solve(5) < 1e-5, "{}", solve(5));
    }

    #[test]
    fn a_covariance_that_cannot_be_inverted_is_refused() {
        let found =
            iterate(&State::default(), &Covariance::zeros(), 0.01, 3, |_, _| NormalEquations::default());
        assert!(found.is_none());
    }
}
