//! `f32` buffers in and out of every lane type.

use core::any::Any;

use crate::{MAX_LANES, Real, Scalar};

/// Reads `V::LANES` numbers of an `f32` buffer, such as the learner's, into any lane type.
///
/// # Panics
/// If `x` is shorter.
#[inline(always)]
pub fn load_f32<V: Real>(x: &[f32]) -> V {
    let x = &x[..V::LANES];
    // Where the lanes are f32 this is one load; the compiler does not see that through element-wise conversion.
    if let Ok(eight) = <&[f32; 8]>::try_from(x)
        && let Some(same) = (eight as &dyn Any).downcast_ref::<[V::Scalar; 8]>()
    {
        return V::load(same);
    }
    if let Ok(sixteen) = <&[f32; 16]>::try_from(x)
        && let Some(same) = (sixteen as &dyn Any).downcast_ref::<[V::Scalar; 16]>()
    {
        return V::load(same);
    }
    let mut lanes = [V::Scalar::default(); MAX_LANES];
    for lane in 0..V::LANES {
        lanes[lane] = V::Scalar::from_f64(f64::from(x[lane]));
    }
    V::load(&lanes[..V::LANES])
}

/// Writes `V::LANES` numbers of any lane type into an `f32` buffer.
///
/// # Panics
/// If `out` is shorter.
#[inline(always)]
pub fn store_f32<V: Real>(value: V, out: &mut [f32]) {
    let out = &mut out[..V::LANES];
    if let Ok(eight) = <&mut [f32; 8]>::try_from(&mut *out)
        && let Some(same) = (eight as &mut dyn Any).downcast_mut::<[V::Scalar; 8]>()
    {
        value.store(same);
        return;
    }
    if let Ok(sixteen) = <&mut [f32; 16]>::try_from(&mut *out)
        && let Some(same) = (sixteen as &mut dyn Any).downcast_mut::<[V::Scalar; 16]>()
    {
        value.store(same);
        return;
    }
    let mut lanes = [V::Scalar::default(); MAX_LANES];
    value.store(&mut lanes[..V::LANES]);
    for lane in 0..V::LANES {
        out[lane] = lanes[lane].to_f64() as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::F32Array;

    #[test]
    fn f32_numbers_enter_and_leave_every_lane_type() {
        let numbers: Vec<f32> = (0..20).map(|k| 0.1 * k as f32).collect();
        let mut out = [0.0; 20];
        store_f32(load_f32::<F32Array<8>>(&numbers[2..]), &mut out[2..]);
        assert_eq!(out[..10], [&[0.0, 0.0], &numbers[2..10]].concat());
        store_f32(load_f32::<F32Array<16>>(&numbers[3..]), &mut out[3..]);
        assert_eq!(out[3..19], numbers[3..19]);
        store_f32(load_f32::<f64>(&numbers[19..]), &mut out[19..]);
        assert_eq!(out[19], numbers[19]);
    }
}
