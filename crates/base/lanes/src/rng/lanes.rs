//! Random numbers for all lanes of a group at once, so that noise costs next to nothing.

use super::{MULTIPLIERS, WEYL, unit_f32};
use crate::{MAX_LANES, Real, load_f32};

/// Values that one block of the generator gives per lane: four 32-bit words as eight 16-bit halves.
const BLOCK: usize = 8;

/// [`philox`](super::philox) for `V::LANES` environments at once; word `w` of lane `l` is `[w][l]`.
///
/// The counter of lane `l` is `[counter[0], counter[1], stream[l], purpose]`, the key are the two halves of `seed`.
///
/// # Panics
/// If `stream` has fewer than `V::LANES` numbers.
#[inline(always)]
pub fn philox_lanes<V: Real>(
    counter: [u32; 2],
    stream: &[u32],
    purpose: u32,
    seed: u64,
) -> [[u32; MAX_LANES]; 4] {
    let mut x = [[0; MAX_LANES]; 4];
    for lane in 0..V::LANES {
        x[0][lane] = counter[0];
        x[1][lane] = counter[1];
        x[2][lane] = stream[lane];
        x[3][lane] = purpose;
    }
    let mut key = [seed as u32, (seed >> 32) as u32];
    for _ in 0..10 {
        for lane in 0..V::LANES {
            let a = u64::from(MULTIPLIERS[0]) * u64::from(x[0][lane]);
            let b = u64::from(MULTIPLIERS[1]) * u64::from(x[2][lane]);
            let (old1, old3) = (x[1][lane], x[3][lane]);
            x[0][lane] = (b >> 32) as u32 ^ old1 ^ key[0];
            x[1][lane] = b as u32;
            x[2][lane] = (a >> 32) as u32 ^ old3 ^ key[1];
            x[3][lane] = a as u32;
        }
        key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
    }
    x
}

/// Fills `out` with numbers uniform in (-1, 1), 65536 levels, symmetric about zero.
///
/// `envs` are the numbers of the environments, one per lane; `draw` counts the calls; `purpose` keeps different uses of
/// one seed apart. The same arguments give the same numbers, whatever the lane type. At most 2048 numbers per draw.
///
/// # Panics
/// If `envs` has fewer than `V::LANES` numbers.
///
/// ```
/// use paid_lanes::F32Array;
/// use paid_lanes::rng::fill_symmetric;
///
/// let mut eight = [F32Array([0.0; 8]); 3];
/// fill_symmetric(&mut eight, &[0, 1, 2, 3, 4, 5, 6, 7], 1, 42, 0);
/// // Environment 5 draws the same numbers alone.
/// let mut alone = [0.0_f64; 3];
/// fill_symmetric(&mut alone, &[5], 1, 42, 0);
/// assert_eq!(f64::from(eight[2].0[5]), alone[2]);
/// ```
#[inline(always)]
pub fn fill_symmetric<V: Real>(out: &mut [V], envs: &[u32], purpose: u32, seed: u64, draw: u64) {
    let blocks = out.len().div_ceil(BLOCK);
    for block in 0..blocks {
        // At most 256 blocks a draw: the block number is the low byte of the counter.
        let at = draw << 8 | block as u64;
        let words = philox_lanes::<V>([at as u32, (at >> 32) as u32], envs, purpose, seed);
        for half in 0..BLOCK.min(out.len() - block * BLOCK) {
            // Sixteen bits below the leading one of a number in [1, 2).
            let mut lanes = [0.0; MAX_LANES];
            for lane in 0..V::LANES {
                let bits = words[half / 2][lane] >> (16 * (half % 2) as u32) & 0xffff;
                lanes[lane] = f32::from_bits(0x3f80_0000 | bits << 7);
            }
            let middle = V::c(1.5 - 1.0 / 131_072.0);
            out[block * BLOCK + half] = (load_f32::<V>(&lanes) - middle) * V::c(2.0);
        }
    }
}

/// Fills `out` with standard normal numbers, by Box and Muller.
///
/// Arguments and reproducibility as for [`fill_symmetric`]; lane types differ in the last places. At most 1024 numbers per draw.
///
/// # Panics
/// If `envs` has fewer than `V::LANES` numbers.
#[inline(always)]
pub fn fill_normal<V: Real>(out: &mut [V], envs: &[u32], purpose: u32, seed: u64, draw: u64) {
    // A block of four words gives two angles and two radii, which are four numbers.
    for block in 0..out.len().div_ceil(4) {
        let at = draw << 8 | block as u64;
        let words = philox_lanes::<V>([at as u32, (at >> 32) as u32], envs, purpose, seed);
        for pair in 0..2 {
            let (mut radius, mut turns) = ([0.0; MAX_LANES], [0.0; MAX_LANES]);
            for lane in 0..V::LANES {
                radius[lane] = (-2.0 * (1.0 - unit_f32(words[2 * pair][lane])).ln()).sqrt();
                turns[lane] = unit_f32(words[2 * pair + 1][lane]);
            }
            let (sin, cos) = (load_f32::<V>(&turns) * V::c(core::f64::consts::TAU)).sin_cos();
            for (k, part) in [cos, sin].into_iter().enumerate() {
                if let Some(number) = out.get_mut(4 * block + 2 * pair + k) {
                    *number = load_f32::<V>(&radius) * part;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::F32Array;
    use crate::rng::philox;

    #[test]
    fn lanes_give_the_reference_generators_words() {
        let words = philox_lanes::<F32Array<8>>([7, 1], &[3, 4, 5, 6, 7, 8, 9, 10], 2, 0x1234_5678_9abc);
        for lane in 0..8 {
            let expected = philox([7, 1, 3 + lane as u32, 2], [0x5678_9abc, 0x1234]);
            for w in 0..4 {
                assert_eq!(words[w][lane], expected[w]);
            }
        }
    }

    #[test]
    fn noise_is_uniform_symmetric_and_independent_of_lanes() {
        let envs: Vec<u32> = (0..8).collect();
        let (mut sum, mut sum2, n) = (0.0, 0.0, 200);
        for draw in 0..n {
            let mut out = [F32Array([0.0; 8]); 67];
            fill_symmetric(&mut out, &envs, 1, 9, draw);
            let mut single = [0.0_f64; 67];
            fill_symmetric(&mut single, &envs[5..6], 1, 9, draw);
            for (value, one) in out.iter().zip(single) {
                assert_eq!(value.lane(5), one);
                for lane in 0..8 {
                    assert!(value.lane(lane).abs() < 1.0);
                    sum += value.lane(lane);
                    sum2 += value.lane(lane).powi(2);
                }
            }
        }
        let count = f64::from(n as u32) * 67.0 * 8.0;
        assert!((sum / count).abs() < 0.01, "{}", sum / count);
        assert!((sum2 / count - 1.0 / 3.0).abs() < 0.01, "{}", sum2 / count);
    }

    #[test]
    fn normal_numbers_have_their_moments_and_do_not_depend_on_lanes() {
        let envs: Vec<u32> = (0..8).collect();
        let (mut moments, n) = ([0.0; 4], 1000);
        let mut products = 0.0;
        for draw in 0..n {
            let mut out = [F32Array([0.0; 8]); 5];
            fill_normal(&mut out, &envs, 1, 9, draw);
            let mut single = [0.0_f64; 5];
            fill_normal(&mut single, &envs[5..6], 1, 9, draw);
            for (k, (value, one)) in out.iter().zip(single).enumerate() {
                assert!((value.lane(5) - one).abs() < 1e-5, "{k}: {} {one}", value.lane(5));
                for lane in 0..8 {
                    for (power, moment) in moments.iter_mut().enumerate() {
                        *moment += value.lane(lane).powi(power as i32 + 1);
                    }
                }
            }
            products += out[0].lane(0) * out[1].lane(0) + out[1].lane(1) * out[2].lane(1);
        }
        let count = f64::from(n as u32) * 40.0;
        // 0, 1, 0, 3, with deviations below 0.005, 0.007, 0.02 and 0.05; the products' mean has one of 0.02.
        for (moment, (expected, within)) in
            moments.iter().zip([(0.0, 0.02), (1.0, 0.03), (0.0, 0.06), (3.0, 0.15)])
        {
            assert!((moment / count - expected).abs() < within, "{moments:?}");
        }
        assert!((products / (2.0 * f64::from(n as u32))).abs() < 0.08, "{products}");
    }
}
