//! Which detector a file is, by the names and shapes of its input and outputs.

use paid_onnx::OnnxFile;
use paid_onnx::proto::{FLOAT, ValueInfo};

use super::letterbox::{Anchor, Coding};
use crate::VisionError;
use crate::net;

/// Coefficients of a YOLOv8-seg mask.
const COEFFICIENTS: usize = 32;

/// A kind of detector and its sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The project's own network, which sees depth too.
    Own,
    /// YOLOv8: `[1, 4 + classes, cells]`, and with masks `[1, 4 + classes + 32, cells]` and `[1, 32, h / 4, w / 4]`.
    YoloV8 {
        /// Number of classes.
        classes: usize,
        /// Whether it gives masks.
        masks: bool,
    },
    /// YOLOX: `[1, cells, 5 + classes]`, boxes not yet decoded.
    YoloX {
        /// Number of classes.
        classes: usize,
    },
}

/// What is known of a detector before it runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Interface {
    pub kind: Kind,
    /// Name of the input.
    pub input: String,
    /// Pixels of the input across and down.
    pub size: [usize; 2],
    /// Names of the outputs and their numbers.
    pub outputs: Vec<(String, usize)>,
}

impl Kind {
    pub(super) fn anchor(self) -> Anchor {
        if matches!(self, Self::YoloX { .. }) { Anchor::TopLeft } else { Anchor::Middle }
    }

    pub(super) fn coding(self) -> Coding {
        if matches!(self, Self::YoloX { .. }) { Coding::BgrBytes } else { Coding::RgbUnit }
    }

    /// Numbers per pixel of the input.
    pub(super) fn inputs(self) -> usize {
        if self == Self::Own { net::INPUTS } else { 3 }
    }

    /// Its maker's name for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Own => "this project's network",
            Self::YoloV8 { masks: false, .. } => "YOLOv8",
            Self::YoloV8 { masks: true, .. } => "YOLOv8-seg",
            Self::YoloX { .. } => "YOLOX",
        }
    }

    /// Number of its classes.
    pub fn classes(self) -> usize {
        match self {
            Self::Own => 1,
            Self::YoloV8 { classes, .. } | Self::YoloX { classes } => classes,
        }
    }
}

/// Cells of the strides 8, 16 and 32 together.
pub(super) fn cells([width, height]: [usize; 2]) -> usize {
    [8, 16, 32].iter().map(|s| (width / s) * (height / s)).sum()
}

impl Interface {
    /// Recognizes a file.
    ///
    /// # Errors
    /// If it is none of the known kinds: what these look like, and what the file has.
    pub(super) fn of(file: &OnnxFile) -> Result<Self, VisionError> {
        Self::recognize(file).ok_or_else(|| VisionError::Detector {
            path: file.path().to_owned(),
            expected: format!(
                "one float input of fixed shape [1, 3, H, W] (H and W multiples of 32) with the outputs of YOLOv8 [1, 4 + classes, cells], \
                 YOLOv8-seg [1, 4 + classes + {COEFFICIENTS}, cells] and [1, {COEFFICIENTS}, H/4, W/4], YOLOX [1, cells, 5 + classes]; or \
                 this project's input [1, {}, {}, {}] with the output '{}' [1, {}, {}, {}]; cells = HW/64 + HW/256 + HW/1024; exported without built-in NMS, in 32 bits",
                net::INPUTS,
                net::HEIGHT,
                net::WIDTH,
                net::OUTPUT,
                net::CHANNELS,
                net::HEIGHT / net::STRIDE,
                net::WIDTH / net::STRIDE
            ),
            found: format!("inputs {}; outputs {}", told(file.inputs()), told(file.outputs())),
        })
    }

    fn recognize(file: &OnnxFile) -> Option<Self> {
        let [input] = file.inputs() else { return None };
        let [1, inputs, height, width] = shape(input)?[..] else { return None };
        let size = [width, height];
        if !size.iter().all(|s| (32..=4096).contains(s) && s % 32 == 0) {
            return None;
        }
        let outputs: Vec<(String, Vec<usize>)> =
            (file.outputs().iter()).map(|o| Some((o.name.clone()?, shape(o)?))).collect::<Option<_>>()?;
        let cells = cells(size);
        let kind = match &outputs[..] {
            [(name, dims)] if name == net::OUTPUT => {
                let expected = [1, net::CHANNELS, net::HEIGHT / net::STRIDE, net::WIDTH / net::STRIDE];
                (dims[..] == expected && size == [net::WIDTH, net::HEIGHT]).then_some(Kind::Own)?
            }
            [(_, dims)] => match dims[..] {
                [1, rows, n] if n == cells && rows > 4 => Kind::YoloV8 { classes: rows - 4, masks: false },
                [1, n, columns] if n == cells && columns > 5 => Kind::YoloX { classes: columns - 5 },
                _ => return None,
            },
            [(_, dims), (_, prototypes)] => match dims[..] {
                [1, rows, n]
                    if n == cells
                        && rows > 4 + COEFFICIENTS
                        && prototypes[..] == [1, COEFFICIENTS, height / 4, width / 4] =>
                {
                    Kind::YoloV8 { classes: rows - 4 - COEFFICIENTS, masks: true }
                }
                _ => return None,
            },
            _ => return None,
        };
        let outputs = outputs.into_iter().map(|(name, dims)| (name, dims.iter().product())).collect();
        if inputs != kind.inputs() {
            return None;
        }
        Some(Self { kind, input: input.name.clone()?, size, outputs })
    }
}

/// The fixed shape of a float value.
fn shape(value: &ValueInfo) -> Option<Vec<usize>> {
    let tensor = value.r#type.as_ref()?.tensor_type.as_ref()?;
    if tensor.elem_type != Some(FLOAT) {
        return None;
    }
    value.shape()?.into_iter().map(|d| usize::try_from(d).ok()).collect()
}

/// Names, shapes and types for an error.
fn told(values: &[ValueInfo]) -> String {
    let one = |value: &ValueInfo| {
        let name = value.name.as_deref().unwrap_or_default();
        let tensor = value.r#type.as_ref().and_then(|t| t.tensor_type.as_ref());
        let dims = tensor.and_then(|t| t.shape.as_ref()).map(|s| {
            let dims: Vec<String> =
                s.dim.iter().map(|d| d.dim_value.map_or_else(|| "?".to_owned(), |v| v.to_string())).collect();
            dims.join(", ")
        });
        let kind = match tensor.and_then(|t| t.elem_type) {
            Some(FLOAT) => "",
            Some(10) => " of 16-bit floats",
            _ => " of another type",
        };
        format!("'{name}' [{}]{kind}", dims.unwrap_or_else(|| "no shape".to_owned()))
    };
    if values.is_empty() { "none".to_owned() } else { values.iter().map(one).collect::<Vec<_>>().join(", ") }
}
