//! A training from its first step to its file.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;

use burn::grad_clipping::GradientClippingConfig;
use burn::optim::{AdamWConfig, GradientsParams};
use burn::tensor::Device;

use super::batch::Batch;
use super::model::BallNet;
use crate::VisionError;
use crate::net::encode_net;
use crate::scatter::{Scatter, Use};

/// How long and on what.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainOptions {
    /// Steps of the optimizer.
    pub steps: u32,
    /// Windows a step.
    pub batch: u32,
    /// Largest learning rate; it rises over the first 3% of the steps and falls to zero along half a cosine.
    pub rate: f64,
    /// Numbers the scenes and the first weights.
    pub seed: u64,
    /// Steps between two files.
    pub save_every: u32,
}

impl Default for TrainOptions {
    /// What the committed network was trained with.
    fn default() -> Self {
        Self { steps: 26_000, batch: 16, rate: 2e-3, seed: 1, save_every: 250 }
    }
}

/// How far a training is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Steps done.
    pub step: u32,
    /// Loss of the heat map, mean since the last report.
    pub heat: f64,
    /// Loss of place and size, mean since the last report.
    pub place: f64,
}

/// Batches that are rendered ahead.
const AHEAD: usize = 4;

/// Trains the network on rendered windows and writes it to `path` as ONNX, now and then and at the end. The file of the last step is the
/// result; no other is chosen. A second thread renders. Once `stop` is set, the step under way is the last one. Returns the steps that were
/// done.
///
/// # Errors
/// If an option makes no sense, the loss is no number any more, or the file cannot be written.
pub fn train(
    options: &TrainOptions,
    path: &Path,
    stop: &AtomicBool,
    report: impl FnMut(Progress),
) -> Result<u32, VisionError> {
    for (what, value) in
        [("steps", options.steps), ("batch", options.batch), ("save_every", options.save_every)]
    {
        if value == 0 {
            return Err(VisionError::value(what, "1 or more", "0"));
        }
    }
    if !(options.rate > 0.0 && options.rate.is_finite()) {
        return Err(VisionError::value("rate", "a positive number", options.rate.to_string()));
    }
    if options.steps.checked_mul(options.batch).is_none() {
        return Err(VisionError::value("steps", "steps times batch below 2^32", options.steps.to_string()));
    }
    let scatter = Scatter::new(Use::Training, options.seed)?;
    let (give, batches) = sync_channel(AHEAD);
    std::thread::scope(|scope| {
        scope.spawn(move || {
            for step in 0..options.steps {
                let batch = Batch::draw(&scatter, step * options.batch..(step + 1) * options.batch);
                // There is no receiver: the training has ended.
                if give.send(batch).is_err() {
                    break;
                }
            }
        });
        learn(options, path, stop, batches.into_iter(), report)
    })
}

/// The steps of a training.
fn learn(
    options: &TrainOptions,
    path: &Path,
    stop: &AtomicBool,
    batches: impl Iterator<Item = Batch>,
    mut report: impl FnMut(Progress),
) -> Result<u32, VisionError> {
    let device = Device::flex().autodiff();
    device.seed(options.seed);
    let mut net = BallNet::new(&device);
    let mut optimizer = AdamWConfig::new()
        .with_weight_decay(1e-4)
        .with_grad_clipping(Some(GradientClippingConfig::Norm(5.0)))
        .init();
    let (mut heat, mut place, mut since) = (0.0, 0.0, 0);
    let mut done = 0;
    for batch in batches {
        let loss = net.loss(batch.tensors(&device));
        heat += f64::from(loss.heat.into_scalar::<f32>());
        place += f64::from(loss.place.into_scalar::<f32>());
        since += 1;
        let gradients = GradientsParams::from_grads(loss.total.backward(), &net);
        net = optimizer.step(rate(options, done), net, gradients);
        done += 1;
        let last = done == options.steps || stop.load(Ordering::Relaxed);
        if done % 25 == 0 || last {
            let mean = |sum: f64| sum / f64::from(since);
            let progress = Progress { step: done, heat: mean(heat), place: mean(place) };
            if !progress.heat.is_finite() || !progress.place.is_finite() {
                return Err(VisionError::value(
                    format!("loss at step {done}"),
                    "a number",
                    format!("{progress:?}"),
                ));
            }
            report(progress);
            (heat, place, since) = (0.0, 0.0, 0);
        }
        if done % options.save_every == 0 || last {
            let notes = [
                ("data", "rendered by this project; no real photograph".to_owned()),
                ("steps", format!("{done} of {}", options.steps)),
                ("batch", options.batch.to_string()),
                ("seed", options.seed.to_string()),
            ];
            let bytes = encode_net(&net.weights()?, &notes)?;
            paid_files::write_atomically(path, &bytes)
                .map_err(|source| VisionError::Write { path: path.to_owned(), source })?;
        }
        if last {
            break;
        }
    }
    Ok(done)
}

/// The learning rate of a step.
fn rate(options: &TrainOptions, step: u32) -> f64 {
    let share = f64::from(step) / f64::from(options.steps);
    let warm = 0.03;
    if share < warm {
        options.rate * (share / warm).max(0.02)
    } else {
        let t = (share - warm) / (1.0 - warm);
        options.rate * 0.5 * (1.0 + (std::f64::consts::PI * t).cos())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detect::{Detector, Kind};

    #[test]
    fn a_short_training_writes_a_detector_and_tells_its_loss() {
        let path = std::env::temp_dir().join(format!("paid-vision-train-{}.onnx", std::process::id()));
        let options = TrainOptions { steps: 3, batch: 2, save_every: 2, ..TrainOptions::default() };
        let mut told = Vec::new();
        let on = AtomicBool::new(false);
        let done = train(&options, &path, &on, |progress| told.push(progress)).expect("trains");
        assert_eq!((done, told.len()), (3, 1));
        assert!(told[0].step == 3 && told[0].heat > 0.0 && told[0].place > 0.0, "{told:?}");
        let detector = Detector::load(&path, None).expect("a detector");
        std::fs::remove_file(&path).expect("removes");
        assert_eq!(detector.kind(), Kind::Own);
        let none = TrainOptions { batch: 0, ..options };
        let error = train(&none, &path, &on, |_| ()).expect_err("no windows").to_string();
        assert!(error.contains("batch"), "{error}");
        for rate in [-1e-3, 0.0, f64::NAN] {
            let wrong = TrainOptions { rate, ..options };
            let error = train(&wrong, &path, &on, |_| ()).expect_err("no rate").to_string();
            assert!(error.starts_with("rate: expected a positive number"), "{error}");
        }
    }

    #[test]
    fn a_training_that_is_stopped_writes_what_it_has() {
        let path = std::env::temp_dir().join(format!("paid-vision-stop-{}.onnx", std::process::id()));
        let options = TrainOptions { steps: 1000, batch: 1, ..TrainOptions::default() };
        let done = train(&options, &path, &AtomicBool::new(true), |_| ()).expect("trains");
        assert_eq!(done, 1);
        Detector::load(&path, None).expect("a detector");
        std::fs::remove_file(&path).expect("removes");
    }

    #[test]
    fn the_rate_rises_and_falls() {
        let options = TrainOptions { steps: 1000, rate: 1.0, ..TrainOptions::default() };
        assert!(rate(&options, 0) < 0.05 && (rate(&options, 30) - 1.0).abs() < 1e-3);
        assert!((rate(&options, 515) - 0.5).abs() < 1e-9 && rate(&options, 999) < 1e-4);
    }
}
