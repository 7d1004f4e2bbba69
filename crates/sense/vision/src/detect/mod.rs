//! Finding the ball in a picture, with the project's own network or a detector of the user.

mod boxes;
mod decode;
mod kind;
mod letterbox;
mod mask;

pub use kind::Kind;
pub use letterbox::{Anchor, Coding, Letterbox};
pub use mask::Mask;

use std::path::Path;

use paid_onnx::{OnnxFile, RawModel};

use crate::{ColorImage, DepthImage, Intrinsics, PixelBox, VisionError};
use kind::Interface;

/// The committed network.
const OWN: &[u8] = include_bytes!("../../assets/ball.onnx");

/// What counts as a find.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectOptions {
    /// Which class is the ball. COCO's "sports ball" is 32.
    pub class: usize,
    /// Smallest score, 0 to 1.
    pub confidence: f64,
    /// Boxes that overlap by more are one, 0 to 1.
    pub iou: f64,
    /// Most finds in a picture.
    pub most: usize,
}

impl DetectOptions {
    /// For a kind of detector: class 32 where there are COCO's 80 classes, else the first; scores as the networks' makers use them (0.25 and
    /// overlap 0.45), and for the own network the score that its evaluation was made with.
    pub fn of(kind: Kind) -> Self {
        let class = if kind.classes() == 80 { 32 } else { 0 };
        let confidence = if kind == Kind::Own { 0.5 } else { 0.25 };
        Self { class, confidence, iou: 0.45, most: 10 }
    }
}

/// A ball that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// The box in the picture `[px]`.
    pub outline: PixelBox,
    /// 0 to 1.
    pub score: f64,
    /// The ball's pixels, if the detector tells them.
    pub mask: Option<Mask>,
    /// Whether the box means the whole ball, seen or not, as the own network's does. Others box what is seen.
    pub whole: bool,
}

/// The depth picture beside a color picture, aligned to it.
#[derive(Clone, Copy, Debug)]
pub struct Depth<'a> {
    /// As large as the color picture; of another size it is not looked at.
    pub image: &'a DepthImage,
    /// The camera of both.
    pub intrinsics: &'a Intrinsics,
}

/// A network that finds balls; runs on the calling thread.
#[derive(Debug)]
pub struct Detector {
    model: RawModel,
    interface: Interface,
    options: DetectOptions,
}

impl Detector {
    /// The committed network.
    ///
    /// # Errors
    /// If the runtime refuses it.
    pub fn own() -> Result<Self, VisionError> {
        Self::from_file(OnnxFile::from_bytes(OWN.to_vec(), Path::new("ball.onnx"))?, None)
    }

    /// A detector of the user: YOLOv8, YOLOv8-seg or YOLOX with raw heads, or the own network trained anew. `class` is the number of the
    /// ball's class, if it is not the usual one.
    ///
    /// # Errors
    /// If the file cannot be read or run, is of another kind, or has no such class.
    pub fn load(path: &Path, class: Option<usize>) -> Result<Self, VisionError> {
        Self::from_file(OnnxFile::read(path)?, class)
    }

    /// As [`Self::load`], from a file that was read.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn from_file(file: OnnxFile, class: Option<usize>) -> Result<Self, VisionError> {
        let interface = Interface::of(&file)?;
        let mut options = DetectOptions::of(interface.kind);
        if let Some(class) = class {
            if class >= interface.kind.classes() {
                return Err(VisionError::value(
                    format!("{}: class", file.path().display()),
                    format!("0 to {}", interface.kind.classes() - 1),
                    class.to_string(),
                ));
            }
            options.class = class;
        }
        let detector = Self { model: RawModel::new(file)?, interface, options };
        // Layers that do not fit each other are found now and not on the pitch.
        let Interface { kind, size, .. } = &detector.interface;
        detector.run(&vec![0.5; kind.inputs() * size[0] * size[1]])?;
        Ok(detector)
    }

    /// Which kind it is.
    pub fn kind(&self) -> Kind {
        self.interface.kind
    }

    /// What counts as a find.
    pub fn options(&self) -> &DetectOptions {
        &self.options
    }

    /// The same network with another least score.
    #[must_use]
    pub fn with_confidence(mut self, confidence: f64) -> Self {
        self.options.confidence = confidence;
        self
    }

    /// Balls in a picture, the surest first. The own network looks at depth too, and finds less without; the others see only color.
    ///
    /// # Errors
    /// If the runtime fails.
    pub fn detect(
        &self,
        picture: &ColorImage,
        depth: Option<Depth<'_>>,
    ) -> Result<Vec<Detection>, VisionError> {
        let Interface { kind, size, .. } = &self.interface;
        let shape = [picture.width, picture.height];
        let fit = Letterbox::fit(shape, *size, kind.anchor());
        let mut input = fit.fill(picture, *size, kind.coding());
        if *kind == Kind::Own {
            let depth = depth.filter(|d| [d.image.width, d.image.height] == shape);
            input.extend(fit.fill_depth(depth, *size));
        }
        let outputs = self.run(&input)?;
        let [first, rest @ ..] = &outputs[..] else { return Ok(Vec::new()) };
        let DetectOptions { class, confidence, iou, most } = self.options;
        let cells = kind::cells(*size);
        let candidates = match kind {
            Kind::Own => decode::own(first, confidence),
            Kind::YoloV8 { .. } => decode::yolo_v8(first, cells, class, confidence),
            Kind::YoloX { classes } => decode::yolo_x(first, *size, *classes, class, confidence),
        };
        let found = boxes::suppress(candidates, iou, most).into_iter().filter_map(|candidate| {
            let outline = fit.to_picture(&candidate.outline);
            // In the gray beside the picture there is nothing to find.
            if outline.clipped(shape[0], shape[1]).area() <= 0.0 {
                return None;
            }
            let mask = match (kind, rest.first()) {
                (Kind::YoloV8 { classes, masks: true }, Some(prototypes)) => {
                    let coefficients: Vec<f32> = first[(4 + classes) * cells..]
                        .iter()
                        .skip(candidate.index)
                        .step_by(cells)
                        .copied()
                        .collect();
                    let grid = [size[0] / 4, size[1] / 4];
                    Some(Mask::of_prototypes(&coefficients, prototypes, grid, 4.0, &outline, &fit, shape))
                }
                _ => None,
            };
            Some(Detection { outline, score: candidate.score, mask, whole: *kind == Kind::Own })
        });
        Ok(found.collect())
    }

    /// The outputs of an input.
    pub(crate) fn run(&self, input: &[f32]) -> Result<Vec<Vec<f32>>, VisionError> {
        let Interface { kind, input: name, size, outputs } = &self.interface;
        let wanted: Vec<(&str, usize)> =
            outputs.iter().map(|(name, numbers)| (name.as_str(), *numbers)).collect();
        Ok(self.model.run(&[(name, vec![1, kind.inputs(), size[1], size[0]], input)], &wanted)?)
    }

    /// The input of the network, across and down `[px]`.
    pub fn input_size(&self) -> [usize; 2] {
        self.interface.size
    }
}

#[cfg(test)]
mod tests;
