//! Why a shot missed.

use serde::Serialize;

use super::judge::EyesOutcome;

/// Why a shot missed: the first that holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// No ball was found at the start, so that no kick began; or none was seen in the last second before the strike, and it was not
    /// where it was believed.
    NotSeen,
    /// Its estimate was wrong, and odometry had moved since it was seen.
    Odometry,
    /// Its estimate was wrong: something else, or a wrong position.
    SeenWrong,
    /// It was where it was believed to be.
    KickedWrong,
}

/// A ball that is believed farther from its place than this was not known `[m]`: about its radius.
pub(super) const KNOWN_M: f64 = 0.10;
/// A ball that was not seen for this long before the strike counts as not seen, if its position is wrong `[s]`.
const UNSEEN_S: f64 = 1.0;

impl Cause {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::NotSeen, Self::SeenWrong, Self::Odometry, Self::KickedWrong];

    /// As the tables say it.
    pub fn words(self) -> &'static str {
        match self {
            Self::NotSeen => "not seen",
            Self::SeenWrong => "seen wrong",
            Self::Odometry => "odometry",
            Self::KickedWrong => "kicked wrong",
        }
    }

    /// The cause of a miss.
    pub(super) fn of(eyes: &EyesOutcome) -> Self {
        if eyes.start_error_m.is_none() {
            return Self::NotSeen;
        }
        // The choice of the motion is by the ball at the start, the kick by the ball shortly before the strike.
        let wrong = |error: Option<f64>| error.is_some_and(|error| error > KNOWN_M);
        if wrong(eyes.strike_error_m) {
            if eyes.strike_age_s.is_some_and(|age| age > UNSEEN_S) {
                return Self::NotSeen;
            }
            let total = eyes.strike_error_m.unwrap_or(0.0);
            let by_odometry = eyes.odometry_error_m.unwrap_or(0.0) > 0.5 * total;
            return if by_odometry { Self::Odometry } else { Self::SeenWrong };
        }
        if wrong(eyes.start_error_m) { Self::SeenWrong } else { Self::KickedWrong }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cause_follows_from_what_was_believed() {
        let right = EyesOutcome {
            start_error_m: Some(0.02),
            strike_error_m: Some(0.03),
            strike_age_s: Some(0.1),
            odometry_error_m: Some(0.01),
            ..EyesOutcome::default()
        };
        assert_eq!(Cause::of(&right), Cause::KickedWrong);
        assert_eq!(Cause::of(&EyesOutcome::default()), Cause::NotSeen);
        let beside = EyesOutcome { strike_error_m: Some(0.2), ..right.clone() };
        assert_eq!(Cause::of(&beside), Cause::SeenWrong);
        assert_eq!(
            Cause::of(&EyesOutcome { odometry_error_m: Some(0.15), ..beside.clone() }),
            Cause::Odometry
        );
        assert_eq!(Cause::of(&EyesOutcome { strike_age_s: Some(2.0), ..beside }), Cause::NotSeen);
        assert_eq!(Cause::of(&EyesOutcome { start_error_m: Some(0.5), ..right }), Cause::SeenWrong);
    }
}
