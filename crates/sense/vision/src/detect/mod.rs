//! Finding the ball in an image, with the project's own network or a detector of the user.

mod boxes;
mod decode;
mod kind;
mod letterbox;
mod mask;
mod named;
mod range;

pub use kind::Kind;
pub use letterbox::{Anchor, Coding, Letterbox};
pub use mask::Mask;

use std::path::Path;

use paid_onnx::{OnnxFile, RawModel};

use crate::{ColorImage, DepthImage, Intrinsics, PixelBox, VisionError};
use kind::Interface;

/// The committed network.
const OWN: &[u8] = include_bytes!("../../assets/ball.onnx");

/// What counts as a detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectOptions {
    /// Which class is the ball. COCO's "sports ball" is 32.
    pub class: usize,
    /// Smallest score, 0 to 1.
    pub confidence: f64,
    /// Boxes that overlap by more are one, 0 to 1.
    pub iou: f64,
    /// Most detections in an image.
    pub most: usize,
}

impl DetectOptions {
    /// For a kind of detector and its ball's class: scores as the networks' makers use them (0.25 and overlap 0.45), and for the project's
    /// network the score that its evaluation was made with.
    pub fn of(kind: Kind, class: usize) -> Self {
        let confidence = if kind == Kind::Own { 0.5 } else { 0.25 };
        Self { class, confidence, iou: 0.45, most: 10 }
    }
}

/// A ball that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// The box in the image `[px]`.
    pub outline: PixelBox,
    /// 0 to 1.
    pub score: f64,
    /// The ball's pixels, if the detector gives them.
    pub mask: Option<Mask>,
    /// Whether the box means the whole ball, seen or not, as the project's network's does. Others box what is seen.
    pub whole: bool,
}

/// The depth image that belongs to a color image, aligned to it.
#[derive(Clone, Copy, Debug)]
pub struct Depth<'a> {
    /// As large as the color image; one of another size is not used.
    pub image: &'a DepthImage,
    /// The camera of both.
    pub intrinsics: &'a Intrinsics,
}

/// A network that detects balls; runs on the calling thread.
#[derive(Debug)]
pub struct Detector {
    model: RawModel,
    interface: Interface,
    options: DetectOptions,
    /// Name of the ball's class, if the file has it.
    class: Option<String>,
}

impl Detector {
    /// The committed network.
    ///
    /// # Errors
    /// If the runtime refuses it.
    pub fn own() -> Result<Self, VisionError> {
        Self::from_file(OnnxFile::from_bytes(OWN.to_vec(), Path::new("ball.onnx"))?, None)
    }

    /// A detector of the user: YOLOv8, YOLOv8-seg or YOLOX with raw heads, or the project's network trained again. `class` is the number of
    /// the ball's class; without it, it is the one that the file names so, the only one, or COCO's 'sports ball'.
    ///
    /// # Errors
    /// If the file cannot be read or run, is of another kind, gives numbers that are no scores and boxes, has no such class, or does not
    /// tell which one is the ball.
    pub fn load(path: &Path, class: Option<usize>) -> Result<Self, VisionError> {
        Self::from_file(OnnxFile::read(path)?, class)
    }

    /// As [`Self::load`], from a file that was read.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn from_file(file: OnnxFile, class: Option<usize>) -> Result<Self, VisionError> {
        let interface = Interface::of(&file)?;
        let names = named::names(&file);
        named::check(&file, interface.kind, names.as_deref())?;
        let class = named::ball(&file, interface.kind, names.as_deref(), class)?;
        let options = DetectOptions::of(interface.kind, class);
        let class = names.and_then(|mut names| (class < names.len()).then(|| names.swap_remove(class)));
        let detector = Self { model: RawModel::new(file)?, interface, options, class };
        // Layers that do not fit each other and numbers of another kind are found now and not on the pitch.
        let Interface { kind, size, .. } = &detector.interface;
        detector.run(&vec![0.5; kind.inputs() * size[0] * size[1]])?;
        Ok(detector)
    }

    /// The file and what it was taken for: kind, size of the input and the ball's class. One line for the user, before the work.
    pub fn taken_for(&self) -> String {
        let Interface { kind, size: [width, height], .. } = &self.interface;
        let kind_and_size = format!("{} with an input of {width} x {height} pixels", self.kind_of_file());
        if *kind == Kind::Own {
            return kind_and_size;
        }
        let (class, classes) = (self.options.class, kind.classes());
        let name =
            self.class.as_ref().map_or_else(|| ", without a name".to_owned(), |name| format!(", {name:?}"));
        format!("{kind_and_size}; the ball is class {class} of {classes}{name}")
    }

    /// The file and the kind that it was taken for.
    fn kind_of_file(&self) -> String {
        format!("{}: taken for {}", self.model.path().display(), self.interface.kind.name())
    }

    /// Which kind it is.
    pub fn kind(&self) -> Kind {
        self.interface.kind
    }

    /// What counts as a detection.
    pub fn options(&self) -> &DetectOptions {
        &self.options
    }

    /// The same network with another least score.
    #[must_use]
    pub fn with_confidence(mut self, confidence: f64) -> Self {
        self.options.confidence = confidence;
        self
    }

    /// Balls in an image, the surest first. The project's network uses depth too, and detects fewer without; the others use only color.
    ///
    /// # Errors
    /// If the runtime fails, or gives numbers that are no scores and boxes.
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
            // In the gray around the image there is nothing to detect.
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

    /// The outputs of an input, which are those of a detector.
    pub(crate) fn run(&self, input: &[f32]) -> Result<Vec<Vec<f32>>, VisionError> {
        let Interface { kind, input: name, size, outputs } = &self.interface;
        let wanted: Vec<(&str, usize)> =
            outputs.iter().map(|(name, numbers)| (name.as_str(), *numbers)).collect();
        let outputs = self.model.run(&[(name, vec![1, kind.inputs(), size[1], size[0]], input)], &wanted)?;
        range::check(*kind, *size, outputs.first().map_or(&[], |first| first)).map_err(
            |[what, expected, found]| {
                let what = format!("{}: {what}", self.kind_of_file());
                VisionError::value(what, expected, found)
            },
        )?;
        Ok(outputs)
    }

    /// The input of the network, across and down `[px]`.
    pub fn input_size(&self) -> [usize; 2] {
        self.interface.size
    }
}

#[cfg(test)]
mod foreign_tests;
#[cfg(test)]
mod tests;
