//! Surface files: a ball on a ground, ready for a task preset.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use paid_physics::{BallParams, Material};
use serde::{Deserialize, Serialize};

use crate::SysidError;
use crate::identify::Identification;

/// The content of a surface file.
///
/// The table `ball_params` has the form of the task preset's: it replaces it as a whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// Name of the surface.
    pub name: String,
    /// The ball as it behaves on it.
    pub ball_params: BallParams,
    /// The ground that the ball's values were found with; on another ground they mean something else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground: Option<Material>,
    /// What the measurements say about each value.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub evidence: BTreeMap<String, Evidence>,
}

/// What the measurements say about a value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Evidence {
    /// `sharp`, `rough` or `unseen`.
    pub verdict: String,
    /// The value may be off by this.
    pub half_width: f64,
    /// Values that fit as well, the others held.
    pub fits: [f64; 2],
}

/// The shipped surfaces: name and file.
const SHIPPED: [(&str, &str); 2] = [
    ("hard", include_str!("../../../../configs/surfaces/hard.toml")),
    ("grass", include_str!("../../../../configs/surfaces/grass.toml")),
];

impl Surface {
    /// A shipped surface by name (`hard` or `grass`, the paper's two), or one from a `.toml` file.
    ///
    /// # Errors
    /// As [`Surface::read`], or if there is no surface of that name.
    pub fn load(name: &str) -> Result<Self, SysidError> {
        if Path::new(name).extension().is_some_and(|e| e == "toml") {
            return Self::read(Path::new(name));
        }
        let found = SHIPPED.iter().find(|(shipped, _)| *shipped == name);
        let (_, text) = found.ok_or_else(|| {
            SysidError::option("surface", "hard, grass or the path of a .toml file", format!("'{name}'"))
        })?;
        Self::parse(Path::new(name), text)
    }

    /// The surface of an identification.
    pub fn of(name: &str, found: &Identification) -> Self {
        let evidence = found.confidence.estimates.iter().map(|e| {
            let half_width = round(e.half_width());
            (
                e.name.to_owned(),
                Evidence { verdict: e.verdict.name().to_owned(), half_width, fits: e.flat.map(round) },
            )
        });
        let mut ball = found.ball;
        ball.material.static_friction = round(ball.material.static_friction);
        ball.material.dynamic_friction = round(ball.material.dynamic_friction);
        ball.material.restitution = round(ball.material.restitution);
        ball.linear_damping = round(ball.linear_damping);
        ball.angular_damping = round(ball.angular_damping);
        Self {
            name: name.to_owned(),
            ball_params: ball,
            ground: Some(found.ground),
            evidence: evidence.collect(),
        }
    }

    /// Reads a surface file.
    ///
    /// # Errors
    /// File, place, expected, found.
    pub fn read(path: &Path) -> Result<Self, SysidError> {
        let text =
            fs::read_to_string(path).map_err(|source| SysidError::Read { path: path.to_owned(), source })?;
        Self::parse(path, &text)
    }

    /// The surface in the text of a file; `path` is for complaints.
    ///
    /// # Errors
    /// As [`Surface::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, SysidError> {
        let bad = |message: String| SysidError::Surface { path: path.to_owned(), message };
        let surface: Self = toml::from_str(text).map_err(|e| bad(e.to_string().trim_end().to_owned()))?;
        let (ball, m) = (&surface.ball_params, &surface.ball_params.material);
        for (name, value, expected, fits) in [
            ("mass_kg", ball.mass_kg, "a positive number", ball.mass_kg > 0.0),
            ("radius_m", ball.radius_m, "a positive number", ball.radius_m > 0.0),
            ("inertia_factor", ball.inertia_factor, "a positive number", ball.inertia_factor > 0.0),
            ("static_friction", m.static_friction, "at least 0", m.static_friction >= 0.0),
            ("dynamic_friction", m.dynamic_friction, "at least 0", m.dynamic_friction >= 0.0),
            ("restitution", m.restitution, "0 to 1", (0.0..=1.0).contains(&m.restitution)),
            ("linear_damping", ball.linear_damping, "at least 0", ball.linear_damping >= 0.0),
            ("angular_damping", ball.angular_damping, "at least 0", ball.angular_damping >= 0.0),
        ] {
            if !(fits && value.is_finite()) {
                return Err(bad(format!("ball_params, {name}: expected {expected}, found {value}")));
            }
        }
        Ok(surface)
    }

    /// The file's text, `comments` first.
    ///
    /// # Errors
    /// If a number cannot be written.
    pub fn to_toml(&self, comments: &[String]) -> Result<String, SysidError> {
        let body = toml::to_string(self)
            .map_err(|e| SysidError::option("surface", "numbers that TOML can hold", e.to_string()))?;
        let head: String = comments.iter().map(|c| format!("# {c}\n")).collect();
        Ok(format!("{head}{body}"))
    }
}

/// Six decimals: far below what a camera can resolve.
fn round(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_two_surfaces_are_shipped() {
        for (name, values) in
            [("hard", [0.77, 0.07, 0.75, 0.01, 4.28]), ("grass", [0.98, 0.15, 0.71, 0.01, 4.95])]
        {
            let surface = Surface::load(name).expect("shipped");
            assert_eq!(surface.name, name);
            assert_eq!(crate::options::parameters_of(&surface.ball_params), values);
        }
        let error = Surface::load("mud").expect_err("not shipped").to_string();
        assert!(error.contains("hard, grass") && error.contains("'mud'"), "{error}");
    }

    #[test]
    fn what_is_written_reads_back() {
        let surface = Surface {
            name: "yard".into(),
            ball_params: BallParams::default(),
            ground: Some(Material { static_friction: 1.0, dynamic_friction: 1.0, restitution: 0.8 }),
            evidence: [(
                "restitution".to_owned(),
                Evidence { verdict: "sharp".into(), half_width: 0.01, fits: [0.7, 0.8] },
            )]
            .into(),
        };
        let text = surface.to_toml(&["how it was made".into()]).expect("writes");
        assert!(text.starts_with("# how it was made\n"));
        assert_eq!(Surface::parse(Path::new("yard.toml"), &text).expect("reads"), surface);
    }

    #[test]
    fn a_wrong_surface_is_refused_with_its_place() {
        let text = Surface {
            name: "yard".into(),
            ball_params: BallParams::default(),
            ground: None,
            evidence: BTreeMap::new(),
        }
        .to_toml(&[])
        .expect("writes");
        for (from, to, parts) in [
            ("restitution = 0.75", "restitution = 1.75", ["restitution", "0 to 1", "1.75"]),
            ("restitution", "bounciness", ["yard.toml", "bounciness", "restitution"]),
            ("mass_kg = 0.43", "mass_kg = nan", ["mass_kg", "a positive number", "NaN"]),
        ] {
            let error =
                Surface::parse(Path::new("yard.toml"), &text.replace(from, to)).expect_err("bad").to_string();
            for part in parts {
                assert!(error.contains(part), "{part}: {error}");
            }
        }
    }
}
