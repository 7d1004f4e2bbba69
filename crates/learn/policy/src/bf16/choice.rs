//! Which kernel a training uses.

use std::sync::OnceLock;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::{Kernel, Panels, Rows};
use crate::matrix::{Mat, MatMut, multiply};

/// How the products of a training are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// The fastest that this machine has, by a measurement of some milliseconds at the start.
    #[default]
    Auto,
    /// f32 throughout.
    F32,
    /// Hidden layers in bfloat16 with f32 sums, on any machine: by plain loops, which are slow, where the processor cannot do it.
    Bf16,
}

/// Gain over f32 from which bfloat16 is chosen: far above the scatter of the measurement, so that a machine decides
/// the same way every time.
const GAIN: f64 = 1.25;

impl Precision {
    /// The kernel of the bfloat16 products; `None`: f32.
    pub fn kernel(self) -> Option<Kernel> {
        match self {
            Self::F32 => None,
            Self::Auto => fastest().filter(|speed| speed.gain >= GAIN).map(|speed| speed.kernel),
            Self::Bf16 => Some(fastest().map_or(Kernel::PORTABLE, |speed| speed.kernel)),
        }
    }
}

/// What the measurement found of a kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speed {
    /// The kernel.
    pub kernel: Kernel,
    /// Its speed over that of f32, packing included.
    pub gain: f64,
    /// Arithmetic `[GFLOP/s]`, one thread.
    pub gflop_per_s: f64,
}

/// The speeds of this machine's kernels, without the portable one, measured once.
pub fn speeds() -> &'static [Speed] {
    static SPEEDS: OnceLock<Vec<Speed>> = OnceLock::new();
    SPEEDS.get_or_init(|| {
        Kernel::available().into_iter().filter(|kernel| *kernel != Kernel::PORTABLE).map(measure).collect()
    })
}

fn fastest() -> Option<Speed> {
    speeds().iter().copied().max_by(|a, b| a.gain.total_cmp(&b.gain))
}

/// Compares a kernel with f32 on the product of a usual layer: the best of several rounds in turns, so that neither a slow start nor
/// a busy machine decides.
fn measure(kernel: Kernel) -> Speed {
    const SIZE: [usize; 3] = [256, 256, 240];
    const ROUNDS: usize = 12;
    let [rows, inner, cols] = SIZE;
    let a = vec![0.5_f32; rows * inner];
    let b = vec![0.25_f32; inner * cols];
    let mut out = vec![0.0_f32; rows * cols];
    let (a, b) = (Mat::new(&a, rows, inner, inner), Mat::new(&b, inner, cols, cols));
    let packed = Rows::new(kernel, a);
    let mut panels = Panels::default();
    let mut best = [f64::INFINITY; 2];
    for _ in 0..ROUNDS {
        let start = Instant::now();
        multiply(MatMut::new(&mut out, rows, cols, cols), a, b, false);
        let middle = Instant::now();
        panels.pack(kernel, b);
        kernel.multiply(MatMut::new(&mut out, rows, cols, cols), &packed, &panels, false);
        let took = [(middle - start).as_secs_f64(), middle.elapsed().as_secs_f64()];
        best = [best[0].min(took[0]), best[1].min(took[1])];
    }
    let flop = 2.0 * SIZE.iter().product::<usize>() as f64;
    Speed { kernel, gain: best[0] / best[1].max(1e-12), gflop_per_s: flop / best[1].max(1e-12) * 1e-9 }
}
