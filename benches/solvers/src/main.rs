//! Times one linear step of `paid motion clean`: its own banded Cholesky factorization beside solver crates, on the same system.
//!
//! The system is as a clip of 6 s has it: 300 frames of 35 unknowns (base and joints), and each frame is joined to the two before it. Its
//! values are random and positive definite. Each solver gets it in the form that it takes; making that form is not counted. Prints
//! milliseconds a solution (the least of ten) and how far it is from the known one. One thread.
//!
//! ```text
//! cargo run --release --manifest-path benches/solvers/Cargo.toml
//! ```

#[path = "../../../crates/skill/motion/src/clean/rows.rs"]
#[allow(dead_code)]
mod rows;

use std::hint::black_box;
use std::time::Instant;

use clarabel::algebra::CscMatrix as ClarabelMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT};
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Col, Par, Side};
use nalgebra::DMatrix;
use nalgebra_sparse::factorization::CscCholesky;
use nalgebra_sparse::{CooMatrix, CscMatrix};
use rows::Band;

const FRAMES: usize = 300;
const UNKNOWNS: usize = 35;
const SIZE: usize = FRAMES * UNKNOWNS;
const WIDTH: usize = 3 * UNKNOWNS;
const TRIES: usize = 10;

/// Numbers between -1 and 1 that look random and are the same in each run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Row, column and value of the lower triangle.
fn system() -> Vec<(usize, usize, f64)> {
    let mut numbers = Numbers(1);
    let mut lower = Vec::new();
    for i in 0..SIZE {
        let first = (i / UNKNOWNS).saturating_sub(2) * UNKNOWNS;
        for j in first..i {
            lower.push((i, j, numbers.next()));
        }
        lower.push((i, i, 2.0 * WIDTH as f64)); // more than the sum of its row
    }
    lower
}

/// Where the system's solution is.
fn solution(i: usize) -> f64 {
    (i as f64).sin()
}

fn report(name: &str, mut solve: impl FnMut() -> Vec<f64>) {
    let mut least = f64::INFINITY;
    let mut wrong: f64 = 0.0;
    for _ in 0..TRIES {
        let start = Instant::now();
        let x = black_box(solve());
        least = least.min(start.elapsed().as_secs_f64());
        wrong = x.iter().enumerate().fold(wrong, |worst, (i, x)| worst.max((x - solution(i)).abs()));
    }
    println!("{name:<44} {:8.1} ms   wrong by {wrong:.0e}", 1e3 * least);
}

fn main() {
    let lower = system();
    let mut right = vec![0.0; SIZE];
    for &(i, j, value) in &lower {
        right[i] += value * solution(j);
        if i != j {
            right[j] += value * solution(i);
        }
    }
    println!("{SIZE} unknowns, {} numbers in the lower triangle, least of {TRIES}", lower.len());

    let mut band = Band::new(SIZE, WIDTH);
    let fill = |band: &mut Band| {
        band.clear();
        for &(i, j, value) in &lower {
            band.lower[i * WIDTH + WIDTH - 1 + j - i] = value;
        }
        band.right.copy_from_slice(&right);
    };
    let mut least = f64::INFINITY;
    let mut wrong: f64 = 0.0;
    for _ in 0..TRIES {
        fill(&mut band); // the factorization uses the matrix up
        let start = Instant::now();
        let x = black_box(band.solve().expect("positive definite"));
        least = least.min(start.elapsed().as_secs_f64());
        wrong = x.iter().enumerate().fold(wrong, |worst, (i, x)| worst.max((x - solution(i)).abs()));
    }
    println!("{:<44} {:8.1} ms   wrong by {wrong:.0e}", "paid motion clean: a band", 1e3 * least);

    faer::set_global_parallelism(Par::Seq);
    let triplets: Vec<_> = lower.iter().map(|&(i, j, value)| Triplet::new(i, j, value)).collect();
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(SIZE, SIZE, &triplets).expect("in range");
    let column = Col::from_fn(SIZE, |i| right[i]);
    let symbolic = SymbolicLlt::try_new(matrix.symbolic(), Side::Lower).expect("fits");
    report("faer: sparse LLT, structure known", || {
        let llt = Llt::try_new_with_symbolic(symbolic.clone(), matrix.as_ref(), Side::Lower);
        let x = llt.expect("positive definite").solve(&column);
        (0..SIZE).map(|i| x[i]).collect()
    });

    let mut coo = CooMatrix::new(SIZE, SIZE);
    for &(i, j, value) in &lower {
        coo.push(i, j, value);
        if i != j {
            coo.push(j, i, value);
        }
    }
    let full = CscMatrix::from(&coo);
    let b = DMatrix::from_column_slice(SIZE, 1, &right);
    let mut cholesky = CscCholesky::factor(&full).expect("positive definite");
    report("nalgebra-sparse: CscCholesky, structure known", || {
        cholesky.refactor(full.values()).expect("positive definite");
        cholesky.solve(&b).column(0).iter().copied().collect()
    });

    // A quadratic program without conditions: half of x' P x less b' x. It wants the upper triangle.
    let (rows, columns): (Vec<_>, Vec<_>) = lower.iter().map(|&(i, j, _)| (j, i)).unzip();
    let values = lower.iter().map(|&(_, _, value)| value).collect();
    let p = ClarabelMatrix::new_from_triplets(SIZE, SIZE, rows, columns, values);
    let q: Vec<f64> = right.iter().map(|b| -b).collect();
    let a = ClarabelMatrix::zeros((0, SIZE));
    report("clarabel: quadratic program, with its set-up", || {
        let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
        let cones = [NonnegativeConeT(0)];
        let mut solver = DefaultSolver::new(&p, &q, &a, &[], &cones, settings).expect("fits");
        solver.solve();
        solver.solution.x.clone()
    });
}
