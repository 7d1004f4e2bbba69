//! The outcome of one trial, and of many together.

use paid_lanes::stats::mean;
use paid_plot::{Table, number};
use serde::{Deserialize, Serialize};

use super::Trial;
use crate::metrics::statistics::Share;

/// The outcome of a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The plan.
    #[serde(flatten)]
    pub trial: Trial,
    /// Name of the motion.
    pub motion_name: String,
    /// True if the robot met the ball (more than the preset's contact force).
    pub contact: bool,
    /// True if the labeled foot was the nearer one at first contact.
    pub correct_foot: bool,
    /// Body that met the ball first.
    pub body: Option<String>,
    /// True if that was a foot, whichever.
    pub foot_contact: bool,
    /// The foot nearer to the ball at first contact: 0 left, 1 right.
    pub foot: Option<usize>,
    /// Time of first contact `[s]`.
    pub kick_time_s: Option<f64>,
    /// Speed of the kicking foot just after first contact `[m/s]`.
    pub foot_speed: Option<f64>,
    /// True if the kicked ball's center crossed the goal plane within the mouth.
    pub goal: bool,
    /// Where it crossed the plane, left positive `[m]`.
    pub lateral_m: Option<f64>,
    /// When `[s]`.
    pub goal_time_s: Option<f64>,
    /// Horizontal ball speed there `[m/s]`.
    pub plane_speed: Option<f64>,
    /// Cosine between the ball's horizontal outgoing velocity and the direction from the ball at impact to the goal's center.
    pub cosine: Option<f64>,
    /// Horizontal outgoing ball speed, 5 control steps after first contact `[m/s]`.
    pub ball_speed: Option<f64>,
    /// Vertical outgoing ball velocity `[m/s]`.
    pub ball_rise: Option<f64>,
    /// Largest horizontal ball speed after first contact `[m/s]`.
    pub peak_ball_speed: f64,
    /// True if the robot fell within two seconds after first contact.
    pub fell_after_kick: bool,
    /// True if it fell at any time of the trial, which continues until the shot is decided and the clip has ended.
    pub fell: bool,
    /// True if it fell before the clip's end.
    pub fell_in_clip: bool,
    /// True if it fell within the options' `after_s` of the first contact; `None` if it was not watched that long.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fell_within: Option<bool>,
    /// Share of joints and control steps whose torque was at its limit, until the shot was decided.
    pub torque_saturation: f64,
    /// Control steps of the trial.
    pub steps: u32,
    /// Base and ball after every step until the shot was decided: past the goal plane (negative in front) and left of the goal's center `[m]`; not in the JSON.
    #[serde(skip)]
    pub path: Vec<[[f64; 2]; 2]>,
}

impl Outcome {
    /// Where the ball crossed the goal plane, positive on the side of the kicking foot `[m]`.
    fn outward_m(&self) -> Option<f64> {
        let lateral = self.lateral_m?;
        Some(if self.foot? == 0 { lateral } else { -lateral })
    }
}

/// Means and shares of some trials.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellScore {
    /// Grid place `[m]`; `None` for all trials together.
    pub place: Option<[f64; 2]>,
    /// Goals of all trials.
    pub success: Share,
    /// Goals of the trials with a contact (the paper's number of kicks).
    pub success_of_kicks: Share,
    /// Trials with a contact.
    pub contact: Share,
    /// Labeled foot first, of the trials with a contact.
    pub correct_foot: Share,
    /// A foot met the ball first, of the trials with a contact.
    pub foot_contact: Share,
    /// The ball passed the goal plane within 0.5 m of the goal's center, of all trials.
    pub within_half_meter: Share,
    /// Within 1 m.
    pub within_one_meter: Share,
    /// Falls within two seconds after the contact, of all trials.
    pub falls: Share,
    /// Falls at any time of the trials.
    pub falls_ever: Share,
    /// Falls before the clip's end, of all trials.
    pub falls_in_clip: Share,
    /// Falls within the options' `after_s` of the contact, of all trials; `None` if they were not watched that long.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub falls_within: Option<Share>,
    /// Mean cosine over the contacts.
    pub accuracy: Option<f64>,
    /// Mean outgoing ball speed over the contacts `[m/s]`.
    pub ball_speed: Option<f64>,
    /// Mean over the contacts of the largest ball speed `[m/s]`.
    pub peak_ball_speed: Option<f64>,
    /// Mean foot speed just after the contact `[m/s]`.
    pub foot_speed: Option<f64>,
    /// Mean distance from the goal's center at the goal plane, of the balls that reached it `[m]`.
    pub miss_m: Option<f64>,
    /// Mean of where they crossed it, positive on the side of the kicking foot `[m]`: an aim that is off in the same way for both feet.
    pub outward_m: Option<f64>,
    /// Mean ball speed there `[m/s]`.
    pub plane_speed: Option<f64>,
    /// Mean share of torques at their limit.
    pub torque_saturation: Option<f64>,
}

impl CellScore {
    /// Of the outcomes at a place; `None`: of a whole grid.
    pub fn of(place: Option<[f64; 2]>, outcomes: &[&Outcome]) -> Self {
        let kicks = || outcomes.iter().filter(|o| o.contact);
        let all = || outcomes.iter();
        Self {
            place,
            success: Share::of(all().map(|o| o.goal)),
            success_of_kicks: Share::of(kicks().map(|o| o.goal)),
            contact: Share::of(all().map(|o| o.contact)),
            correct_foot: Share::of(kicks().map(|o| o.correct_foot)),
            foot_contact: Share::of(kicks().map(|o| o.foot_contact)),
            within_half_meter: Share::of(all().map(|o| o.lateral_m.is_some_and(|l| l.abs() <= 0.5))),
            within_one_meter: Share::of(all().map(|o| o.lateral_m.is_some_and(|l| l.abs() <= 1.0))),
            falls: Share::of(all().map(|o| o.fell_after_kick)),
            falls_ever: Share::of(all().map(|o| o.fell)),
            falls_in_clip: Share::of(all().map(|o| o.fell_in_clip)),
            falls_within: outcomes
                .iter()
                .any(|o| o.fell_within.is_some())
                .then(|| Share::of(all().map(|o| o.fell_within == Some(true)))),
            accuracy: mean(kicks().filter_map(|o| o.cosine)),
            ball_speed: mean(kicks().filter_map(|o| o.ball_speed)),
            peak_ball_speed: mean(kicks().map(|o| o.peak_ball_speed)),
            foot_speed: mean(kicks().filter_map(|o| o.foot_speed)),
            miss_m: mean(all().filter_map(|o| o.lateral_m.map(f64::abs))),
            outward_m: mean(all().filter_map(|o| o.outward_m())),
            plane_speed: mean(all().filter_map(|o| o.plane_speed)),
            torque_saturation: mean(all().map(|o| o.torque_saturation)),
        }
    }
}

/// Shares and means as a table; `after_s` is the options'.
pub fn totals(score: &CellScore, after_s: Option<f64>) -> Table {
    let mut table = Table::new(&["figure", "", "value", "95% low", "high", "n"]);
    let within = format!("falls within {} s of the kick", after_s.unwrap_or(0.0));
    let mut shares = vec![
        ("success", score.success),
        ("success of kicks", score.success_of_kicks),
        ("contact", score.contact),
        ("correct foot of kicks", score.correct_foot),
        ("a foot first, of kicks", score.foot_contact),
        ("within 0.5 m of the goal's center", score.within_half_meter),
        ("within 1 m", score.within_one_meter),
        ("falls within 2 s of the kick", score.falls),
        ("falls at any time", score.falls_ever),
        ("falls before the clip's end", score.falls_in_clip),
    ];
    shares.extend(score.falls_within.map(|s| (within.as_str(), s)));
    for (name, s) in shares {
        let p = |v: f64| format!("{:.1}%", 100.0 * v);
        table.row([name.into(), String::new(), p(s.share), p(s.low), p(s.high), s.trials.to_string()]);
    }
    for (name, value) in [
        ("accuracy (cosine)", score.accuracy),
        ("ball speed [m/s]", score.ball_speed),
        ("peak ball speed [m/s]", score.peak_ball_speed),
        ("ball speed at the goal plane [m/s]", score.plane_speed),
        ("distance from the goal's center there [m]", score.miss_m),
        ("offset there to the kicking foot's side [m]", score.outward_m),
        ("foot speed at contact [m/s]", score.foot_speed),
        ("torques at their limit [share]", score.torque_saturation),
    ] {
        let value = value.map_or("-".to_owned(), |v| number(v, 3));
        table.row([name.into(), String::new(), value, String::new(), String::new(), String::new()]);
    }
    table
}
