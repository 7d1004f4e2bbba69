//! The result of a comparison with the clips.

use paid_plot::{Table, number};
use serde::{Deserialize, Serialize};

use super::Swing;
use crate::engine::EngineFacts;

/// How a set of kicks compares with the clips: means over the kicks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Likeness {
    /// Whose kicks.
    pub name: String,
    /// Clips or shots.
    pub takes: usize,
    /// Those in which the ball was met; `None` for clips, which have no ball.
    pub kicks: Option<usize>,
    /// Time-averaged peak link jerk `[m/frame^3]`.
    pub jerk: Option<f64>,
    /// Its distance from the clips' mean: the paper's AUJ.
    pub auj: Option<f64>,
    /// RMS difference of the joint angles to the nearest frame of any clip, mean over the frames `[deg]`.
    pub joint_distance_deg: Option<f64>,
    /// Distance of the kicking foot's path around the strike to the nearest clip's `[m]`.
    pub foot_path_m: Option<f64>,
    /// How the kicks swing.
    pub swing: Option<Swing>,
}

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LikenessReport {
    /// Who simulated.
    pub engine: EngineFacts,
    /// The clips, then the policy.
    pub rows: Vec<Likeness>,
}

/// Rows as text.
pub fn table(rows: &[Likeness]) -> Table {
    let mut table = Table::new(&[
        "kicks of",
        "met the ball",
        "jerk [mm/frame^3]",
        "AUJ [m/frame^3]",
        "joints [deg]",
        "foot path [cm]",
        "back-swing [cm]",
        "hand swing [cm]",
        "hip turn [deg]",
    ]);
    for row in rows {
        let cell = |value: Option<f64>, factor: f64, digits: usize| {
            value.map_or("-".to_owned(), |value| number(factor * value, digits))
        };
        let swing = row.swing.as_ref();
        table.row([
            row.name.clone(),
            row.kicks.map_or("-".to_owned(), |kicks| format!("{kicks} of {}", row.takes)),
            cell(row.jerk, 1e3, 1),
            cell(row.auj, 1.0, 4),
            cell(row.joint_distance_deg, 1.0, 1),
            cell(row.foot_path_m, 100.0, 1),
            cell(swing.map(|s| s.back_swing_m), 100.0, 1),
            cell(swing.map(|s| s.hand_swing_m), 100.0, 1),
            cell(swing.map(|s| s.hip_turn_deg), 1.0, 1),
        ]);
    }
    table
}

impl LikenessReport {
    /// The rows as text.
    pub fn table(&self) -> String {
        let shots = self.rows.last().map_or(0, |row| row.takes);
        format!(
            "{}; {shots} shots at static balls over the effective workspace{}. The clips: each compared with the others\n\n{}",
            self.engine.name,
            self.engine.knowledge_text(),
            table(&self.rows)
        )
    }
}
