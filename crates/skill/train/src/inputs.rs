//! Where a network's inputs are among those of the network that it starts from.

use paid_policy::observation::{ObservationId, Shape};
use paid_policy::{Dimensions, ObservationTerms};

/// For each number its number in the earlier observation, `None` for those of new terms.
pub(crate) type Inputs = Vec<Option<usize>>;

/// The places of the observation `now` in the observation `before` of `size` numbers, if it has all terms of `before` and either more of
/// them or another order. The two places of the ball, now and at the strike, count as one term where a list has only one of them. `None` if the numbers stay where they are, also those of a term that replaces another; or if the sizes do not
/// fit, which the reader of the weights reports.
///
/// # Errors
/// If terms have moved and others are missing: which one stands for which is unknown.
pub(crate) fn inputs_from(
    before: &[ObservationId],
    now: &[ObservationId],
    joints: usize,
    size: usize,
) -> Result<Option<Inputs>, String> {
    let Some(dimensions) = dimensions(before, joints, size) else { return Ok(None) };
    let found = before;
    let before: Vec<ObservationId> = found.iter().map(|id| of_the_ball(*id, found, now)).collect();
    let before = before.as_slice();
    let of_bodies = |id: &ObservationId| matches!(id.info().shape, Shape::BodyVectors | Shape::BodyRotations);
    if dimensions.bodies == 0 && now.iter().any(of_bodies) {
        return Ok(None); // what only a simulator knows: no policy has it
    }
    let [old, new] = [before, now].map(|list| ObservationTerms::new(list, dimensions));
    let mut from = Inputs::new();
    for term in new.terms() {
        let place = old.place(&term.name);
        from.extend((0..term.size).map(|k| place.as_ref().map(|place| place.start + k)));
    }
    let stay =
        from.len() == size && from.iter().enumerate().all(|(k, from)| from.is_none_or(|from| from == k));
    if !stay && before.iter().all(|id| now.contains(id)) {
        return Ok(Some(from));
    }
    if stay || from.len() != size {
        return Ok(None);
    }
    let names = |list: &[ObservationId]| list.iter().map(ObservationId::name).collect::<Vec<_>>().join(", ");
    Err(format!(
        "expected {}, found {}; terms may stand in another order or give way to others, not both",
        names(now),
        names(found)
    ))
}

/// The other place of the ball, if that is what the later list has instead of this one.
fn of_the_ball(id: ObservationId, before: &[ObservationId], now: &[ObservationId]) -> ObservationId {
    use ObservationId::{BallAtStrike, BallPos};
    let other = match id {
        BallPos => BallAtStrike,
        BallAtStrike => BallPos,
        other => return other,
    };
    if now.contains(&other) && !now.contains(&id) && !before.contains(&other) { other } else { id }
}

/// The robot's sizes with which a list has `size` numbers; it has no bodies where no term is of them.
fn dimensions(list: &[ObservationId], joints: usize, size: usize) -> Option<Dimensions> {
    let of = |bodies| ObservationTerms::new(list, Dimensions { joints, bodies }).dim();
    let (without, each) = (of(0), of(1) - of(0));
    let bodies = size.checked_sub(without)?.checked_div(each).unwrap_or(0);
    (without + bodies * each == size).then_some(Dimensions { joints, bodies })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ObservationId::{BallAtStrike, BallPos, BaseAngVel, BodyOri, BodyPos, GoalPos, JointVel};

    #[test]
    fn known_terms_keep_their_numbers_wherever_they_stand() {
        let of = |before: &[ObservationId], now: &[ObservationId], size| {
            inputs_from(before, now, 2, size).expect("clear").expect("others")
        };
        let known = |numbers: [usize; 3]| numbers.map(Some);
        let from = of(&[JointVel, BallPos], &[BallPos, BallAtStrike, JointVel], 5);
        assert_eq!(from[..3], known([2, 3, 4]));
        assert_eq!(from[3..6], [None; 3]);
        assert_eq!(from[6..], [Some(0), Some(1)]);
        let six = of(&[GoalPos], &[GoalPos, BallPos], 3);
        assert_eq!((six.len(), six[2], six[3]), (6, Some(2), None));
        // In another order, of a critic too, which sees bodies: two of them here.
        assert_eq!(of(&[JointVel, BallPos], &[BallPos, JointVel], 5), [2_usize, 3, 4, 0, 1].map(Some));
        let from = of(&[JointVel, BodyPos, BodyOri], &[BodyPos, BodyOri, JointVel], 20);
        assert!(from.iter().copied().eq((2_usize..20).chain(0..2).map(Some)), "{from:?}");
    }

    #[test]
    fn numbers_stay_where_a_term_gives_way_to_another_and_where_sizes_do_not_fit() {
        let same = |before: &[ObservationId], now: &[ObservationId], size| {
            inputs_from(before, now, 2, size) == Ok(None)
        };
        assert!(same(&[JointVel, BallPos, GoalPos], &[JointVel, BallPos, GoalPos], 8));
        assert!(
            same(&[JointVel, BallPos, GoalPos], &[JointVel, BallAtStrike, GoalPos], 8),
            "the presets' way"
        );
        assert!(same(&[JointVel, BodyPos, BallPos], &[JointVel, BodyPos, BallAtStrike], 11));
        assert!(same(&[JointVel, BallPos], &[JointVel, BodyPos, GoalPos], 5), "wider, and lacks one");
        assert!(same(&[JointVel, BallPos], &[BallPos], 5));
        assert!(same(&[JointVel], &[JointVel, BodyPos], 2));
        assert!(same(&[JointVel, BallPos], &[BallPos, JointVel], 6), "another robot");
        assert!(same(&[JointVel, BodyPos], &[BodyPos, JointVel], 6), "of a body and a third");
    }

    #[test]
    fn the_balls_place_at_the_strike_gives_way_to_the_present_one_wherever_it_stands() {
        let from = inputs_from(&[JointVel, BallAtStrike, GoalPos], &[GoalPos, BallPos, JointVel], 2, 8);
        let expected = [5_usize, 6, 7, 2, 3, 4, 0, 1].map(Some).to_vec();
        assert_eq!(from, Ok(Some(expected)));
    }

    #[test]
    fn a_list_that_lacks_a_term_and_moves_others_is_refused() {
        let error = inputs_from(&[JointVel, BallPos, GoalPos], &[GoalPos, JointVel, BaseAngVel], 2, 8)
            .expect_err("which one is base_ang_vel?");
        let lists =
            "expected goal_pos, joint_vel, base_ang_vel, found joint_vel, ball_pos, goal_pos; terms may";
        assert!(error.starts_with(lists), "{error}");
    }
}
