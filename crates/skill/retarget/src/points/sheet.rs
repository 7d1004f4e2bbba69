//! The description of a skeleton of points.

use core::fmt;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::RetargetError;

/// The parts that are needed, and those that help.
const NEEDED: [&str; 14] = [
    "left_hip",
    "left_knee",
    "left_ankle",
    "left_toe",
    "left_shoulder",
    "left_elbow",
    "left_wrist",
    "right_hip",
    "right_knee",
    "right_ankle",
    "right_toe",
    "right_shoulder",
    "right_elbow",
    "right_wrist",
];
const HELPFUL: [&str; 4] = ["hips", "neck", "left_heel", "right_heel"];

/// An axis that points up, or down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Up {
    /// 1 or 2.
    pub axis: usize,
    pub down: bool,
}

impl fmt::Display for Up {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = if self.axis == 1 { "y" } else { "z" };
        if self.down { write!(f, "-{name}") } else { f.write_str(name) }
    }
}

/// Which points are which part of a human, and what the numbers mean.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSkeleton {
    path: PathBuf,
    pub(super) up: Option<Up>,
    pub(super) unit_m: Option<f64>,
    pub(super) fps: Option<f64>,
    pub(super) left_handed: bool,
    joints: BTreeMap<String, Names>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
enum Names {
    One(String),
    Middle(Vec<String>),
}

impl Names {
    fn list(&self) -> &[String] {
        match self {
            Self::One(name) => core::slice::from_ref(name),
            Self::Middle(names) => names,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sheet {
    up: Option<String>,
    unit_m: Option<f64>,
    fps: Option<f64>,
    #[serde(default)]
    left_handed: bool,
    joints: BTreeMap<String, Names>,
}

/// Reads the description of a skeleton; `path` names it in messages.
///
/// `[joints]` gives each part the name of its point, or a list of points whose middle it is: for `left` and `right` `_hip`, `_knee`,
/// `_ankle`, `_toe`, `_shoulder`, `_elbow` and `_wrist`; optionally `hips` (else the middle of the hips), `neck` (else the middle of the
/// shoulders) and `_heel` (else the ankle). `up` is `y`, `z`, `-y` or `-z`, `unit_m` the meters of a unit of length, `fps` the frame rate,
/// `left_handed = true` says that the axes are (as Unity's are), which mirrors the points;
/// without them the axis and the unit are recognized, and the points' file states the rate.
///
/// # Errors
/// What is no TOML, an unknown key, a missing part.
///
/// ```
/// let text = "up = 'y'\nunit_m = 0.01\n[joints]\nleft_hip = 'LHip'\n";
/// let error = paid_retarget::parse_skeleton(text, "body.toml".as_ref()).expect_err("a person has more");
/// assert!(error.to_string().starts_with("body.toml: joints: expected 'left_knee'"));
/// ```
pub fn parse_skeleton(text: &str, path: &Path) -> Result<PointSkeleton, RetargetError> {
    let refuse = |place: &str, expected: &str, found: String| RetargetError::Points {
        path: path.to_owned(),
        place: place.to_owned(),
        expected: expected.to_owned(),
        found,
    };
    let sheet: Sheet = toml::from_str(text).map_err(|e| {
        refuse("TOML", "the description of a skeleton", e.to_string().trim_end().replace('\n', " "))
    })?;
    let up = match sheet.up.as_deref() {
        None => None,
        Some("y") => Some(Up { axis: 1, down: false }),
        Some("z") => Some(Up { axis: 2, down: false }),
        Some("-y") => Some(Up { axis: 1, down: true }),
        Some("-z") => Some(Up { axis: 2, down: true }),
        Some(other) => return Err(refuse("up", "'y', 'z', '-y' or '-z'", format!("'{other}'"))),
    };
    for (key, value, range) in [("unit_m", sheet.unit_m, 1e-6..=1e3), ("fps", sheet.fps, 1.0..=2000.0)] {
        if let Some(value) = value.filter(|value| !range.contains(value)) {
            let expected = format!("{} to {}", range.start(), range.end());
            return Err(refuse(key, &expected, value.to_string()));
        }
    }
    let known = |key: &str| NEEDED.contains(&key) || HELPFUL.contains(&key);
    let have = || sheet.joints.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    if let Some(odd) = sheet.joints.keys().find(|key| !known(key)) {
        return Err(refuse("joints", "the name of a part, such as 'left_knee'", format!("'{odd}'")));
    }
    if let Some(missing) = NEEDED.iter().find(|part| !sheet.joints.contains_key(**part)) {
        return Err(refuse("joints", &format!("'{missing}', a limb that the robot needs"), have()));
    }
    if let Some((part, _)) = sheet.joints.iter().find(|(_, names)| names.list().is_empty()) {
        return Err(refuse("joints", &format!("a point for '{part}'"), "an empty list".to_owned()));
    }
    let Sheet { unit_m, fps, left_handed, joints, .. } = sheet;
    Ok(PointSkeleton { path: path.to_owned(), up, unit_m, fps, left_handed, joints })
}

/// Positions of each part's points in a file.
pub(super) type Indices = BTreeMap<String, Vec<usize>>;

impl PointSkeleton {
    /// Where the parts' points are among `names`.
    ///
    /// # Errors
    /// The first point that is not there.
    pub(super) fn indices(&self, points: &Path, names: &[String]) -> Result<Indices, RetargetError> {
        let find = |part: &str, wanted: &String| {
            names.iter().position(|name| name == wanted).ok_or_else(|| RetargetError::Points {
                path: points.to_owned(),
                place: "joint_names".to_owned(),
                expected: format!("'{wanted}' ({part} of the skeleton)"),
                found: names.join(", "),
            })
        };
        let part = |(part, wanted): (&String, &Names)| {
            let indices: Result<Vec<usize>, _> = wanted.list().iter().map(|name| find(part, name)).collect();
            indices.map(|indices| (part.clone(), indices))
        };
        self.joints.iter().map(part).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bad_description_is_refused_with_its_key() {
        let refusal = |text: &str| parse_skeleton(text, Path::new("s.toml")).expect_err("bad").to_string();
        for (text, expected) in [
            (
                "[joints]\nup = 'y'\n",
                "s.toml: joints: expected the name of a part, such as 'left_knee', found 'up'",
            ),
            ("up = 'x'\n[joints]\n", "s.toml: up: expected 'y', 'z', '-y' or '-z', found 'x'"),
            ("fps = 0\n[joints]\n", "s.toml: fps: expected 1 to 2000, found 0"),
            ("unit = 1\n[joints]\n", "s.toml: TOML: expected the description of a skeleton, found"),
        ] {
            assert!(refusal(text).starts_with(expected), "{}", refusal(text));
        }
    }
}
