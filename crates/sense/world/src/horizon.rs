//! How far behind the present the tracker stays.

/// It stays at least this far behind `[s]`: the images of a usual camera are younger.
const LEAST_S: f64 = 0.15;
/// It stays this far behind late images `[s]`: the next one may be older.
const MARGIN_S: f64 = 0.05;
/// With each younger image it comes back by this `[s]`: a single late one does not keep it in the past.
const BACK_S: f64 = 0.01;
/// What the tracker itself allows for rounding `[s]`.
const ROUNDING_S: f64 = 1e-4;

/// How far behind the present the tracker stays `[s]`. An image that is older than the tracker's state adds nothing, so the state stays
/// behind the images that come, up to the oldest that are used at all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Horizon(f64);

impl Default for Horizon {
    fn default() -> Self {
        Self(LEAST_S)
    }
}

impl Horizon {
    /// In seconds.
    pub fn seconds(self) -> f64 {
        self.0
    }

    /// An image of this age has come `[s]`. False: the tracker is past its time already; others of its age will be in time.
    pub fn reaches(&mut self, age_s: f64) -> bool {
        let in_time = age_s <= self.0 + ROUNDING_S;
        let wanted = if age_s <= LEAST_S + ROUNDING_S { LEAST_S } else { age_s + MARGIN_S };
        self.0 = wanted.max(self.0 - BACK_S);
        in_time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_keeps_its_place_for_usual_pictures_and_stays_behind_late_ones() {
        let mut horizon = Horizon::default();
        assert_eq!([0.0, 0.06, 0.15].map(|age_s| horizon.reaches(age_s)), [true; 3]);
        assert_eq!(horizon.seconds(), 0.15);
        // The first late one is lost, the others are in time.
        assert_eq!([0.2, 0.2, 0.24, 0.19].map(|age_s| horizon.reaches(age_s)), [false, true, true, true]);
        // Usual ones again: it comes back.
        assert_eq!([0.06; 20].map(|age_s| horizon.reaches(age_s)), [true; 20]);
        assert_eq!(horizon.seconds(), 0.15);
    }
}
