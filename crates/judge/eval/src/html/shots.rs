//! The section of a shooting evaluation: what a reader asks first comes first.

use std::fmt::Write;
use std::path::Path;

use paid_plot::escape;
use paid_plot::html::{Bar, bars, embedded, figure};
use serde::Deserialize;

use super::mouth::mouth;
use crate::EvalError;
use crate::knowledge;
use crate::shooting::{Grid, PAPER};
use crate::worst::{STRIPS, StripFile};

/// More rows make a page that no browser sorts at once.
const MOST_ROWS: usize = 4000;

/// What the page needs of a report's JSON.
#[derive(Debug, Deserialize)]
struct Shots {
    policy: Option<String>,
    command: Option<String>,
    engine: Engine,
    options: Options,
    total: Total,
    /// The shots from the paper's effective workspace, if there are others.
    effective: Option<Total>,
    trials: Vec<Trial>,
}

#[derive(Debug, Deserialize)]
struct Engine {
    name: String,
    ball_mass_kg: Option<f64>,
    knowledge: Option<Knowledge>,
}

#[derive(Debug, Deserialize)]
struct Knowledge {
    name: String,
}

#[derive(Debug, Deserialize)]
struct Options {
    grid: Grid,
    trials: usize,
    goal_distance_m: f64,
    rolling: Option<[f64; 2]>,
    goal_half_width_m: f64,
}

#[derive(Debug, Deserialize)]
struct Total {
    success: Share,
    accuracy: Option<f64>,
}

#[derive(Debug, Deserialize)]
struct Share {
    trials: usize,
    share: f64,
    low: f64,
    high: f64,
}

#[derive(Debug, Deserialize)]
struct Trial {
    place: [f64; 2],
    ball: [f64; 2],
    motion_name: String,
    contact: bool,
    foot_contact: bool,
    goal: bool,
    lateral_m: Option<f64>,
    plane_speed: Option<f64>,
    kick_time_s: Option<f64>,
    cosine: Option<f64>,
    fell: bool,
    fell_in_clip: bool,
}

impl Trial {
    fn end(&self) -> &'static str {
        match self {
            Self { fell_in_clip: true, .. } => "fell",
            Self { contact: false, .. } => "no contact",
            Self { goal: true, .. } => "goal",
            Self { lateral_m: Some(_), .. } => "wide",
            _ => "short",
        }
    }
}

/// The section of `STEM_shooting.json`, with the images and the table next to it; nothing if the file is another program's.
///
/// # Errors
/// If an image cannot be read.
pub(super) fn section(
    folder: &Path,
    stem: &str,
    json: &str,
    table: &str,
) -> Result<Option<String>, EvalError> {
    let Ok(shots) = serde_json::from_str::<Shots>(json) else { return Ok(None) };
    let Shots { engine, options, trials, .. } = &shots;
    // The paper's figures are of its effective workspace.
    let (total, from) = match shots.effective.as_ref().filter(|score| score.success.trials > 0) {
        Some(effective) => (effective, " from the effective workspace"),
        None => (&shots.total, ""),
    };
    let rolling = options.rolling.is_some();
    let ball = if rolling { "Rolling balls" } else { "Static balls" };
    let Share { trials: count, share, low, high } = total.success;
    let accuracy = total.accuracy.map_or_else(String::new, |a| format!("; accuracy {a:.3}"));
    let [paper, paper_accuracy] = PAPER[3].1[usize::from(rolling)];
    let mut out = format!("<h2 id=\"{stem}\">{ball}, {}</h2>\n", escape(&engine.name));
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "<p class=\"headline\"><b>{:.1}%</b> of {count} shots{from} are goals (95% interval {:.1} to {:.1}){accuracy}. The paper's policy: \
         {paper:.1}%, {paper_accuracy:.3}.</p>\n{}",
        100.0 * share,
        100.0 * low,
        100.0 * high,
        facts(&shots, table)
    );
    let mut rows =
        vec![Bar { name: "this policy".to_owned(), share, interval: Some([low, high]), own: true }];
    rows.extend(PAPER.iter().rev().map(|(name, figures)| Bar {
        name: format!("{name} (paper)"),
        share: 0.01 * figures[usize::from(rolling)][0],
        interval: None,
        own: false,
    }));
    let laterals: Vec<f64> = trials.iter().filter_map(|t| t.lateral_m).collect();
    let _ = writeln!(
        out,
        "<div class=\"row\">{}{}</div>",
        figure(
            &bars("goals of all shots", &rows),
            &format!("goals of all shots{from}, with their 95% interval; the paper states none")
        ),
        figure(
            &mouth(&laterals, trials.len() - laterals.len(), options.goal_half_width_m),
            "where balls crossed the goal's plane, seen by the robot; thick lines: the posts"
        )
    );
    out.push_str("<h3>By ball position</h3>\n<div class=\"row\">");
    let captions = [
        ("success", "goals [%]"),
        ("accuracy", "accuracy x 100"),
        ("paths", "paths from above; blue: the robot, green: balls that scored, red: other balls"),
    ];
    for (what, caption) in captions {
        if let Some(drawn) = embedded(&folder.join(format!("{stem}_{what}")))? {
            out.push_str(&figure(&drawn, caption));
        }
    }
    out.push_str("</div>\n");
    out.push_str(&strips(folder, &format!("{stem}_{STRIPS}"), "worst shots")?);
    out.push_str(&trial_table(trials));
    let _ = writeln!(
        out,
        "<details><summary>All figures as text</summary><pre>{}</pre></details>",
        escape(table)
    );
    if let Some(command) = &shots.command {
        let _ = writeln!(out, "<p class=\"soft\">Command:</p><pre>{}</pre>", escape(command));
    }
    Ok(Some(out))
}

/// What a reader has to know about the protocol, and the rest of it folded.
fn facts(shots: &Shots, table: &str) -> String {
    let Shots { engine, options, trials, .. } = shots;
    let grid = &options.grid;
    let given = match engine.knowledge.as_ref().map(|k| k.name.as_str()) {
        Some("truth") => "truth: exact positions of ball and goal",
        Some("perceived") => "perceived: ball and goal with the errors of simulated sensors",
        Some("eyes") => "eyes: ball and goal detected in rendered images, with a simulated LiDAR",
        _ => "not stated",
    };
    let mass = engine.ball_mass_kg.map_or_else(String::new, |mass| format!(", {mass} kg"));
    let ball = options
        .rolling
        .map_or_else(|| "at rest".to_owned(), |[low, high]| format!("rolling at {low} to {high} m/s"));
    let count = grid.places(grid.x).len() * grid.places(grid.y).len();
    let rows = [
        ("policy", shots.policy.clone().unwrap_or_else(|| "not stated".to_owned())),
        ("the policy is given", format!("{given} (the paper's: {})", knowledge::PAPER)),
        ("engine", engine.name.clone()),
        ("ball", ball + &mass),
        (
            "ball positions",
            format!(
                "{count}: {} to {} m ahead, {} to {} m to the left",
                grid.x[0], grid.x[1], grid.y[0], grid.y[1]
            ),
        ),
        (
            "shots",
            format!(
                "{}, {} per position, at a goal {} m wide and {} m away",
                trials.len(),
                options.trials,
                2.0 * options.goal_half_width_m,
                options.goal_distance_m
            ),
        ),
    ];
    let row = |(name, what): &(&str, String)| {
        format!("<tr><th scope=\"row\">{name}</th><td>{}</td></tr>", escape(what))
    };
    let rows: String = rows.iter().map(row).collect();
    format!("<table class=\"facts\">{rows}</table>\n{}", protocol(table.lines().next().unwrap_or_default()))
}

/// The line that states a whole protocol, folded.
pub(super) fn protocol(line: &str) -> String {
    format!("<details class=\"soft\"><summary>Whole protocol</summary><p>{}</p></details>\n", escape(line))
}

/// The film strips that a file of the folder lists; nothing without it.
pub(super) fn strips(folder: &Path, list: &str, what: &str) -> Result<String, EvalError> {
    let Ok(list) = std::fs::read_to_string(folder.join(list)) else {
        return Ok(String::new());
    };
    let files: Vec<StripFile> = serde_json::from_str(&list).unwrap_or_default();
    if files.is_empty() {
        return Ok(String::new());
    }
    let mut out = format!("<h3>The {} {what}</h3>\n<div class=\"strips\">", files.len());
    for file in files {
        let name = folder.join(file.picture.trim_end_matches(".png"));
        if let Some(drawn) = embedded(&name)? {
            out.push_str(&figure(&drawn, &file.words));
        }
    }
    out.push_str("</div>\n");
    Ok(out)
}

fn trial_table(trials: &[Trial]) -> String {
    let heads = [
        "what",
        "place x [m]",
        "place y [m]",
        "ball x [m]",
        "ball y [m]",
        "kick [s]",
        "speed [m/s]",
        "lateral [m]",
        "cosine",
        "foot first",
        "fell",
        "motion",
    ];
    let mut out = String::from("<details><summary>All shots</summary>");
    if trials.len() > MOST_ROWS {
        let _ = write!(
            out,
            "<p class=\"soft\">The first {MOST_ROWS} of {}; all are in the CSV file.</p>",
            trials.len()
        );
    }
    out.push_str("<div class=\"scroll\"><table class=\"sorts\"><thead><tr>");
    for head in heads {
        let _ = write!(out, "<th scope=\"col\"><button>{head}</button></th>");
    }
    out.push_str("</tr></thead><tbody>\n");
    let number = |value: Option<f64>, digits: usize| value.map_or(String::new(), |v| format!("{v:.digits$}"));
    let yes = |value: bool| if value { "yes" } else { "no" };
    for t in trials.iter().take(MOST_ROWS) {
        let class = if t.goal { "goal" } else { "miss" };
        let _ = writeln!(
            out,
            "<tr class=\"{class}\"><td>{}</td><td>{:.2}</td><td>{:.2}</td><td>{:.2}</td><td>{:.2}</td><td>{}</td><td>{}</td>\
             <td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            t.end(),
            t.place[0],
            t.place[1],
            t.ball[0],
            t.ball[1],
            number(t.kick_time_s, 2),
            number(t.plane_speed, 2),
            number(t.lateral_m, 2),
            number(t.cosine, 3),
            yes(t.foot_contact),
            yes(t.fell),
            escape(&t.motion_name)
        );
    }
    out.push_str("</tbody></table></div></details>\n");
    out
}
