//! Evaluates a detector on rendered images that training never saw.

mod sheet;
mod table;

pub use sheet::{Bad, sheet};
pub use table::{Report, Row};

use crate::detect::{Depth, Detection, Detector};
use crate::locate::BallFinder;
use crate::render::render;
use crate::scatter::{Scatter, TrueBall, UNSEEN_PATTERN, Use};
use crate::{ColorImage, Intrinsics, PixelBox, Pose, VisionError};
use cpu_time::ThreadTime;

/// Which images a detector is evaluated on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgeOptions {
    /// Images with a ball, and as many without.
    pub pictures: u32,
    /// Numbers the scenes.
    pub seed: u64,
    /// The camera.
    pub intrinsics: Intrinsics,
    /// Images on the sheet of the worst.
    pub worst: usize,
}

/// With less of a ball in view than this, finding it is neither right nor wrong.
pub const LEAST_SHOWN: f64 = 0.25;

/// What an image had and what was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Case {
    pub ball: TrueBall,
    /// Share of the ball's outline that shows the ball.
    pub shown: f64,
    pub found: bool,
    /// Distance of the found place from the true one `[m]`; `None` without a detection.
    pub error_m: Option<f64>,
}

/// Evaluates a detector. `report` is called after every pair of images.
///
/// A ball counts as found if the middle of a detection is within half the ball's width of its own; every other detection in an image
/// is a false ball.
///
/// # Errors
/// If the options make no sense or the detector fails.
pub fn judge(
    detector: &Detector,
    options: &JudgeOptions,
    mut report: impl FnMut(u32),
) -> Result<Report, VisionError> {
    options.intrinsics.check()?;
    if options.pictures == 0 || options.pictures > 1 << 30 {
        return Err(VisionError::value("held-out images", "1 or more", options.pictures.to_string()));
    }
    let scatter = Scatter::new(Use::HeldOut, options.seed)?;
    let mut cases = Vec::new();
    // Half of the sheet for each kind of fault.
    let mut missed = sheet::Worst::new(options.worst.div_ceil(2));
    let mut invented = sheet::Worst::new(options.worst / 2);
    let (mut false_balls, mut false_places, mut render_s, mut detect_s) = (0_u32, 0_u32, 0.0, 0.0);
    for number in 0..2 * options.pictures {
        let with_ball = number % 2 == 0;
        let start = ThreadTime::now();
        let sample = scatter.sample(number, options.intrinsics, with_ball);
        let rendered = render(&sample.scene, &sample.view);
        let picture = rendered.color(&sample.color);
        let depth = rendered.depth(&sample.depth);
        let rendered_s = start.elapsed().as_secs_f64();
        let detections =
            detector.detect(&picture, Some(Depth { image: &depth, intrinsics: &options.intrinsics }))?;
        detect_s += start.elapsed().as_secs_f64() - rendered_s;
        render_s += rendered_s;
        // As the robot does it; the camera's pose is exact, and the floor is where it is.
        let placed = |found: &Detection, radius: f64| {
            let finder = BallFinder::new(options.intrinsics, Pose::identity(), radius).ok()?;
            let sighting = finder.sight_from(&sample.view.pose, found, Some(&depth), 0.0, 0.0).ok()?;
            Some(sighting.position)
        };
        let mut others: Vec<&Detection> = detections.iter().collect();
        let outline = sample.ball.and_then(|ball| ball.outline);
        if let (Some(ball), Some(outline)) = (sample.ball, outline) {
            let shown = share(rendered.ball_pixels(), &outline);
            let hit = detections.iter().find(|d| same(&d.outline, &outline));
            others.retain(|d| !same(&d.outline, &outline));
            if shown >= LEAST_SHOWN {
                let error_m = hit.and_then(|hit| {
                    let place = placed(hit, ball.radius)?;
                    Some((0..3).map(|k| (place[k] - ball.center[k]).powi(2)).sum::<f64>().sqrt())
                });
                cases.push(Case { ball, shown, found: hit.is_some(), error_m });
                if hit.is_none() {
                    missed.add(shown, || Bad {
                        number,
                        picture: picture.clone(),
                        missed: Some(outline),
                        invented: Vec::new(),
                    });
                }
            }
        }
        false_balls += others.len() as u32;
        let radius = sample.ball.map_or(0.11, |ball| ball.radius);
        false_places += others.iter().filter(|d| placed(d, radius).is_some()).count() as u32;
        if let Some(surest) = others.first() {
            let boxes: Vec<PixelBox> = others.iter().map(|d| d.outline).collect();
            invented.add(surest.score, || Bad {
                number,
                picture: picture.clone(),
                missed: None,
                invented: boxes,
            });
        }
        if !with_ball {
            report(number / 2 + 1);
        }
    }
    let pictures = 2 * options.pictures;
    Ok(Report {
        pictures,
        rows: table::rows(&cases),
        false_balls,
        false_per_1000: f64::from(false_balls) * 1000.0 / f64::from(pictures),
        false_places_per_1000: f64::from(false_places) * 1000.0 / f64::from(pictures),
        render_ms: 1e3 * render_s / f64::from(pictures),
        detect_ms: 1e3 * detect_s / f64::from(pictures),
        worst: missed.into_sorted().into_iter().chain(invented.into_sorted()).collect(),
    })
}

/// The share of an outline that shows the ball.
fn share(pixels: usize, outline: &PixelBox) -> f64 {
    (pixels as f64 / (std::f64::consts::FRAC_PI_4 * outline.area()).max(1.0)).min(1.0)
}

/// Whether a detection means this ball: middles within half its width.
fn same(found: &PixelBox, truth: &PixelBox) -> bool {
    let (a, b, size) = (found.middle(), truth.middle(), truth.size());
    let apart = (a[0] - b[0]).hypot(a[1] - b[1]);
    apart < 0.25 * (size[0] + size[1])
}

/// Whether training never showed this ball's pattern.
fn unseen(ball: &TrueBall) -> bool {
    ball.pattern == UNSEEN_PATTERN
}

/// An image's copy with boxes.
fn framed(picture: &ColorImage, boxes: &[(PixelBox, [u8; 3])]) -> ColorImage {
    let mut out = picture.clone();
    for (outline, color) in boxes {
        let [low, high] = [outline.min, outline.max].map(|p| p.map(|v| v.clamp(-1e4, 1e4).round() as i64));
        for x in low[0] - 2..=high[0] + 1 {
            out.set(x, low[1] - 2, *color);
            out.set(x, high[1] + 1, *color);
        }
        for y in low[1] - 2..=high[1] + 1 {
            out.set(low[0] - 2, y, *color);
            out.set(high[0] + 1, y, *color);
        }
    }
    out
}
