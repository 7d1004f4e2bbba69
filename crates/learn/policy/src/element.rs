//! Element types of networks, and lane-wise kernels over slices of them.

use paid_lanes::{Isa, IsaVisitor, Kernel, MAX_LANES, Real, Scalar};

use crate::matrix::{Mat, MatMut, product_f32, product_f64};

/// Element type of a network: `f32` in training, `f64` in gradient tests. Both run the same source.
pub trait Element: Scalar {
    /// Runs a kernel with the widest lanes of this CPU (`f64`: one lane).
    fn launch<K: Lanewise<Self>>(kernel: K) -> K::Output;

    /// `dst = a b`, or `dst += a b` if `accumulate`; the shapes fit.
    fn product(dst: MatMut<'_, Self>, a: Mat<'_, Self>, b: Mat<'_, Self>, accumulate: bool);

    /// `values`, if they are `f32`: only those have products in bfloat16.
    fn f32s(values: &[Self]) -> Option<&[f32]>;

    /// The same, writable.
    fn f32s_mut(values: &mut [Self]) -> Option<&mut [f32]>;
}

/// A computation over lanes of `S`. Mark the implementation and all that it calls `#[inline(always)]`.
pub trait Lanewise<S: Scalar> {
    /// What it returns.
    type Output;
    /// The body.
    fn run<V: Real<Scalar = S>>(self) -> Self::Output;
}

/// Enters a [`Lanewise`] kernel with the instruction set of `V` enabled.
struct Enter<K, V>(K, core::marker::PhantomData<V>);

impl<V: Real, K: Lanewise<V::Scalar>> Kernel for Enter<K, V> {
    type Output = K::Output;
    #[inline(always)]
    fn run(self) -> K::Output {
        self.0.run::<V>()
    }
}

/// Carries a kernel through the choice of the instruction set.
struct Choose<K>(K);

impl<K: Lanewise<f32>> IsaVisitor for Choose<K> {
    type Output = K::Output;
    fn visit<V: Real<Scalar = f32>>(self) -> K::Output {
        <V as Real>::run(Enter(self.0, core::marker::PhantomData::<V>))
    }
}

impl Element for f32 {
    fn product(dst: MatMut<'_, Self>, a: Mat<'_, Self>, b: Mat<'_, Self>, accumulate: bool) {
        product_f32(dst, a, b, accumulate);
    }

    fn launch<K: Lanewise<f32>>(kernel: K) -> K::Output {
        Isa::detect().dispatch(Choose(kernel))
    }

    fn f32s(values: &[Self]) -> Option<&[f32]> {
        Some(values)
    }

    fn f32s_mut(values: &mut [Self]) -> Option<&mut [f32]> {
        Some(values)
    }
}

impl Element for f64 {
    fn product(dst: MatMut<'_, Self>, a: Mat<'_, Self>, b: Mat<'_, Self>, accumulate: bool) {
        product_f64(dst, a, b, accumulate);
    }

    fn launch<K: Lanewise<f64>>(kernel: K) -> K::Output {
        <f64 as Real>::run(Enter(kernel, core::marker::PhantomData::<f64>))
    }

    fn f32s(_values: &[Self]) -> Option<&[f32]> {
        None
    }

    fn f32s_mut(_values: &mut [Self]) -> Option<&mut [f32]> {
        None
    }
}

/// Elements `i..i + LANES` of `x`, zero beyond its end.
#[inline(always)]
pub fn load<V: Real>(x: &[V::Scalar], i: usize) -> V {
    if i + V::LANES <= x.len() {
        V::load(&x[i..i + V::LANES])
    } else {
        let mut buffer = [V::Scalar::default(); MAX_LANES];
        let rest = x.len() - i;
        buffer[..rest].copy_from_slice(&x[i..]);
        V::load(&buffer)
    }
}

/// Writes lanes to elements `i..i + LANES` of `x`, dropping those beyond its end.
#[inline(always)]
pub fn store<V: Real>(value: V, x: &mut [V::Scalar], i: usize) {
    if i + V::LANES <= x.len() {
        value.store(&mut x[i..i + V::LANES]);
    } else {
        let mut buffer = [V::Scalar::default(); MAX_LANES];
        value.store(&mut buffer);
        let rest = x.len() - i;
        x[i..].copy_from_slice(&buffer[..rest]);
    }
}

/// Sum of the lanes, lane 0 first.
#[inline(always)]
pub fn sum<V: Real>(value: V) -> f64 {
    let mut buffer = [V::Scalar::default(); MAX_LANES];
    value.store(&mut buffer);
    let mut total = 0.0;
    for lane in 0..V::LANES {
        total += buffer[lane].to_f64();
    }
    total
}

/// Sum of the lanes that stand for elements `i..` of a slice of length `len`.
#[inline(always)]
pub fn sum_valid<V: Real>(value: V, i: usize, len: usize) -> f64 {
    let mut buffer = [V::Scalar::default(); MAX_LANES];
    value.store(&mut buffer);
    let mut total = 0.0;
    for lane in 0..V::LANES.min(len - i) {
        total += buffer[lane].to_f64();
    }
    total
}
