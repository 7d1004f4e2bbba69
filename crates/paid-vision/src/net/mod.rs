//! The project's own ball detector: its layers, its ONNX file, and what its output means.
//!
//! A picture `[1, 3, 192, 320]` (RGB, 0 to 1) becomes a map `[1, 5, 24, 40]`: for every cell of 8 x 8 pixels the logit that the middle of a
//! ball is in it, how far that middle is from the cell's middle (right and down, in cells), and the logarithms of the ball's width and
//! height in cells.

mod file;

#[cfg(test)]
pub(crate) use file::node;
pub use file::{OUTPUT, encode_net};

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
    /// Halves the picture.
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
pub const LAYERS: [(Layer, usize, usize); 10] = [
    (Layer::Half, 3, 12),
    (Layer::Half, 12, 24),
    (Layer::Half, 24, FINE),
    (Layer::Residual, FINE, FINE),
    (Layer::Half, FINE, 64),
    (Layer::Residual, 64, 64),
    (Layer::Residual, 64, 64),
    (Layer::Lateral, 64, FINE),
    (Layer::Head, FINE, FINE),
    (Layer::Out, FINE, CHANNELS),
];

/// Channels at stride 8.
const FINE: usize = 32;

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
        // 336 + 2616 + 6944 + 9248 + 18496 + 2 * 36928 + 2080 + 9248 + 165.
        assert_eq!(super::parameters(), 122_989);
    }
}
