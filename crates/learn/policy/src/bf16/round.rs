//! Rounding to bfloat16, as the processor's own instruction does it.

/// Exponent bits of an f32.
const EXPONENT: u32 = 0x7F80_0000;

/// The bfloat16 nearest to `x`, ties to even. Denormal numbers become zero, as in the processor's products.
#[inline(always)]
pub fn round(x: f32) -> u16 {
    let bits = x.to_bits();
    if bits & EXPONENT == 0 {
        return (bits >> 16) as u16 & 0x8000;
    }
    if x.is_nan() {
        // Quiet, and with a mantissa that is not lost.
        return (bits >> 16) as u16 | 0x40;
    }
    ((bits + 0x7FFF + (bits >> 16 & 1)) >> 16) as u16
}

/// The f32 of the same value.
#[inline(always)]
pub fn widen(x: u16) -> f32 {
    f32::from_bits(u32::from(x) << 16)
}

/// `x`, with denormal numbers as zero.
#[inline(always)]
pub(super) fn flush(x: f32) -> f32 {
    if x.to_bits() & EXPONENT == 0 { f32::from_bits(x.to_bits() & 0x8000_0000) } else { x }
}

/// Two numbers of the inner dimension, the earlier one in the low half.
#[inline(always)]
pub(super) fn pair(first: f32, second: f32) -> u32 {
    u32::from(round(first)) | u32::from(round(second)) << 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_to_the_nearest_and_to_even() {
        // Between 1 and 1 + 2^-7 lies 1 + 2^-8, a tie.
        assert_eq!(widen(round(1.0 + 1.0 / 256.0)), 1.0);
        assert_eq!(widen(round(1.0 + 3.0 / 256.0)), 1.0 + 4.0 / 256.0);
        assert_eq!(widen(round(1.0 + 1.1 / 256.0)), 1.0 + 2.0 / 256.0);
        assert_eq!(widen(round(-2.5)), -2.5);
        assert_eq!(widen(round(f32::MAX)), f32::INFINITY);
        assert!(widen(round(f32::NAN)).is_nan());
        assert_eq!(round(-1e-40), 0x8000);
        assert_eq!(flush(1e-40), 0.0);
    }
}
