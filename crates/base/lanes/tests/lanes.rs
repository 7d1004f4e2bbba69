//! Every lane type computes the same functions as `f64`.

use paid_lanes::rng::{Rng, philox};
use paid_lanes::{F32Array, Isa, IsaVisitor, Kernel, Mask, Quat, Real, Vec3};
use proptest::prelude::*;

/// Evaluates one function in all lanes of the lane type of an instruction set.
struct Eval {
    function: &'static str,
    a: Vec<f32>,
    b: Vec<f32>,
}

impl IsaVisitor for Eval {
    type Output = Vec<f32>;
    fn visit<V: Real<Scalar = f32>>(self) -> Vec<f32> {
        struct Run<V>(Eval, core::marker::PhantomData<V>);
        impl<V: Real<Scalar = f32>> Kernel for Run<V> {
            type Output = Vec<f32>;
            #[inline(always)]
            fn run(self) -> Vec<f32> {
                let mut out = vec![0.0; V::LANES];
                let (a, b) = (V::load(&self.0.a), V::load(&self.0.b));
                let y = match self.0.function {
                    "sin" => a.sin_cos().0,
                    "cos" => a.sin_cos().1,
                    "exp" => a.exp(),
                    "tanh" => a.tanh(),
                    "atan2" => a.atan2(b),
                    "floor" => a.floor(),
                    "rsqrt" => a.abs().max(V::c(1e-6)).rsqrt(),
                    "recip" => a.recip(),
                    "select" => V::select(a.lt(b), a, b),
                    other => panic!("no function {other}"),
                };
                y.store(&mut out);
                out
            }
        }
        V::run(Run::<V>(self, core::marker::PhantomData))
    }
}

fn reference(function: &str, a: f64, b: f64) -> f64 {
    match function {
        "sin" => a.sin(),
        "cos" => a.cos(),
        "exp" => a.exp(),
        "tanh" => a.tanh(),
        "atan2" => a.atan2(b),
        "floor" => a.floor(),
        "rsqrt" => 1.0 / a.abs().max(1e-6).sqrt(),
        "recip" => 1.0 / a,
        _ => a.min(b),
    }
}

fn available() -> impl Iterator<Item = Isa> {
    [Isa::Avx512, Isa::Avx2, Isa::Portable].into_iter().filter(|isa| isa.available())
}

proptest! {
    #[test]
    fn every_function_agrees_with_f64(a in prop::array::uniform16(-30f32..30.0), b in prop::array::uniform16(-5f32..5.0)) {
        for isa in available() {
            for function in ["sin", "cos", "exp", "tanh", "atan2", "floor", "rsqrt", "recip", "select"] {
                let out = isa.dispatch(Eval { function, a: a.to_vec(), b: b.to_vec() });
                for i in 0..isa.lanes() {
                    let want = reference(function, f64::from(a[i]), f64::from(b[i]));
                    let error = (f64::from(out[i]) - want).abs();
                    prop_assert!(error <= 1e-6 * (1.0 + want.abs()), "{isa} {function}({}, {}) = {}, want {want}", a[i], b[i], out[i]);
                }
            }
        }
    }

    #[test]
    fn quaternion_matrix_and_rotation_agree(roll in -3.0..3.0, pitch in -1.5..1.5, yaw in -3.0..3.0, v in prop::array::uniform3(-2.0..2.0)) {
        let q = Quat::<f64>::from_roll_pitch_yaw(roll, pitch, yaw);
        let v = Vec3::c(v);
        let (a, b) = (q.rotate(v), q.to_mat().mul_vec(v));
        prop_assert!((a - b).norm() < 1e-12);
        prop_assert!((q.conj().rotate(a) - v).norm() < 1e-12);
        let m = q.to_mat();
        let by_matrix = m.tr_mul_mat(&m).angle();
        prop_assert!(by_matrix < 1e-7);
        let heading = m.yaw_only().tr_mul_mat(&m).yaw();
        prop_assert!(heading.abs() < 1e-9);
    }
}

#[test]
fn a_rotation_matrix_gives_its_quaternion_whichever_axis_it_turns_about() {
    // Half turns about x, y, z and a small turn: each takes another of the four branches.
    for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]] {
        for angle in [0.2, std::f64::consts::PI - 0.01] {
            let q: Quat<f64> = Quat::from_axis_angle(Vec3(axis), angle);
            let found = q.to_mat().to_quat();
            let dot: f64 = q.0.iter().zip(found.0).map(|(a, b)| a * b).sum();
            assert!((dot.abs() - 1.0).abs() < 1e-9, "{axis:?} {angle}: {found:?}");
        }
    }
}

#[test]
fn masks_round_trip_through_bits() {
    type V = F32Array<8>;
    let m = <V as Real>::Mask::from_bits(0b1010_0110);
    assert_eq!(m.bits(), 0b1010_0110);
    assert_eq!(m.not().bits(), 0b0101_1001);
    assert!(m.lane(1) && !m.lane(0) && m.any());
}

#[test]
fn non_finite_lanes_are_found() {
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(!Real::is_finite(x));
    }
    assert!(Real::is_finite(-3.0));
}

#[test]
fn philox_matches_the_published_test_vectors() {
    // Random123 1.09, kat_vectors: philox4x32-10 for all-zero and all-one inputs.
    assert_eq!(philox([0; 4], [0; 2]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
    assert_eq!(philox([u32::MAX; 4], [u32::MAX; 2]), [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]);
}

#[test]
fn a_stream_resumes_at_its_position() {
    let mut a = Rng::new(7, 3, 1);
    let first: Vec<u32> = (0..9).map(|_| a.next_u32()).collect();
    let mut b = Rng::new(7, 3, 1);
    b.seek(5);
    assert_eq!((5..9).map(|_| b.next_u32()).collect::<Vec<_>>(), first[5..]);
}
