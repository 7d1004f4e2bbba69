//! How a kick looks: the numbers that an author of motions turns.

/// Shape and speed of a kick. Lengths are along the shot (x' toward the goal from the ball) and to its left for a
/// right-footed kick; a left-footed one is its mirror image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KickStyle {
    /// Speed of the toe at the ball `[m/s]`.
    pub speed: f64,
    /// Height of the toe's center at the ball `[m]`; a little below the ball's center.
    pub strike_height: f64,
    /// How far behind the point of contact the toe swings back `[m]`.
    pub back: f64,
    /// How far to the left of the shot's line the toe is there `[m]`: behind the hip, which is between plant foot and ball.
    pub back_side: f64,
    /// Height of the toe there `[m]`.
    pub back_height: f64,
    /// How far past the point of contact the toe swings `[m]`.
    pub through: f64,
    /// How far to the left of the shot's line the toe is there `[m]`.
    pub through_side: f64,
    /// Height of the toe there `[m]`.
    pub through_height: f64,
    /// Outward turn of the leg about the hip at the ball `[rad]`: large for the inside of the foot, small for the instep.
    pub turn_out: f64,
    /// Where the plant foot's ankle stands, from the ball `[m]`.
    pub plant: [f64; 2],
    /// Where the kicking foot's ankle stands before it swings, from the plant foot's `[m]`.
    pub take_off: [f64; 2],
    /// Height of the base while walking, in the back-swing, and at the ball `[m]`.
    pub base_heights: [f64; 3],
    /// Largest turn of shoulders against hips about the vertical `[rad]`.
    pub waist: f64,
    /// Where the hips face, off the shot's line, in the back-swing and at the end of the follow-through; negative: to the
    /// kicking foot's side `[rad]`.
    pub hips: [f64; 2],
    /// Swing of the arms in the kick `[rad]`.
    pub arms: f64,
    /// How far ahead of the body both arms swing in the kick `[rad]`.
    pub arms_ahead: f64,
    /// Forward lean of the trunk in the back-swing `[rad]`.
    pub lean: f64,
}

impl KickStyle {
    /// A pass or placed shot with the inside of the foot at 4.5 m/s.
    pub fn standard() -> Self {
        Self {
            speed: 4.8,
            strike_height: 0.10,
            back: 0.40,
            back_side: 0.07,
            back_height: 0.27,
            through: 0.52,
            through_side: 0.04,
            through_height: 0.34,
            turn_out: 0.50,
            plant: [-0.19, 0.185],
            take_off: [-0.25, -0.24],
            base_heights: [0.725, 0.715, 0.73],
            waist: 0.30,
            hips: [-0.15, 0.15],
            arms: 0.55,
            arms_ahead: 0.0,
            lean: 0.10,
        }
    }

    /// A hard shot with the instep at 6.5 m/s: a longer back-swing and follow-through, more waist and arms.
    pub fn powerful() -> Self {
        Self {
            speed: 7.0,
            strike_height: 0.10,
            back: 0.50,
            back_height: 0.34,
            through: 0.58,
            through_height: 0.44,
            turn_out: 0.35,
            waist: 0.45,
            hips: [-0.225, 0.225],
            arms: 0.85,
            lean: 0.14,
            ..Self::standard()
        }
    }

    /// As [`KickStyle::standard`], but moved as people do: the hips open to the kicking foot's side and turn through the strike, the foot
    /// comes low from behind and outside and ends across the body, the legs are straighter, the arms swing less and ahead of the body. The other
    /// foot stands wider, so that the kicking foot passes that leg's shin with as much room as people's do (7 to 16 cm).
    pub fn natural() -> Self {
        Self {
            back: 0.44,
            back_side: 0.08,
            back_height: 0.14,
            through: 0.50,
            through_side: 0.12,
            through_height: 0.30,
            turn_out: 0.25,
            plant: [-0.19, 0.22],
            base_heights: [0.745, 0.740, 0.750],
            hips: [-0.85, 0.10],
            arms: 0.48,
            arms_ahead: 0.45,
            ..Self::standard()
        }
    }

    /// [`KickStyle::natural`] with the instep at 6.5 m/s.
    pub fn natural_powerful() -> Self {
        Self {
            back: 0.52,
            back_side: 0.07,
            back_height: 0.20,
            through: 0.54,
            through_side: 0.08,
            through_height: 0.36,
            turn_out: 0.20,
            plant: [-0.19, 0.22],
            base_heights: [0.745, 0.740, 0.750],
            waist: 0.40,
            hips: [-0.80, 0.10],
            arms: 0.55,
            arms_ahead: 0.45,
            ..Self::powerful()
        }
    }
}
