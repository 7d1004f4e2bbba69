//! What the trunk, the arms and the free joints of the kicking leg do.

use super::plan::{KICK, PLANT};
use super::{Biped, KickStyle, Plan, Track};

/// Base and joints over time.
#[derive(Clone, Debug)]
pub struct Posture {
    /// Height of the base `[m]`.
    pub height: Track<1>,
    /// Roll, pitch, yaw of the base `[rad]`.
    pub turn: Track<3>,
    /// Joints that do not follow from the feet, as offsets from the default pose `[rad]`.
    pub offsets: Vec<(usize, Track<1>)>,
    /// Angles of the kicking leg's ankle roll, ankle pitch and hip turn while the foot is free `[rad]`.
    pub free: [(usize, Track<1>); 3],
}

/// Swing of the arms in a step `[rad]`.
const WALK_ARMS: f64 = 0.22;

impl Posture {
    /// For a plan of a right-footed kick.
    pub fn new(figure: &Biped<'_>, plan: &Plan, style: &KickStyle) -> Self {
        let kick = plan.kick;
        let [walk, back, strike] = style.base_heights;
        let stand = figure.stance().0;
        let (first, last) = (plan.swings[0].lift, plan.end);
        // Sinking starts with the clip: the knees must be bent before the first long step.
        let height = Track::resting(&[
            (0.06, [stand]),
            (first + 0.10, [walk]),
            (kick.lift - 0.10, [walk]),
            (kick.lift + 0.10, [back]),
            (kick.back, [back]),
            (kick.contact + 0.02, [strike]),
            (kick.through, [strike]),
            (kick.land, [walk]),
            (last - 0.75, [walk]),
            (last - 0.06, [stand]),
        ]);
        let lean = 0.4 * style.lean;
        let mut turns = vec![(0.06, [0.0; 3])];
        let mut bent = [0.0, lean, 0.0];
        for (t, yaw) in plan.headings() {
            if t > kick.lift && t < kick.land + 1e-9 {
                turns.push((kick.back, [0.0, style.lean, plan.aim + style.hips[0]]));
                turns.push((kick.through, [0.0, -0.3 * style.lean, plan.aim + style.hips[1]]));
            }
            bent[2] = yaw;
            turns.push((t, bent));
        }
        turns.push((last - 0.06, [0.0; 3]));
        let turn = Track::resting(&turns);
        Self { height, turn, offsets: offsets(figure, plan, style), free: free(figure, plan, style) }
    }

    /// Joint angles at time `t`, model order `[rad]`; those of the legs are the default pose's.
    pub fn joints(&self, figure: &Biped<'_>, t: f64) -> Vec<f64> {
        let mut angles = figure.default_pos.clone();
        for (joint, course) in &self.offsets {
            angles[*joint] += course.at(t)[0];
        }
        angles
    }
}

/// Arms and waist: each arm swings with the opposite leg, the shoulders turn against the hips.
fn offsets(figure: &Biped<'_>, plan: &Plan, style: &KickStyle) -> Vec<(usize, Track<1>)> {
    let kick = plan.kick;
    let mut swing: [Vec<(f64, [f64; 1])>; 2] = [vec![(0.06, [0.0])], vec![(0.06, [0.0])]];
    let walk_waist = 0.25 * style.waist;
    let mut waist = vec![(0.06, [0.0])];
    for step in plan.swings.iter().filter(|s| s.lift != kick.lift) {
        // A positive shoulder pitch moves the arm back.
        let share = if step.lift > kick.lift { 0.3 } else { 1.0 };
        for side in [PLANT, KICK] {
            let forward = if side == step.foot { 1.0 } else { -1.0 };
            swing[side].push((step.land, [share * WALK_ARMS * forward]));
        }
        let turn = if step.foot == KICK { -1.0 } else { 1.0 };
        waist.push((step.land, [share * walk_waist * turn]));
    }
    for side in [PLANT, KICK] {
        let forward = if side == KICK { 1.0 } else { -1.0 };
        let at = swing[side].partition_point(|(t, _)| *t < kick.lift);
        // With the back-swing the opposite arm goes back, with the strike forward.
        swing[side].splice(
            at..at,
            [
                (kick.back, [-0.8 * style.arms * forward - style.arms_ahead]),
                (kick.through, [style.arms * forward - style.arms_ahead]),
            ],
        );
        swing[side].push((plan.end - 0.10, [0.0]));
    }
    let at = waist.partition_point(|(t, _)| *t < kick.lift);
    waist.splice(at..at, [(kick.back, [style.waist]), (kick.through, [-style.waist])]);
    waist.push((plan.end - 0.10, [0.0]));

    let kick_only = |value: f64| {
        let wait = 0.3 * value;
        Track::resting(&[
            (kick.lift - 0.2, [0.0]),
            (kick.back, [value]),
            (kick.through, [value]),
            (kick.land + 0.1, [wait]),
            (plan.end - 0.2, [0.0]),
        ])
    };
    let mut out = Vec::new();
    let mut add = |joint: Option<usize>, course: Track<1>| {
        if let Some(joint) = joint {
            out.push((joint, course));
        }
    };
    for side in [PLANT, KICK] {
        let outward = if side == PLANT { 1.0 } else { -1.0 };
        add(figure.joint(Some(side), "shoulder_pitch_joint"), Track::resting(&swing[side]));
        add(figure.joint(Some(side), "shoulder_roll_joint"), kick_only(0.6 * style.arms * outward));
        add(figure.joint(Some(side), "elbow_joint"), kick_only(0.4 * style.arms));
    }
    add(figure.joint(None, "waist_yaw_joint"), Track::resting(&waist));
    add(
        figure.joint(None, "waist_pitch_joint"),
        Track::resting(&[
            (kick.lift - 0.1, [0.0]),
            (kick.back, [0.3 * style.lean]),
            (kick.through, [1.5 * style.lean]),
            (kick.land, [0.5 * style.lean]),
            (plan.end - 0.3, [0.0]),
        ]),
    );
    out
}

/// Hip turn and ankle of the kicking leg, for as long as the foot need not be flat.
fn free(figure: &Biped<'_>, plan: &Plan, style: &KickStyle) -> [(usize, Track<1>); 3] {
    let kick = plan.kick;
    let [roll, pitch, turn] = figure.free[KICK];
    let course = |values: [f64; 5]| {
        let times = [kick.lift, kick.back, kick.contact, kick.through, kick.land];
        let knots: Vec<_> = times.into_iter().zip(values).map(|(t, v)| (t, [v])).collect();
        Track::resting(&knots)
    };
    let default = figure.default_pos[pitch];
    let out = -style.turn_out;
    [
        (roll, course([0.0; 5])),
        (pitch, course([default, 0.15, -0.30, -0.10, default])),
        (turn, course([0.0, 0.3 * out, out, 0.6 * out, 0.0])),
    ]
}
