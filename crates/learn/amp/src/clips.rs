//! What the clips look like: consecutive frames in pairs, and the scale of each number.

use paid_lanes::rng::Rng;

use crate::AmpError;

/// Numbers whose deviation over the clips is smaller count as constant.
const LEAST_DEVIATION: f32 = 1e-3;
/// Scaled numbers are cut here, so that one far off cannot drown the others.
const LIMIT: f32 = 10.0;

/// Frames of the clips in the features of the observation group, and their mean and deviation.
#[derive(Clone, Debug, PartialEq)]
pub struct Clips {
    features: usize,
    /// Frames `[frame, feature]`, one clip after another, scaled.
    frames: Vec<f32>,
    /// Frames that another one of the same clip follows.
    pairs: Vec<u32>,
    mean: Vec<f32>,
    /// One over the deviation.
    scale: Vec<f32>,
}

impl Clips {
    /// Takes clips of frames `[frame, feature]`, row-major.
    ///
    /// # Errors
    /// If there is none, one has fewer than two frames or none of whole length, or a number is not finite.
    pub fn new(features: usize, clips: &[Vec<f32>]) -> Result<Self, AmpError> {
        let fail =
            |clip: usize, expected: String, found: String| Err(AmpError::Clip { clip, expected, found });
        if clips.is_empty() || features == 0 {
            return fail(0, "one or more clips with features".into(), "none".into());
        }
        let (mut frames, mut pairs) = (Vec::new(), Vec::new());
        for (k, clip) in clips.iter().enumerate() {
            if clip.len() < 2 * features || !clip.len().is_multiple_of(features) {
                let expected = format!("two or more frames of {features} numbers");
                return fail(k, expected, format!("{} numbers", clip.len()));
            }
            if let Some(at) = clip.iter().position(|x| !x.is_finite()) {
                let found = format!("{} in frame {}", clip[at], at / features);
                return fail(k, "finite numbers".into(), found);
            }
            let first = frames.len() / features;
            let count = clip.len() / features;
            pairs.extend((first..first + count - 1).map(|frame| frame as u32));
            frames.extend_from_slice(clip);
        }
        let (mean, scale) = statistics(&frames, features);
        let mut clips = Self { features, frames, pairs, mean, scale };
        let mut frames = core::mem::take(&mut clips.frames);
        for frame in frames.chunks_exact_mut(features) {
            for (i, value) in frame.iter_mut().enumerate() {
                *value = clips.scaled(i, *value);
            }
        }
        clips.frames = frames;
        Ok(clips)
    }

    /// Numbers of a frame.
    pub fn features(&self) -> usize {
        self.features
    }

    /// Number of pairs of consecutive frames.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// Feature `i` of the value `x`, less the clips' mean and over their deviation, within 10.
    pub fn scaled(&self, i: usize, x: f32) -> f32 {
        ((x - self.mean[i]) * self.scale[i]).clamp(-LIMIT, LIMIT)
    }

    /// A random pair: both frames one after the other, scaled.
    pub fn draw(&self, rng: &mut Rng) -> &[f32] {
        let first = self.pairs[rng.below(self.pairs.len())] as usize;
        &self.frames[first * self.features..(first + 2) * self.features]
    }
}

/// Mean and one over the deviation of each feature; the mean in double precision, in the order of the frames.
fn statistics(frames: &[f32], features: usize) -> (Vec<f32>, Vec<f32>) {
    let count = (frames.len() / features) as f64;
    let (mut sum, mut squares) = (vec![0.0; features], vec![0.0; features]);
    for frame in frames.chunks_exact(features) {
        for (i, x) in frame.iter().enumerate() {
            sum[i] += f64::from(*x);
        }
    }
    let mean: Vec<f64> = sum.iter().map(|s| s / count).collect();
    for frame in frames.chunks_exact(features) {
        for (i, x) in frame.iter().enumerate() {
            squares[i] += (f64::from(*x) - mean[i]).powi(2);
        }
    }
    let scale = squares.iter().map(|s| {
        let deviation = (s / count).sqrt() as f32;
        if deviation < LEAST_DEVIATION { 1.0 } else { 1.0 / deviation }
    });
    (mean.iter().map(|m| *m as f32).collect(), scale.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_stay_within_a_clip_and_numbers_are_scaled_by_all_clips() {
        // Feature 0: 0, 2, 4, 6, of mean 3 and deviation sqrt(5); feature 1 is constant.
        let clips = Clips::new(2, &[vec![0.0, 1.0, 2.0, 1.0], vec![4.0, 1.0, 6.0, 1.0]]).expect("clips");
        assert_eq!(clips.pairs(), 2);
        let mut rng = Rng::new(1, 0, 0);
        let mut firsts: Vec<f32> = (0..50).map(|_| clips.draw(&mut rng)[0] * 5.0_f32.sqrt() + 3.0).collect();
        firsts.sort_by(f32::total_cmp);
        firsts.dedup_by(|a, b| (*a - *b).abs() < 1e-4);
        assert_eq!(firsts.len(), 2, "never from frame 1 to frame 2, which is another clip's: {firsts:?}");
        assert!((firsts[0] - 0.0).abs() < 1e-4 && (firsts[1] - 4.0).abs() < 1e-4, "{firsts:?}");
        assert_eq!(clips.scaled(1, 1.5), 0.5, "a constant has the scale 1");
        assert_eq!(clips.scaled(0, 1e6), 10.0);
    }

    #[test]
    fn clips_that_cannot_be_used_are_refused() {
        let text = |features, clips: &[Vec<f32>]| Clips::new(features, clips).expect_err("bad").to_string();
        assert_eq!(text(2, &[]), "frames of clip 0: expected one or more clips with features, found none");
        let short = [vec![0.0; 4], vec![0.0; 2]];
        let expected = "frames of clip 1: expected two or more frames of 2 numbers, found 2 numbers";
        assert_eq!(text(2, &short), expected);
        let nan = [vec![0.0, 0.0, 0.0, f32::NAN]];
        assert_eq!(text(2, &nan), "frames of clip 0: expected finite numbers, found NaN in frame 1");
    }
}
