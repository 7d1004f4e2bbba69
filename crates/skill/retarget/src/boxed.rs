//! A quadratic with bounds: the step of the inverse kinematics.

/// Minimizes `x H x / 2 - g x` with every `x` between its bounds; `H` symmetric and positive definite.
///
/// An active-set method: solve for the variables that are free, put those that leave their bounds onto them, let go of the one that
/// presses inwards hardest, until the conditions of Karush, Kuhn and Tucker hold.
#[derive(Clone, Debug)]
pub struct BoxedSystem {
    n: usize,
    /// `H`, row-major `[n, n]`; only `column <= row` is read.
    pub matrix: Vec<f64>,
    /// `g`.
    pub gradient: Vec<f64>,
    /// Solution.
    x: Vec<f64>,
    state: Vec<Bound>,
    free: Vec<usize>,
    factor: Vec<f64>,
    right: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Bound {
    Free,
    Low,
    High,
}

/// Rounds of the active set; each changes it. Real problems take one to four.
const ROUNDS: usize = 60;

impl BoxedSystem {
    /// A system of `n` variables, all zero.
    pub fn new(n: usize) -> Self {
        Self {
            n,
            matrix: vec![0.0; n * n],
            gradient: vec![0.0; n],
            x: vec![0.0; n],
            state: vec![Bound::Free; n],
            free: Vec::with_capacity(n),
            factor: vec![0.0; n * n],
            right: vec![0.0; n],
        }
    }

    /// Sets `H` and `g` to zero.
    pub fn clear(&mut self) {
        self.matrix.fill(0.0);
        self.gradient.fill(0.0);
    }

    /// The solution within `low <= x <= high`, with `damping` added to the diagonal.
    ///
    /// # Panics
    /// If the bounds are not `n` each.
    pub fn solve(&mut self, damping: f64, low: &[f64], high: &[f64]) -> &[f64] {
        assert!(low.len() == self.n && high.len() == self.n, "a bound a variable");
        self.state.fill(Bound::Free);
        for _ in 0..ROUNDS {
            for i in 0..self.n {
                match self.state[i] {
                    Bound::Free => {}
                    Bound::Low => self.x[i] = low[i],
                    Bound::High => self.x[i] = high[i],
                }
            }
            self.solve_free(damping);
            let mut left = false;
            for i in 0..self.n {
                if self.state[i] == Bound::Free {
                    if self.x[i] < low[i] {
                        (self.state[i], left) = (Bound::Low, true);
                    } else if self.x[i] > high[i] {
                        (self.state[i], left) = (Bound::High, true);
                    }
                }
            }
            if !left && !self.release(damping) {
                break;
            }
        }
        for i in 0..self.n {
            self.x[i] = self.x[i].max(low[i]).min(high[i]);
        }
        &self.x
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        if i >= j { self.matrix[i * self.n + j] } else { self.matrix[j * self.n + i] }
    }

    /// Frees the bound variable whose slope points inwards most; false if there is none.
    fn release(&mut self, damping: f64) -> bool {
        let mut worst = (1e-9, None);
        for i in 0..self.n {
            if self.state[i] == Bound::Free {
                continue;
            }
            let product: f64 = (0..self.n).map(|j| self.at(i, j) * self.x[j]).sum();
            let slope = product + damping * self.x[i] - self.gradient[i];
            let inwards = if self.state[i] == Bound::Low { -slope } else { slope };
            if inwards > worst.0 {
                worst = (inwards, Some(i));
            }
        }
        if let Some(i) = worst.1 {
            self.state[i] = Bound::Free;
        }
        worst.1.is_some()
    }

    /// Cholesky factorization of the free part and substitution.
    fn solve_free(&mut self, damping: f64) {
        self.free.clear();
        self.free.extend((0..self.n).filter(|&i| self.state[i] == Bound::Free));
        let m = self.free.len();
        for (a, &i) in self.free.iter().enumerate() {
            let row = &self.matrix[i * self.n..];
            for (b, &j) in self.free[..=a].iter().enumerate() {
                self.factor[a * m + b] = row[j];
            }
            self.factor[a * m + a] += damping;
            self.right[a] = self.gradient[i];
        }
        if m < self.n {
            for j in (0..self.n).filter(|&j| self.state[j] != Bound::Free) {
                for (a, &i) in self.free.iter().enumerate() {
                    self.right[a] -= self.at(i, j) * self.x[j];
                }
            }
        }
        let (l, y) = (&mut self.factor, &mut self.right);
        for i in 0..m {
            let (above, row) = l.split_at_mut(i * m);
            let row = &mut row[..m];
            for j in 0..i {
                let upper = &above[j * m..j * m + j + 1];
                row[j] = (row[j] - dot(&row[..j], &upper[..j])) / upper[j];
            }
            row[i] = (row[i] - dot(&row[..i], &row[..i])).max(1e-12).sqrt();
            y[i] = (y[i] - dot(&row[..i], &y[..i])) / row[i];
        }
        for i in (0..m).rev() {
            y[i] /= l[i * m + i];
            let value = y[i];
            for (y, l) in y[..i].iter_mut().zip(&l[i * m..i * m + i]) {
                *y -= l * value;
            }
        }
        for (a, &i) in self.free.iter().enumerate() {
            self.x[i] = y[a];
        }
    }
}

/// In four sums, which the processor adds side by side.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a4.zip(b4) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_solution_meets_the_optimality_conditions(
            numbers in proptest::collection::vec(-1.0..1.0_f64, 7 * 7 + 7 * 3),
        ) {
            let n = 7;
            let (a, rest) = numbers.split_at(n * n);
            let mut system = BoxedSystem::new(n);
            for i in 0..n {
                for j in 0..=i {
                    system.matrix[i * n + j] = (0..n).map(|k| a[k * n + i] * a[k * n + j]).sum();
                }
                system.gradient[i] = 3.0 * rest[i];
            }
            let low: Vec<f64> = (0..n).map(|i| -0.3 - 0.3 * rest[n + i].abs()).collect();
            let high: Vec<f64> = (0..n).map(|i| 0.3 * rest[2 * n + i].abs()).collect();
            let x = system.solve(1e-2, &low, &high).to_vec();
            for i in 0..n {
                let product: f64 = (0..n).map(|j| system.at(i, j) * x[j]).sum();
                let slope = product + 1e-2 * x[i] - system.gradient[i];
                prop_assert!(x[i] >= low[i] && x[i] <= high[i]);
                if x[i] > low[i] { prop_assert!(slope < 1e-7, "{slope}"); }
                if x[i] < high[i] { prop_assert!(slope > -1e-7, "{slope}"); }
            }
        }
    }
}
