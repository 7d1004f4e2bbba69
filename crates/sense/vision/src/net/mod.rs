//! The project's own ball detector: its layers, its ONNX file, and what its output means.
//!
//! An image `[1, 4, 192, 320]` (red, green and blue from 0 to 1, and [`depth_code`]) becomes a map `[1, 5, 24, 40]`: for every cell of 8 x
//! 8 pixels the logit that the middle of a ball is in it, how far that middle is from the cell's middle (right and down, in cells), and the
//! logarithms of the ball's width and height in cells.

mod file;

#[cfg(test)]
pub(crate) use file::node;
pub use file::{OUTPUT, encode_net};

/// Numbers per pixel of the input.
pub const INPUTS: usize = 4;
/// Pixels of the input from left to right.
pub const WIDTH: usize = 320;
/// Pixels of the input from top to bottom.
pub const HEIGHT: usize = 192;
/// Pixels per cell of the output, both ways.
pub const STRIDE: usize = 8;
/// Numbers per cell.
pub const CHANNELS: usize = 5;

/// What a convolution is for. All have 3 x 3 taps and a ReLU, except [`Layer::Lateral`] and [`Layer::Out`] (1 x 1, no ReLU).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// Halves the image.
    Half,
    /// Is added to its own input.
    Residual,
    /// 1 x 1; its output is doubled in size and added to the last map of stride 8.
    Lateral,
    /// Reads the sum.
    Head,
    /// 1 x 1; the output.
    Out,
}

/// Every convolution in order: kind, channels in, channels out.
pub const LAYERS: [(Layer, usize, usize); 11] = [
    (Layer::Half, INPUTS, 16),
    (Layer::Half, 16, 32),
    (Layer::Half, 32, FINE),
    (Layer::Residual, FINE, FINE),
    (Layer::Half, FINE, COARSE),
    (Layer::Residual, COARSE, COARSE),
    (Layer::Residual, COARSE, COARSE),
    (Layer::Residual, COARSE, COARSE),
    (Layer::Lateral, COARSE, FINE),
    (Layer::Head, FINE, FINE),
    (Layer::Out, FINE, CHANNELS),
];

/// Channels at stride 8.
const FINE: usize = 48;
/// Channels at stride 16.
const COARSE: usize = 96;

/// Width of a usual ball `[m]`: the unit of the depth channel.
const BALL_M: f64 = 0.22;

/// The depth channel's value for a pixel's depth `[mm]` (0: not known) in an image of this focal length `[px of the input]`: half the
/// logarithm of the width in cells that a usual ball has there, which is the number that the network has to give for a ball. 0 for 8 pixels
/// and less (6.5 m and more at the G1's camera), and where depth is not known.
pub fn depth_code(depth_mm: u16, focal_px: f64) -> f32 {
    if depth_mm == 0 {
        return 0.0;
    }
    let width_px = BALL_M * focal_px / (f64::from(depth_mm) * 1e-3);
    (0.5 * (width_px / STRIDE as f64).ln()).clamp(0.0, 2.0) as f32
}

impl Layer {
    /// Taps across and down.
    pub fn taps(self) -> usize {
        match self {
            Self::Half | Self::Residual | Self::Head => 3,
            Self::Lateral | Self::Out => 1,
        }
    }

    /// Pixels between two outputs.
    pub fn stride(self) -> usize {
        if self == Self::Half { 2 } else { 1 }
    }

    /// Whether negative outputs are cut off.
    pub fn relu(self) -> bool {
        !matches!(self, Self::Lateral | Self::Out)
    }
}

/// Weights of a convolution, with the normalization of its training folded in.
#[derive(Clone, Debug, PartialEq)]
pub struct Convolution {
    /// `[out, in, taps, taps]`, row by row.
    pub weight: Vec<f32>,
    /// `[out]`.
    pub bias: Vec<f32>,
}

/// Number of weights and biases.
pub fn parameters() -> usize {
    LAYERS.iter().map(|(layer, inputs, outputs)| outputs * (inputs * layer.taps().pow(2) + 1)).sum()
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_network_is_small() {
        // 592 + 4640 + 13872 + 20784 + 41568 + 3 * 83040 + 4656 + 20784 + 245.
        assert_eq!(super::parameters(), 356_261);
    }

    #[test]
    fn depth_is_given_as_the_width_of_a_ball() {
        // 0.22 m at 1.1 m and 200 px: 40 px, five cells.
        assert!((super::depth_code(1100, 200.0) - 0.5 * 5.0_f32.ln()).abs() < 1e-6);
        assert_eq!([super::depth_code(0, 200.0), super::depth_code(9000, 200.0)], [0.0, 0.0]);
        assert_eq!(super::depth_code(1, 200.0), 2.0);
    }
}
