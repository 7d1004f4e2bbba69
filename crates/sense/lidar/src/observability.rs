//! Which directions of motion a scan can see.
//!
//! The translation information matrix is the sum of `n n'` over the normals of all matched planes. In a corridor no normal points
//! along it, so one eigenvalue is nothing but noise (Zhang, Kaess, Singh, *On Degeneracy of Optimization-based State
//! Estimation Problems*, 2016).

use nalgebra::{Matrix3, Vector3};

/// A normal within 60 degrees of a direction constrains motion along it; with more the noise of the normals would count.
const FACING: f64 = 0.5;
/// A degenerate direction is seen again with this many times the planes, so that the state does not flicker.
const HYSTERESIS: f64 = 1.5;
/// How fast the mean number of facing planes follows that of the scans, and how many times those needed a scan counts for at most: a new
/// corridor shows after half a second. A scan alone says little: on a pitch one in a hundred has none of 9 planes, in a corridor one in a
/// hundred has two, on the robot's own legs.
const FACING_GAIN: f64 = 0.2;
const MOST_FACING: f64 = 3.0;
/// How fast the unobservable direction follows that of the scans, and the cosine (2.5 degrees) from which it does. One scan's is off by
/// a degree, each in its own way; taken as it is, the walls would seem to constrain motion along the corridor.
const DIRECTION_GAIN: f64 = 0.05;
const DIRECTION_HELD: f64 = 0.999;

/// What one scan sees of translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observability {
    /// Eigenvalues of the information matrix, smallest first: planes' worth along each direction.
    pub eigenvalues: [f64; 3],
    /// The direction that is seen least, a unit vector in the odometry frame.
    pub weakest: Vector3<f64>,
    /// Sum of squared cosines of the planes that face [`Self::weakest`].
    pub facing: f64,
}

impl Observability {
    /// Of the normals of all matched planes.
    #[must_use]
    pub fn of(normals: &[Vector3<f64>]) -> Self {
        let mut information = Matrix3::zeros();
        for n in normals {
            information.ger(1.0, n, n, 1.0);
        }
        let eigen = information.symmetric_eigen();
        let weakest: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into();
        let mut eigenvalues = [eigen.eigenvalues[0], eigen.eigenvalues[1], eigen.eigenvalues[2]];
        eigenvalues.sort_by(f64::total_cmp);
        let facing =
            normals.iter().map(|n| n.dot(&weakest)).filter(|c| c.abs() > FACING).map(|c| c * c).sum();
        Self { eigenvalues, weakest, facing }
    }
}

/// What the scans so far see of translation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sight {
    /// Mean of [`Observability::facing`].
    facing: Option<f64>,
    /// The direction along which motion is not seen, a unit vector in the odometry frame.
    pub unobservable: Option<Vector3<f64>>,
}

impl Sight {
    /// With one more scan. Motion is not seen along its weakest direction if fewer than `needed` planes face that in the mean.
    #[must_use]
    pub fn followed_by(&self, scan: &Observability, needed: f64) -> Self {
        let here = scan.facing.min(MOST_FACING * needed);
        let facing = self.facing.map_or(here, |mean| mean + FACING_GAIN * (here - mean));
        let needed = needed * if self.unobservable.is_some() { HYSTERESIS } else { 1.0 };
        let unobservable = (facing < needed).then(|| follow(self.unobservable.as_ref(), &scan.weakest));
        Self { facing: Some(facing), unobservable }
    }
}

/// The unobservable direction `held` so far, moved a little to the one `found` in this scan.
fn follow(held: Option<&Vector3<f64>>, found: &Vector3<f64>) -> Vector3<f64> {
    match held {
        Some(held) if held.dot(found).abs() > DIRECTION_HELD => *held,
        // A turn of more than 25 degrees is another corridor.
        Some(held) if held.dot(found).abs() > 0.9 => {
            let found = found * held.dot(found).signum();
            held.lerp(&found, DIRECTION_GAIN).normalize()
        }
        _ => *found,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corridor_along_x_hides_x_even_with_noisy_normals() {
        let normals: Vec<Vector3<f64>> = (0..300)
            .map(|i| {
                let noise = 0.1 * (f64::from(i) * 1.3).sin();
                let n = if i % 2 == 0 { Vector3::y() } else { Vector3::z() };
                (n + Vector3::x() * noise).normalize()
            })
            .collect();
        let found = Observability::of(&normals);
        assert!(found.weakest.x.abs() > 0.99, "{found:?}");
        assert!(found.eigenvalues[0] > 1.0, "noise alone is worth more than one plane: {found:?}");
        assert_eq!(found.facing, 0.0);
        let direction = Sight::default().followed_by(&found, 1.5).unobservable.expect("a corridor");
        assert!(direction.x.abs() > 0.99, "{direction}");
    }

    #[test]
    fn ten_planes_at_the_corridors_end_make_it_observable() {
        let mut normals = vec![Vector3::y(); 100];
        normals.extend([Vector3::z(); 100]);
        normals.extend([Vector3::x(); 10]);
        let found = Observability::of(&normals);
        assert!((found.eigenvalues[0] - 10.0).abs() < 1e-9);
        assert_eq!(Sight::default().followed_by(&found, 1.5).unobservable, None);
    }

    #[test]
    fn one_scan_without_a_facing_plane_hides_nothing_and_a_corridor_does_within_half_a_second() {
        let facing = |planes: usize| {
            let mut normals = vec![Vector3::y(); 100];
            normals.extend([Vector3::z(); 100]);
            normals.extend(vec![Vector3::x(); planes]);
            Observability::of(&normals)
        };
        let after = |sight: Sight, scans: &[usize]| {
            scans.iter().fold(sight, |sight, planes| sight.followed_by(&facing(*planes), 1.5))
        };
        // Four planes, then none: a mean of 3.2, then 2.56.
        let pitch = after(Sight::default(), &[4, 0, 0]);
        assert!(pitch.unobservable.is_none() && (pitch.facing.expect("seen") - 2.56).abs() < 1e-9);
        // However many planes a hall has, they count for 4.5: 4.5 x 0.8^4 = 1.84, and 1.47 with a fifth.
        let hall = after(Sight::default(), &[50, 0, 0, 0, 0]);
        assert_eq!(hall.unobservable, None);
        let corridor = after(hall, &[0]);
        assert!(corridor.unobservable.is_some_and(|d| d.x.abs() > 0.999), "{corridor:?}");
        // Seen again at 2.25: 1.98 and 2.48 with four planes and four more.
        assert!(after(corridor, &[4]).unobservable.is_some());
        assert_eq!(after(corridor, &[4, 4]).unobservable, None);
    }
}
