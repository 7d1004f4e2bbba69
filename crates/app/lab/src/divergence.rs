//! The motion of robot and ball in two runs of one trial, and what diverged first.

use paid_eval::trace::Trace;
use paid_lanes::stats::quantile;
use paid_plot::{Table, number};
use serde::Serialize;

/// From these differences on a quantity counts as diverged: well above what a millisecond of contact timing does, well
/// below what decides a shot.
const JOINT_RAD: f64 = 0.15;
const BASE_M: f64 = 0.05;
const BASE_RAD: f64 = 0.15;
const BALL_M: f64 = 0.1;
const BALL_SPEED: f64 = 0.5;

/// The first quantity that went apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Divergence {
    /// Time since the start `[s]`.
    pub time_s: f64,
    /// `base position`, `base orientation`, `ball position`, `ball velocity` or `joint <name>`.
    pub quantity: String,
    /// The difference then `[m, rad or m/s]`.
    pub difference: f64,
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Angle between two orientations `[rad]`.
fn angle(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> f64 {
    let trace: f64 = a.as_flattened().iter().zip(b.as_flattened()).map(|(x, y)| x * y).sum();
    (0.5 * (trace - 1.0)).clamp(-1.0, 1.0).acos()
}

/// The first step at which `a` and `b` differ beyond the tolerances; of several quantities in that step the one that is
/// furthest beyond its tolerance. `None` while they stay together.
pub(crate) fn divergence(a: &Trace, b: &Trace, joints: &[String], control_dt_s: f64) -> Option<Divergence> {
    for (step, (a, b)) in a.rows.iter().zip(&b.rows).enumerate() {
        let mut found = vec![
            ("base position".to_owned(), distance(a.base, b.base), BASE_M),
            ("base orientation".to_owned(), angle(&a.rot, &b.rot), BASE_RAD),
            ("ball position".to_owned(), distance(a.ball, b.ball), BALL_M),
            ("ball velocity".to_owned(), distance(a.ball_vel, b.ball_vel), BALL_SPEED),
        ];
        for ((x, y), name) in a.joints.iter().zip(&b.joints).zip(joints) {
            found.push((format!("joint {name}"), f64::from((x - y).abs()), JOINT_RAD));
        }
        let excess = |f: &(String, f64, f64)| f.1 / f.2;
        let worst = found.into_iter().max_by(|x, y| excess(x).total_cmp(&excess(y)))?;
        if excess(&worst) > 1.0 {
            let (quantity, difference, _) = worst;
            return Some(Divergence { time_s: step as f64 * control_dt_s, quantity, difference });
        }
    }
    None
}

/// How often each quantity diverged first, and when.
pub(crate) fn first_table<'a>(firsts: impl Iterator<Item = Option<&'a Divergence>>) -> Table {
    let mut found: Vec<(&str, Vec<f64>)> = Vec::new();
    let mut together = 0;
    for first in firsts {
        let Some(first) = first else {
            together += 1;
            continue;
        };
        match found.iter_mut().find(|(name, _)| *name == first.quantity) {
            Some((_, times)) => times.push(first.time_s),
            None => found.push((&first.quantity, vec![first.time_s])),
        }
    }
    found.sort_by_key(|(name, times)| (usize::MAX - times.len(), *name));
    let mut table = Table::new(&["quantity", "", "trials", "median time [s]"]);
    for (name, times) in &mut found {
        let median = number(quantile(times, 0.5).unwrap_or(0.0), 2);
        table.row([(*name).to_owned(), String::new(), times.len().to_string(), median]);
    }
    table.row(["none".into(), String::new(), together.to_string(), "-".into()]);
    table
}

/// Time, quantity and difference as three fields of a CSV row, empty without a divergence.
pub(crate) fn csv_fields(first: Option<&Divergence>) -> String {
    first.map_or(",,".to_owned(), |f| format!("{:.2},{},{:.5}", f.time_s, f.quantity, f.difference))
}

#[cfg(test)]
mod tests {
    use paid_eval::trace::Row;

    use super::*;

    fn trace(steps: usize, row: impl Fn(usize, &mut Row)) -> Trace {
        let rows = (0..steps).map(|t| {
            let mut r = Row {
                base: [0.0; 3],
                rot: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                joints: vec![0.0; 2],
                ball: [0.0; 3],
                ball_vel: [0.0; 3],
            };
            row(t, &mut r);
            r
        });
        Trace { rows: rows.collect() }
    }

    fn joints() -> Vec<String> {
        vec!["hip".to_owned(), "knee".to_owned()]
    }

    #[test]
    fn the_first_quantity_beyond_its_tolerance_is_named_with_its_time() {
        let still = trace(50, |_, _| ());
        // The ball leaves at step 30, the knee was 0.2 rad off from step 20 on.
        let other = trace(50, |t, r| {
            r.joints[1] = if t >= 20 { 0.2 } else { 0.1 };
            r.ball[0] = if t >= 30 { 1.0 } else { 0.0 };
        });
        let first = divergence(&still, &other, &joints(), 0.02).expect("they differ");
        assert_eq!((first.quantity.as_str(), first.time_s), ("joint knee", 0.4));
        assert!((first.difference - 0.2).abs() < 1e-6);
    }

    #[test]
    fn of_two_quantities_in_one_step_the_worse_is_named() {
        let still = trace(3, |_, _| ());
        let (s, c) = 0.5_f64.sin_cos();
        let other = trace(3, |_, r| {
            r.rot = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
            r.ball_vel = [0.6, 0.0, 0.0];
        });
        let first = divergence(&still, &other, &joints(), 0.02).expect("they differ");
        assert_eq!(first.quantity, "base orientation");
        assert!((first.difference - 0.5).abs() < 1e-9, "half a radian about z");
    }

    #[test]
    fn small_differences_and_unequal_lengths_are_no_divergence() {
        let a = trace(10, |_, r| r.base[2] = 0.04);
        assert_eq!(divergence(&a, &trace(20, |_, _| ()), &joints(), 0.02), None);
    }
}
