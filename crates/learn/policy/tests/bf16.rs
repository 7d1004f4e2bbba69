//! Products in bfloat16: every kernel of this machine against plain loops, and the plain loops against sums in f64.

use paid_lanes::rng::Rng;
use paid_policy::bf16::{Kernel, Panels, Precision, Rows, round, speeds, widen};
use paid_policy::matrix::{Mat, MatMut};
use paid_policy::net::{Network, PackedWeights, State, StepWorkspace, Weights};
use paid_policy::{LstmConfig, NetworkConfig, NetworkKind};

fn normals(n: usize, seed: u64) -> Vec<f32> {
    let mut rng = Rng::new(seed, 0, 0);
    (0..n).map(|_| rng.normal() as f32).collect()
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|x| x.to_bits()).collect()
}

/// `dst (+)= a b` of dense matrices by one kernel; `dst` begins as ones, its rows three apart from dense.
fn product(
    kernel: Kernel,
    [rows, inner, cols]: [usize; 3],
    a: &[f32],
    b: &[f32],
    accumulate: bool,
) -> Vec<f32> {
    let left = Rows::new(kernel, Mat::new(a, rows, inner, inner));
    let right = Panels::new(kernel, Mat::new(b, inner, cols, cols));
    let stride = cols + 3;
    let mut dst = vec![1.0; rows * stride];
    kernel.multiply(MatMut::new(&mut dst, rows, cols, stride), &left, &right, accumulate);
    for row in dst.chunks(stride) {
        assert!(row[cols..].iter().all(|x| *x == 1.0), "elements next to the result stay as they are");
    }
    dst.chunks(stride).flat_map(|row| row[..cols].to_vec()).collect()
}

#[test]
fn plain_loops_add_up_the_rounded_numbers() {
    let size @ [rows, inner, cols] = [5, 67, 50];
    let (a, b) = (normals(rows * inner, 1), normals(inner * cols, 2));
    let found = product(Kernel::PORTABLE, size, &a, &b, true);
    let exact = |x: f32| f64::from(widen(round(x)));
    for r in 0..rows {
        for c in 0..cols {
            let sum: f64 = (0..inner).map(|k| exact(a[r * inner + k]) * exact(b[k * cols + c])).sum();
            assert!((f64::from(found[r * cols + c]) - 1.0 - sum).abs() < 1e-5, "row {r}, column {c}");
        }
    }
}

#[test]
fn every_kernel_agrees_with_plain_loops_on_all_remainders() {
    let kernels = Kernel::available();
    println!("kernels: {:?}", kernels.iter().map(|kernel| kernel.name()).collect::<Vec<_>>());
    for rows in [1, 2, 3, 4, 5, 6, 7, 8, 9, 15, 16, 17, 33] {
        for inner in [1, 2, 3, 15, 16, 17, 31, 32, 33, 63, 64, 65] {
            for cols in [1, 2, 15, 16, 17, 31, 32, 33, 47, 48, 49, 63, 64, 65, 96, 97] {
                let size = [rows, inner, cols];
                let (a, b) = (normals(rows * inner, 3), normals(inner * cols, 4));
                for accumulate in [false, true] {
                    let want = product(Kernel::PORTABLE, size, &a, &b, accumulate);
                    for &kernel in &kernels {
                        let found = product(kernel, size, &a, &b, accumulate);
                        // AMX adds in another order.
                        if kernel.name() == "amx_bf16" {
                            let near = want.iter().zip(&found).all(|(x, y)| (x - y).abs() < 1e-4);
                            assert!(near, "{}, {size:?}, {accumulate}", kernel.name());
                        } else {
                            assert_eq!(
                                bits(&want),
                                bits(&found),
                                "{}, {size:?}, {accumulate}",
                                kernel.name()
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn kernels_agree_on_numbers_at_the_ends_of_the_range() {
    let special = [
        0.0,
        -0.0,
        1e-40,
        -1e-40,
        f32::MIN_POSITIVE,
        1e-20,
        -1e-25,
        3e38,
        -3e38,
        f32::INFINITY,
        1.0,
        1.0 + 1.0 / 256.0,
    ];
    let size = [special.len(), 2, special.len()];
    let a: Vec<f32> = special.iter().flat_map(|x| [*x, 1e-30]).collect();
    let b: Vec<f32> = special.iter().chain(&special).copied().collect();
    let want = product(Kernel::PORTABLE, size, &a, &b, true);
    for kernel in Kernel::available() {
        let found = product(kernel, size, &a, &b, true);
        for (want, found) in want.iter().zip(&found) {
            assert!(want == found || (want.is_nan() && found.is_nan()), "{}: {want} {found}", kernel.name());
        }
    }
}

#[test]
fn views_and_transposes_are_packed_like_their_copies() {
    for [rows, cols] in [[1, 1], [3, 5], [17, 31], [33, 50], [48, 64], [50, 129]] {
        let data = normals(rows * (cols + 7), 5);
        let view = Mat::new(&data, rows, cols + 7, cols + 7).columns(2, cols);
        let at = |r: usize, c: usize| data[r * (cols + 7) + 2 + c];
        let copy: Vec<f32> = (0..rows * cols).map(|k| at(k / cols, k % cols)).collect();
        let turned: Vec<f32> = (0..rows * cols).map(|k| at(k % rows, k / rows)).collect();
        let (copy, turned) = (Mat::new(&copy, rows, cols, cols), Mat::new(&turned, cols, rows, rows));
        for kernel in Kernel::available() {
            let name = kernel.name();
            let plain = Kernel::PORTABLE;
            assert_eq!(Rows::new(kernel, view), Rows::new(plain, copy), "{name}, {rows} x {cols}");
            assert_eq!(Rows::new(kernel, view.t()), Rows::new(plain, turned), "{name}, {rows} x {cols}");
            assert_eq!(Panels::new(kernel, view), Panels::new(plain, copy), "{name}, {rows} x {cols}");
            assert_eq!(Panels::new(kernel, view.t()), Panels::new(plain, turned), "{name}, {rows} x {cols}");
        }
    }
}

#[test]
fn an_operand_packed_again_keeps_nothing_of_the_larger_one_before() {
    let (large, small) = (vec![7.0; 40 * 70], normals(3 * 5, 6));
    let small = Mat::new(&small, 3, 5, 5);
    for kernel in Kernel::available() {
        let mut rows = Rows::new(kernel, Mat::new(&large, 40, 70, 70));
        let mut panels = Panels::new(kernel, Mat::new(&large, 40, 70, 70));
        rows.pack(kernel, small);
        panels.pack(kernel, small);
        assert_eq!((rows, panels), (Rows::new(kernel, small), Panels::new(kernel, small)));
    }
}

fn network(kind: NetworkKind) -> Network {
    let inputs = if kind == NetworkKind::Memory { 7 } else { 0 };
    let config = NetworkConfig {
        kind,
        hidden: vec![40, 24],
        lstm: LstmConfig { layers: 2, size: 24, inputs },
        ..NetworkConfig::default()
    };
    Network::new(30, 6, &config)
}

/// Three steps of a network over `n` environments whose observations are those of number `first` on.
fn outputs(net: &Network, weights: Weights<'_, f32>, first: usize, n: usize) -> Vec<Vec<f32>> {
    let mut state: State<f32> = net.initial_state(n);
    let mut work = StepWorkspace::default();
    let mut out = vec![0.0; net.output * n];
    for step in 0..3 {
        let input: Vec<f32> = (0..net.input * n)
            .map(|k| ((1 + k / n) * (first + k % n + 3) + step) as f32)
            .map(f32::sin)
            .collect();
        let x = Mat::new(&input, net.input, n, n);
        net.step(weights, x, &mut state, MatMut::new(&mut out, net.output, n, n), &mut work);
    }
    (0..n).map(|e| (0..net.output).map(|k| out[k * n + e]).collect()).collect()
}

#[test]
fn a_network_in_bfloat16_is_near_the_one_in_f32_and_no_environment_sees_its_neighbors() {
    for kind in [NetworkKind::Mlp, NetworkKind::Lstm, NetworkKind::Memory] {
        let net = network(kind);
        let mut params: Vec<f32> = net.initialize(&mut Rng::new(8, 0, 0));
        // A memory that weighs something.
        let mut rng = Rng::new(9, 0, 0);
        params.iter_mut().filter(|x| **x == 0.0).for_each(|x| *x = rng.uniform(-0.1, 0.1) as f32);
        let plain = outputs(&net, Weights::from(&params), 0, 70);
        for kernel in Kernel::available() {
            let packed = PackedWeights::new(kernel, &net, &params);
            let weights = Weights::new(&params, Some(&packed));
            let all = outputs(&net, weights, 0, 70);
            let differs = plain
                .iter()
                .flatten()
                .zip(all.iter().flatten())
                .fold(0.0_f32, |m, (a, b)| m.max((a - b).abs()));
            assert!(differs < 0.02 && differs > 1e-6, "{}, {kind:?}: {differs}", kernel.name());
            // The last layer is the `gemm` crate's, whose sums may depend on the number of columns in the last bit.
            let some = outputs(&net, weights, 50, 20);
            let far = |a: &[f32], b: &[f32]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-6);
            assert!(!all[50..].iter().zip(&some).any(|(a, b)| far(a, b)), "{}, {kind:?}", kernel.name());
        }
    }
}

#[test]
fn a_precision_is_f32_or_a_kernel_of_this_machine() {
    assert_eq!(Precision::F32.kernel(), None);
    let asked = Precision::Bf16.kernel().expect("runs everywhere");
    assert!(Kernel::available().contains(&asked));
    let chosen = Precision::Auto.kernel();
    assert_eq!(chosen, Precision::Auto.kernel(), "one measurement a process");
    match chosen {
        Some(kernel) => assert!(speeds().iter().any(|speed| speed.kernel == kernel && speed.gain > 1.0)),
        None => assert!(speeds().iter().all(|speed| speed.gain < 1.5)),
    }
}
