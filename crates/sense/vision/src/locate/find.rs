//! From a detection to a ball in the odometry frame.

use paid_lanes::Vec3;
use paid_track::{EyesPreset, Measurement, PositionNoise};

use super::sphere::{Floor, Source, locate};
use crate::detect::Detection;
use crate::{DepthImage, Intrinsics, Pose, PoseBuffer, PoseGap, VisionError};

/// A ball in the odometry frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocatedBall {
    /// Center, odometry frame `[m]`.
    pub position: [f64; 3],
    /// When the image was taken `[s]`.
    pub captured_s: f64,
    /// Variance of every component `[m^2]`.
    pub variance: f64,
    /// What its distance was taken from.
    pub source: Source,
    /// The detector's score.
    pub score: f64,
}

impl LocatedBall {
    /// As the ball tracker takes it, `now_s` being the time at which it arrives.
    pub fn measurement(&self, now_s: f64) -> Measurement<f64> {
        Measurement {
            position: [self.position[0], self.position[1]],
            variance: self.variance,
            age_s: (now_s - self.captured_s).max(0.0),
            seen: true,
        }
    }
}

/// Why a detection gives no place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoSighting {
    /// The torso's pose at the moment of capture is not known.
    Pose(PoseGap),
    /// The box is empty or does not determine the distance.
    Box,
    /// Its middle would be in the floor or just above it: a dome, a lid, a spot.
    InFloor,
}

/// A middle may be lower than that of a ball on the floor by this share of its radius ...
const SUNK_RADII: f64 = 0.6;
/// ... and by what a degree of the camera's tilt makes of the distance.
const TILT_RAD: f64 = 0.0175;

/// Whether no ball of `radius_m` can lie at a height `[m]` over the floor, seen from `distance_m` away.
pub(crate) fn in_floor(height_m: f64, distance_m: f64, radius_m: f64) -> bool {
    height_m < radius_m - SUNK_RADII * radius_m - TILT_RAD * distance_m
}

/// Knows where the camera was, and makes places of detections.
#[derive(Clone, Debug)]
pub struct BallFinder {
    /// The camera's pixels.
    intrinsics: Intrinsics,
    /// Torso from the camera's optical frame.
    torso_from_camera: Pose,
    /// Radius of the ball `[m]`.
    radius_m: f64,
    /// Uncertainty of a place that depth gives.
    noise: PositionNoise,
    /// Height of the floor in the odometry frame `[m]`, if it is known.
    floor_m: Option<f64>,
    /// Poses of the torso in the odometry frame.
    poses: PoseBuffer,
}

impl BallFinder {
    /// With the uncertainty that training assumes ([`EyesPreset::noise`]) and a floor at height 0.
    ///
    /// # Errors
    /// If the intrinsics or the radius make no sense.
    pub fn new(intrinsics: Intrinsics, torso_from_camera: Pose, radius_m: f64) -> Result<Self, VisionError> {
        intrinsics.check()?;
        if !(0.02..=0.5).contains(&radius_m) {
            return Err(VisionError::value("radius of the ball", "0.02 to 0.5 m", format!("{radius_m} m")));
        }
        let noise = EyesPreset::default().noise();
        Ok(Self {
            intrinsics,
            torso_from_camera,
            radius_m,
            noise,
            floor_m: Some(0.0),
            poses: PoseBuffer::default(),
        })
    }

    /// With another floor, or none: then a ball without depth is placed by its size alone.
    #[must_use]
    pub fn with_floor(mut self, floor_m: Option<f64>) -> Self {
        self.floor_m = floor_m;
        self
    }

    /// With another uncertainty of a place.
    #[must_use]
    pub fn with_noise(mut self, noise: PositionNoise) -> Self {
        self.noise = noise;
        self
    }

    /// The same with another floor, once it is known.
    pub fn set_floor(&mut self, floor_m: Option<f64>) {
        self.floor_m = floor_m;
    }

    /// The camera in the odometry frame, for a pose of the torso there.
    pub fn camera(&self, torso: &Pose) -> Pose {
        torso.compose(&self.torso_from_camera)
    }

    /// The camera's pixels.
    pub fn intrinsics(&self) -> &Intrinsics {
        &self.intrinsics
    }

    /// Poses of the torso in the odometry frame; push every one that odometry gives.
    pub fn poses(&mut self) -> &mut PoseBuffer {
        &mut self.poses
    }

    /// Where a detected ball was when the image was taken. `speed` is the ball's relative to the robot, as far as it is known `[m/s]`: the
    /// deviation is the paper's `c_min + speed / c_vel + distance / c_dist`, and where depth is missing, what a pixel's error adds.
    ///
    /// # Errors
    /// If the pose at that time or the distance is not known, or the place is in the floor.
    pub fn sight(
        &self,
        detection: &Detection,
        depth: Option<&DepthImage>,
        captured_s: f64,
        speed: f64,
    ) -> Result<LocatedBall, NoSighting> {
        let torso = self.poses.at(captured_s).map_err(NoSighting::Pose)?;
        self.sight_from(&torso, detection, depth, captured_s, speed)
    }

    /// As [`Self::sight`] for a torso whose pose at the moment of capture is known.
    ///
    /// # Errors
    /// If the distance is not known, or the place is in the floor.
    pub fn sight_from(
        &self,
        torso: &Pose,
        detection: &Detection,
        depth: Option<&DepthImage>,
        captured_s: f64,
        speed: f64,
    ) -> Result<LocatedBall, NoSighting> {
        let camera = torso.compose(&self.torso_from_camera);
        let floor = self.floor_m.map(|height| Floor {
            up: camera.rot.tr_mul_vec(Vec3([0.0, 0.0, 1.0])).0,
            height_m: camera.pos.z() - height,
        });
        let fix = locate(detection, depth, &self.intrinsics, self.radius_m, floor.as_ref())
            .ok_or(NoSighting::Box)?;
        let position = camera.point(fix.position);
        let from_camera = fix.position.iter().map(|v| v * v).sum::<f64>().sqrt();
        // A place that was taken from the floor is on it.
        if fix.source != Source::Floor
            && self.floor_m.is_some_and(|floor| in_floor(position[2] - floor, from_camera, self.radius_m))
        {
            return Err(NoSighting::InFloor);
        }
        let distance = (position[0] - torso.pos.x()).hypot(position[1] - torso.pos.y());
        let sigma: f64 = self.noise.deviation(speed.abs(), distance);
        let variance = match fix.source {
            // The formula is what was measured with depth.
            Source::Depth => sigma.powi(2).max(fix.deviation_m.powi(2)),
            Source::Floor | Source::Size => sigma.powi(2) + fix.deviation_m.powi(2),
        };
        Ok(LocatedBall { position, captured_s, variance, source: fix.source, score: detection.score })
    }
}
