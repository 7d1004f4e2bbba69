//! A policy that is to see more than the one it starts from.

use paid_policy::observation::{ObservationId, Shape};
use paid_policy::{Dimensions, ObservationTerms};

/// For each number of the observation `now` its number in the observation `before`, `None` for those of new terms; or `None` if `now`
/// lacks a term of `before`, or has none beside them.
pub(crate) fn inputs_from(
    before: &[ObservationId],
    now: &[ObservationId],
    joints: usize,
) -> Option<Vec<Option<usize>>> {
    if now.len() <= before.len() || before.iter().any(|id| !now.contains(id)) {
        return None;
    }
    let of_bodies = |id: &ObservationId| matches!(id.info().shape, Shape::BodyVectors | Shape::BodyRotations);
    if now.iter().any(of_bodies) {
        return None; // what only a simulator knows: no policy has it
    }
    let terms = |list| ObservationTerms::new(list, Dimensions { joints, bodies: 0 });
    let (before, now) = (terms(before), terms(now));
    let mut from = Vec::new();
    for term in now.terms() {
        let place = before.place(&term.name);
        from.extend((0..term.size).map(|k| place.as_ref().map(|place| place.start + k)));
    }
    Some(from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ObservationId::{BallAtStrike, BallBefore, BallPos, BodyPos, GoalPos, JointVel};

    #[test]
    fn known_terms_keep_their_numbers_wherever_they_stand() {
        let from = inputs_from(&[JointVel, BallPos], &[BallPos, BallAtStrike, JointVel], 2).expect("more");
        let known = |numbers: [usize; 3]| numbers.map(Some);
        assert_eq!(from[..3], known([2, 3, 4]));
        assert_eq!(from[3..6], [None; 3]);
        assert_eq!(from[6..], [Some(0), Some(1)]);
        let nine = inputs_from(&[GoalPos], &[GoalPos, BallBefore], 2).expect("more");
        assert_eq!((nine.len(), nine[2], nine[3]), (12, Some(2), None));
    }

    #[test]
    fn a_list_that_lacks_a_term_or_has_no_more_is_no_wider_one() {
        assert_eq!(inputs_from(&[JointVel, BallPos], &[JointVel, BallAtStrike, GoalPos], 2), None);
        assert_eq!(inputs_from(&[JointVel, BallPos], &[BallPos, JointVel], 2), None);
        assert_eq!(inputs_from(&[JointVel], &[JointVel, BodyPos], 2), None);
    }
}
