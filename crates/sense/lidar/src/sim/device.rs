//! What two real Mid-360s do that a perfect one would not.

use core::str::FromStr;

use nalgebra::Vector3;
use paid_lanes::rng::Rng;

use crate::error::LidarError;
use crate::sim::sensor::SCANS_PER_S;

/// Samples of the IMU a second.
pub(super) const IMU_HZ: f64 = 200.0;
/// Points of a packet: frames are whole packets.
pub(super) const PACKET: u64 = 96;
/// The tone of the scanner `[Hz]`.
const TONE_HZ: f64 = 76.7;
/// Share of the jitter's variance that alternates from sample to sample.
const ALTERNATING: f64 = 0.87;
/// Every second sample begins a gap with this probability: one in 5 s.
const GAP_SHARE: f64 = 0.002;
/// A frame may end this early, besides its last packet `[s]`.
const EARLY_S: f64 = 1.2e-3;
/// Samples that a gap swallows.
const GAP_SAMPLES: u64 = 2;

/// Which Mid-360. Both stamp their samples unevenly, return nothing on 29% of the rays and have an offset of the gyroscope.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Device {
    /// Its IMU has white noise.
    Quiet,
    /// Its scanner shakes the IMU with a tone of 77 Hz.
    Shaking,
}

impl FromStr for Device {
    type Err = LidarError;

    fn from_str(name: &str) -> Result<Self, LidarError> {
        match name {
            "quiet" => Ok(Self::Quiet),
            "shaking" => Ok(Self::Shaking),
            found => {
                Err(LidarError::Name { name: "device", expected: "quiet, shaking", found: found.to_owned() })
            }
        }
    }
}

/// How good the sensor is. The default is [`Device::Shaking`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorModel {
    /// Points a second, those without a return too. Mid-360: 200 000.
    pub points_per_s: f64,
    /// Standard deviation of the range `[m]`.
    pub range_noise_m: f64,
    /// Farthest range `[m]`. Mid-360: 40 m at 10% reflectivity.
    pub range_m: f64,
    /// Nearest range that the sensor reports `[m]`.
    pub blind_m: f64,
    /// Probability that a ray does not come back although it hits something.
    pub zero_share: f64,
    /// Whether the robot's arms and legs are seen.
    pub self_hits: bool,
    /// Standard deviation of an axis of the gyroscope at rest `[rad/s]`.
    pub gyro_noise: f64,
    /// Standard deviation of each axis of the accelerometer at rest `[m/s^2]`.
    pub accel_noise: Vector3<f64>,
    /// Share of both variances that is a tone of 76.7 Hz; the rest is white.
    pub tone_share: f64,
    /// Length of the gyroscope's offset, whose direction is drawn `[rad/s]`.
    pub gyro_offset: f64,
    /// Standard deviation of an axis of the accelerometer's bias `[m/s^2]`.
    pub accel_bias: f64,
    /// The accelerometer shows this many times what it should.
    pub accel_scale: f64,
    /// The accelerometer shows at most this `[m/s^2]`. Mid-360: 4 g.
    pub accel_range: f64,
    /// Standard deviation of the time from stamp to stamp of the IMU, without the gaps `[s]`. Samples are 5 ms apart all the same.
    pub imu_jitter_s: f64,
    /// Whether two samples in a row are missing once in 5 s.
    pub imu_gaps: bool,
    /// Time that the IMU's stamps are late `[s]`.
    pub imu_offset_s: f64,
}

impl SensorModel {
    /// A Mid-360 as measured indoors.
    #[must_use]
    pub fn of(device: Device) -> Self {
        let (gyro_noise, accel_noise, tone_share) = match device {
            Device::Quiet => (0.003, Vector3::new(0.013, 0.013, 0.07), 0.0),
            Device::Shaking => (0.017, Vector3::new(0.12, 0.15, 0.30), 0.93),
        };
        Self {
            points_per_s: 200_000.0,
            range_noise_m: 0.005,
            range_m: 40.0,
            blind_m: 0.1,
            zero_share: 0.29,
            self_hits: true,
            gyro_noise,
            accel_noise,
            tone_share,
            gyro_offset: 0.046,
            accel_bias: 0.05,
            accel_scale: 0.993,
            accel_range: 4.0 * 9.81,
            imu_jitter_s: 0.8e-3,
            imu_gaps: true,
            imu_offset_s: 0.0,
        }
    }
}

impl Default for SensorModel {
    fn default() -> Self {
        Self::of(Device::Shaking)
    }
}

/// The IMU's stamps.
#[derive(Clone, Debug)]
pub(super) struct Stamps {
    draw: Rng,
    number: u64,
}

impl Stamps {
    pub fn new(seed: u64) -> Self {
        Self { draw: Rng::new(seed, 0, 62), number: 0 }
    }

    /// When the next sample is taken `[s]`.
    pub fn next_s(&self) -> f64 {
        self.number as f64 / IMU_HZ
    }

    /// Takes the next sample: what its stamp is off by `[s]`.
    pub fn take(&mut self, model: &SensorModel) -> f64 {
        let even = self.number.is_multiple_of(2);
        // From an even stamp to an odd one both parts shorten the time: the gap is one of 14 ms, not of 16.
        let gap = model.imu_gaps && even && self.draw.unit() < GAP_SHARE;
        self.number += if gap { 1 + GAP_SAMPLES } else { 1 };
        // The time between two stamps has twice the alternating part, and the noise of both.
        let alternating = 0.5 * ALTERNATING.sqrt() * if even { 1.0 } else { -1.0 };
        let noise = (0.5 * (1.0 - ALTERNATING)).sqrt() * self.draw.normal();
        model.imu_jitter_s * (alternating + noise)
    }
}

/// Noise of gyroscope and accelerometer, tone included.
#[derive(Clone, Debug)]
pub(super) struct Shake {
    draw: Rng,
    phases: [Vector3<f64>; 2],
}

impl Shake {
    pub fn new(seed: u64) -> Self {
        let mut draw = Rng::new(seed, 0, 63);
        let phases =
            core::array::from_fn(|_| Vector3::from_fn(|_, _| draw.uniform(0.0, core::f64::consts::TAU)));
        Self { draw, phases }
    }

    /// What the sample at `time_s` has on top, gyroscope `[rad/s]` and accelerometer `[m/s^2]`.
    pub fn at(&mut self, time_s: f64, model: &SensorModel) -> [Vector3<f64>; 2] {
        let angle = core::f64::consts::TAU * TONE_HZ * time_s;
        let (tone, white) = ((2.0 * model.tone_share).sqrt(), (1.0 - model.tone_share).sqrt());
        let deviations = [Vector3::repeat(model.gyro_noise), model.accel_noise];
        core::array::from_fn(|k| {
            let relative =
                self.phases[k].map(|phase| tone * (angle + phase).sin() + white * self.draw.normal());
            relative.component_mul(&deviations[k])
        })
    }
}

/// Ends of frames, counted in rays: whole packets, up to 1.7 ms before each tenth of a second.
#[derive(Clone, Debug)]
pub(super) struct Frames {
    draw: Rng,
    number: u64,
}

impl Frames {
    pub fn new(seed: u64) -> Self {
        Self { draw: Rng::new(seed, 0, 64), number: 0 }
    }

    /// When the next frame has ended at the latest `[s]`.
    pub fn next_s(&self) -> f64 {
        (self.number + 1) as f64 / SCANS_PER_S
    }

    /// Rays up to the end of the next frame, at `rate` rays a second.
    pub fn take(&mut self, rate: f64) -> u64 {
        let end_s = self.next_s() - self.draw.uniform(0.0, EARLY_S);
        self.number += 1;
        // With few points a second a packet would last longer than a frame.
        let packet = if rate < 10.0 * SCANS_PER_S * PACKET as f64 { 1 } else { PACKET };
        (end_s * rate) as u64 / packet * packet
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
        values.clone().sum::<f64>() / values.count() as f64
    }

    #[test]
    fn stamps_jitter_by_0_8_ms_and_some_gaps_last_14_ms() {
        let (model, mut stamps) = (SensorModel::default(), Stamps::new(3));
        let times: Vec<f64> = (0..20_000).map(|_| stamps.next_s() + stamps.take(&model)).collect();
        let spans: Vec<f64> = times.windows(2).map(|w| 1e3 * (w[1] - w[0])).collect();
        let (gaps, usual): (Vec<f64>, Vec<f64>) = spans.iter().partition(|span| **span > 10.0);
        let deviation = mean(usual.iter().map(|span| (span - 5.0).powi(2))).sqrt();
        assert!((deviation - 0.8).abs() < 0.02, "{deviation} ms");
        // Short and long ones alternate: 5 ms less or more 0.8 x sqrt(0.87) = 0.75 ms, with noise of 0.29 ms.
        assert!(usual.iter().all(|span| (3.0..7.0).contains(span)));
        let turns = spans.windows(2).filter(|w| (w[0] < 5.0) != (w[1] < 5.0)).count();
        assert!(turns > 19_000, "{turns}");
        // 10 000 even samples, two in a thousand.
        assert!((8..=35).contains(&gaps.len()), "{}", gaps.len());
        assert!((mean(gaps.iter().copied()) - 14.25).abs() < 0.3, "{gaps:?}");
    }

    /// Amplitude of the part of `values`, 200 a second, that is a tone of `hz`.
    fn tone(values: &[f64], hz: f64) -> f64 {
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (i, value) in values.iter().enumerate() {
            let (s, c) = (core::f64::consts::TAU * hz * i as f64 / IMU_HZ).sin_cos();
            cosine += value * c;
            sine += value * s;
        }
        2.0 * f64::hypot(cosine, sine) / values.len() as f64
    }

    /// Of 10 s at rest: standard deviation, and amplitudes at 76.7 Hz and beside it, of the gyroscope's x and the accelerometer's z.
    fn shakes(device: Device) -> [[f64; 3]; 2] {
        let (model, mut shake) = (SensorModel::of(device), Shake::new(3));
        let samples: Vec<_> = (0..2000).map(|i| shake.at(f64::from(i) / IMU_HZ, &model)).collect();
        let of = |values: Vec<f64>| {
            let deviation = mean(values.iter().map(|x| x * x)).sqrt();
            [deviation, tone(&values, 76.7), tone(&values, 70.0)]
        };
        [
            of(samples.iter().map(|[gyro, _]| gyro.x).collect()),
            of(samples.iter().map(|[_, accel]| accel.z).collect()),
        ]
    }

    #[test]
    fn a_shaking_scanner_is_a_tone_of_77_hz_and_a_quiet_one_is_none() {
        let near = |found: f64, wanted: f64| (found / wanted - 1.0).abs() < 0.05;
        let [gyro, accel] = shakes(Device::Shaking);
        // A tone's amplitude is sqrt(2) times its deviation: sqrt(2 x 0.93) x 0.017 and x 0.30.
        assert!(near(gyro[0], 0.017) && near(gyro[1], 0.02319), "{gyro:?}");
        assert!(near(accel[0], 0.30) && near(accel[1], 0.4091), "{accel:?}");
        assert!(gyro[2] < 0.001 && accel[2] < 0.02, "{gyro:?} {accel:?}");
        let [gyro, accel] = shakes(Device::Quiet);
        assert!(near(gyro[0], 0.003) && near(accel[0], 0.07), "{gyro:?} {accel:?}");
        // White noise leaves sqrt(2 / 1000) of its deviation at any frequency, about.
        assert!(gyro[1] < 0.0005 && accel[1] < 0.01, "{gyro:?} {accel:?}");
    }

    #[test]
    fn an_unknown_device_is_named_with_those_there_are() {
        assert_eq!("quiet".parse::<Device>().ok(), Some(Device::Quiet));
        let error = "loud".parse::<Device>().expect_err("no such device").to_string();
        assert_eq!(error, "device: expected one of quiet, shaking, found 'loud'");
    }
}
