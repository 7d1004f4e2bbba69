//! Counter-based random numbers: the value depends only on (seed, environment, stream, counter).
//!
//! Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011). No state is shared
//! between environments, so results do not depend on thread or lane counts.

mod lanes;

pub use lanes::{fill_normal, fill_symmetric, philox_lanes};

const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];

/// Philox4x32-10: encrypts `counter` under `key`.
#[inline(always)]
pub fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for _ in 0..10 {
        let a = u64::from(MULTIPLIERS[0]) * u64::from(counter[0]);
        let b = u64::from(MULTIPLIERS[1]) * u64::from(counter[2]);
        counter = [
            (b >> 32) as u32 ^ counter[1] ^ key[0],
            b as u32,
            (a >> 32) as u32 ^ counter[3] ^ key[1],
            a as u32,
        ];
        key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
    }
    counter
}

/// Uniform in [0, 1) with 24 random bits.
#[inline(always)]
pub fn unit_f32(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A stream of random numbers. Cheap to copy; two words of position are all its state.
///
/// ```
/// use paid_lanes::rng::Rng;
///
/// let mut rng = Rng::new(42, 7, 0); // seed, environment, stream
/// let first = rng.uniform(-1.0, 1.0);
/// let position = rng.position();
/// let second = rng.normal();
/// // A stream continues where it was saved.
/// let mut resumed = Rng::new(42, 7, 0);
/// resumed.seek(position);
/// assert_eq!(resumed.normal(), second);
/// assert!((-1.0..1.0).contains(&first));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rng {
    key: [u32; 2],
    stream: [u32; 2],
    position: u64,
}

impl Rng {
    /// The stream `stream` of environment `env` under `seed`.
    pub fn new(seed: u64, env: u32, stream: u32) -> Self {
        Self { key: [seed as u32, (seed >> 32) as u32], stream: [env, stream], position: 0 }
    }

    /// The number of 32-bit words drawn so far: save it, and restore it with [`Rng::seek`].
    pub fn position(&self) -> u64 {
        self.position
    }

    /// Continues as if `position` words had been drawn.
    pub fn seek(&mut self, position: u64) {
        self.position = position;
    }

    /// The next 32 random bits.
    #[inline]
    pub fn next_u32(&mut self) -> u32 {
        let block = self.position >> 2;
        let words = philox([block as u32, (block >> 32) as u32, self.stream[0], self.stream[1]], self.key);
        let word = words[(self.position & 3) as usize];
        self.position += 1;
        word
    }

    /// Uniform in [0, 1).
    #[inline]
    pub fn unit(&mut self) -> f64 {
        f64::from(self.next_u32()) * (1.0 / 4_294_967_296.0)
    }

    /// Uniform in [lo, hi).
    #[inline]
    pub fn uniform(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// Uniform in 0..n. Panics if `n` is zero.
    pub fn below(&mut self, n: usize) -> usize {
        assert!(n > 0, "a choice needs at least one option");
        ((u64::from(self.next_u32()) * n as u64) >> 32) as usize
    }

    /// Standard normal, by Box and Muller.
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (core::f64::consts::TAU * self.unit()).cos()
    }

    /// Fills `out` with uniform numbers in [0, 1), four per block; faster than one call per number.
    #[inline(always)]
    pub fn fill_unit(&mut self, out: &mut [f32]) {
        // Start on a fresh block so that whole blocks are used.
        let mut block = self.position.div_ceil(4);
        for chunk in out.chunks_mut(4) {
            let words =
                philox([block as u32, (block >> 32) as u32, self.stream[0], self.stream[1]], self.key);
            for (value, word) in chunk.iter_mut().zip(words) {
                *value = unit_f32(word);
            }
            block += 1;
        }
        self.position = 4 * block;
    }
}
