//! An identification as text for people.

use std::fmt::Write;

use crate::confidence::{Estimate, Verdict};
use crate::identify::Identification;
use crate::options::{NAMES, PARAMETERS, Parameters};
use crate::search::Stop;

/// Correlations of this size or more are spelled out.
const STRONG: f64 = 0.8;

const ROUGH_STARTS: &str = "The rolls fit much worse than the drops: the first samples give a rough initial speed. --starts refined \
                            corrects it, or film with more frames per second.";

impl Identification {
    /// Parameters, correlations and remarks. `truth`, if known, is printed next to the values.
    pub fn table(&self, truth: Option<&Parameters>) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_table(&mut out, truth);
        out
    }

    fn write_table(&self, out: &mut String, truth: Option<&Parameters>) -> std::fmt::Result {
        let (c, g) = (&self.confidence, &self.ground);
        let mm = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{:.1} mm", 1000.0 * x));
        let ended = self.searches.iter().filter(|s| s.stop == Stop::Tolerance).count();
        writeln!(
            out,
            "{} drops, {} rolls; loss {:.3e} m^2; root mean square error: drop {}, roll {}",
            self.drops.len(),
            self.rolls.len(),
            self.loss,
            mm(self.drop_rms_m),
            mm(self.roll_rms_m)
        )?;
        writeln!(
            out,
            "{} of {} searches agree within the noise ({:.1} mm); {ended} ended by the loss tolerance; {} rollouts",
            c.agreeing,
            self.searches.len(),
            1000.0 * c.noise_m,
            self.rollouts
        )?;
        writeln!(
            out,
            "ground held at static friction {}, dynamic friction {}, restitution {}",
            g.static_friction, g.dynamic_friction, g.restitution
        )?;
        let known = if truth.is_some() { "    truth   error" } else { "" };
        writeln!(out)?;
        writeln!(
            out,
            "{:<17} {:>8} {:>9} {:>9} {:>9} {:>17}  {:<7}{known}",
            "parameter", "value", "restarts", "repeats", "curvature", "fits as well", "verdict"
        )?;
        for (i, e) in c.estimates.iter().enumerate() {
            let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.4}"));
            write!(
                out,
                "{:<17} {:>8.4} {:>9.4} {:>9} {:>9} {:>17}  {:<7}",
                e.name,
                e.value,
                e.restart_spread,
                number(e.repeat_error),
                number(e.standard_error),
                format!("{:.3} to {:.3}", e.flat[0], e.flat[1]),
                e.verdict.name()
            )?;
            if let Some(truth) = truth {
                write!(out, " {:>8.4} {:>7}", truth[i], error(e.value, truth[i]))?;
            }
            writeln!(out)?;
        }
        writeln!(out, "\ncorrelation of errors")?;
        for i in 0..PARAMETERS {
            write!(out, "{:<17}", NAMES[i])?;
            for j in 0..=i {
                let cell = c.correlation[i][j].map_or("-".to_owned(), |r| format!("{r:+.2}"));
                write!(out, " {cell:>6}")?;
            }
            writeln!(out)?;
        }
        for remark in self.remarks() {
            writeln!(out, "\n{remark}")?;
        }
        Ok(())
    }

    /// What a reader of the values must know, a sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let c = &self.confidence;
        let mut out = Vec::new();
        for e in &c.estimates {
            if e.verdict == Verdict::Unseen {
                out.push(unseen(e));
            } else if e.at_bound && e.flat[0] <= 0.0 {
                out.push(format!("{} cannot be distinguished from 0.", e.name));
            } else if e.at_bound {
                out.push(format!(
                    "{} ended at an end of its range ({:.3}): the true value may lie beyond it, or the ground's own value limits it.",
                    e.name, e.value
                ));
            }
        }
        for i in 0..PARAMETERS {
            for j in 0..i {
                if let Some(r) = c.correlation[i][j].filter(|r| r.abs() >= STRONG) {
                    out.push(format!(
                        "{} and {} are correlated ({r:+.2}): the data fix a combination of the two better than either.",
                        NAMES[j], NAMES[i]
                    ));
                }
            }
        }
        if let (Some(roll), false) = (self.roll_rms_m, self.starts_refined)
            && self.drop_rms_m.is_some_and(|drop| roll > 2.0 * drop)
        {
            out.push(ROUGH_STARTS.to_owned());
        }
        let half = self.searches.len() / 2;
        if c.agreeing <= half && self.searches.len() > 1 {
            out.push(format!(
                "Only {} of {} searches reached the best fit; more --restarts or a larger --population would make that more certain.",
                c.agreeing,
                self.searches.len()
            ));
        }
        out
    }
}

/// How far a value is off, as a share of the truth; of 0 there is none.
fn error(value: f64, truth: f64) -> String {
    if truth == 0.0 {
        return "-".to_owned();
    }
    format!("{:+.1}%", 100.0 * (value - truth) / truth.abs())
}

fn unseen(e: &Estimate) -> String {
    let why = match e.name {
        "static_friction" => {
            " It only has to be large enough for the ball to roll: the low end is only a lower limit."
        }
        "dynamic_friction" => {
            " A rolling ball does not slide; film one that is pushed off without spin (--slide)."
        }
        _ => "",
    };
    let taken = match e.kept {
        Some(kept) => format!("the surface gets {kept:.3}, which was not measured"),
        None => format!("{:.3} was not measured", e.value),
    };
    let [low, high] = e.flat;
    let name = e.name;
    format!(
        "{name} cannot be identified from these measurements: {low:.3} to {high:.3} fit as well; {taken}.{why}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_a_share_of_the_truth_and_of_none_there_is_no_share() {
        assert_eq!(error(0.0111, 0.01), "+11.0%");
        assert_eq!(error(4.9005, 4.95), "-1.0%");
        assert_eq!(error(0.003, 0.0), "-");
    }
}
