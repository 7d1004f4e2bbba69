//! Kinds of contacts and joint control: checks of the nominal one, draws of others.

use paid_lanes::rng::Rng;
use paid_physics::{
    Compliance, Cone, ContactCompliance, ContactKind, EnvParams, Material, SceneConfig, SoleShape,
};

use crate::TaskError;
use crate::preset::randomization::RandomizationPreset;
use crate::preset::{Range, value_error};

/// Longest time constant `[s]`: a ball would sink in by its radius.
const LONGEST_S: f64 = 0.1;

/// Contact times `[s]` and restitutions of a match ball on a wall: 20 impacts at 9 to 19 m/s, filmed with 6000 images per second.
const FILMED_CONTACT_S: Range = [0.0058, 0.007];
const FILMED_RESTITUTION: Range = [0.8, 0.89];

/// Refuses values that make no contact.
pub(crate) fn check(kind: &ContactKind) -> Result<(), TaskError> {
    let soft = &kind.compliance;
    let springs = [
        ("ball_robot", soft.ball_robot),
        ("ball_ground", soft.ball_ground),
        ("sole_ground", soft.sole_ground),
    ];
    let [least, most] = Compliance::RATIOS;
    let mut values: Vec<(String, f64, f64, f64)> = Vec::new();
    for (name, spring) in springs {
        let key = |what: &str| format!("compliance.{name}.{what}");
        values.push((key("time_constant_s"), spring.time_constant_s, 0.0, LONGEST_S));
        values.push((key("damping_ratio"), spring.damping_ratio, least, most));
    }
    let others = [
        ("ball_spin_friction_m.0", kind.ball_spin_friction_m[0], 0.0, 1.0),
        ("ball_spin_friction_m.1", kind.ball_spin_friction_m[1], 0.0, 1.0),
        ("sole.length_scale", kind.sole.length_scale, 0.5, 1.5),
        ("sole.width_scale", kind.sole.width_scale, 0.5, 1.5),
        ("sole.rounding_m", kind.sole.rounding_m, 0.0, 0.03),
        ("foot_flatness", kind.foot_flatness, 0.0, 1.0),
        ("pd_implicitness", kind.pd_implicitness, 0.0, 1.0),
    ];
    values.extend(others.map(|(key, value, lo, hi)| (key.to_owned(), value, lo, hi)));
    for (key, value, lo, hi) in values {
        if !(lo..=hi).contains(&value) {
            let key = format!("contact_kind.{key}");
            return Err(value_error(&key, &format!("{lo} to {hi}"), value.to_string()));
        }
    }
    Ok(())
}

/// A kind from the ranges. `params` has its surfaces already: a soft contact returns what they return.
pub(crate) fn draw_kind(
    ranges: &RandomizationPreset,
    scene: &SceneConfig,
    params: &EnvParams,
    rng: &mut Rng,
) -> ContactKind {
    let mut draw = |[lo, hi]: Range| rng.uniform(lo, hi);
    let ball_time = draw(ranges.ball_contact_time_s);
    let sole_time = draw(ranges.sole_contact_time_s);
    let contact = |time_s: f64, surfaces: Material| {
        if time_s < Compliance::LEAST_TIME_S {
            Compliance::HARD
        } else {
            Compliance::returning(time_s, surfaces.restitution)
        }
    };
    let on_robot = SceneConfig::contact_of_ball_and_robot(params.ball.material, params.robot);
    let mut kind = ContactKind {
        compliance: ContactCompliance {
            ball_robot: contact(ball_time, on_robot),
            ball_ground: contact(ball_time, scene.contact_with_ground(params.ball.material)),
            sole_ground: contact(sole_time, scene.contact_with_ground(params.robot)),
        },
        ball_spin_friction_m: [ranges.ball_torsional_friction_m, ranges.ball_rolling_friction_m]
            .map(&mut draw),
        cone: Cone {
            pyramid: draw([0.0, 1.0]) < ranges.pyramid_share,
            convex: draw([0.0, 1.0]) < ranges.convex_share,
        },
        sole: SoleShape {
            length_scale: draw(ranges.sole_scale),
            width_scale: draw(ranges.sole_scale),
            rounding_m: draw(ranges.sole_rounding_m),
        },
        pd_implicitness: draw(ranges.pd_implicitness),
        // Drawn last, and only if asked for: presets without it draw what they always drew.
        foot_flatness: if ranges.foot_flatness == [0.0; 2] { 0.0 } else { draw(ranges.foot_flatness) },
    };
    if ranges.real_ball_share > 0.0 && draw([0.0, 1.0]) < ranges.real_ball_share {
        let filmed = Compliance::lasting(draw(FILMED_CONTACT_S), draw(FILMED_RESTITUTION));
        (kind.compliance.ball_robot, kind.compliance.ball_ground) = (filmed, filmed);
    }
    kind
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TaskPreset;

    #[test]
    fn kinds_are_off_by_default_and_else_within_their_ranges() {
        assert!(!TaskPreset::builtin("paper_stage2").expect("valid").randomization.kinds());
        let sets = [
            "randomization.ball_contact_time_s=[0, 0.025]",
            "randomization.ball_torsional_friction_m=[0, 0.01]",
            "randomization.pyramid_share=0.25",
            "randomization.sole_scale=[0.8, 1]",
            "randomization.pd_implicitness=[0.2, 1]",
            "randomization.foot_flatness=[0.3, 1]",
        ];
        let task = TaskPreset::builtin_with("paper_stage2", &sets.map(str::to_owned)).expect("valid");
        assert!(task.randomization.kinds());
        let params = EnvParams { ball: task.ball_params, ..EnvParams::default() };
        let mut rng = Rng::new(1, 0, 0);
        let n = 4000;
        let kinds: Vec<ContactKind> =
            (0..n).map(|_| draw_kind(&task.randomization, &task.scene, &params, &mut rng)).collect();
        let share =
            |of: fn(&ContactKind) -> bool| kinds.iter().filter(|k| of(k)).count() as f64 / f64::from(n);
        // 2 of 25 ms are hard, a quarter have pyramids.
        assert!((share(|k| k.compliance.ball_robot.is_soft()) - 0.92).abs() < 0.02);
        assert!((share(|k| k.cone.pyramid) - 0.25).abs() < 0.03);
        assert_eq!(share(|k| k.cone.convex || k.compliance.sole_ground.is_soft()), 0.0);
        for k in kinds {
            // The ball's 0.75 times the ground's 0.8; half of 0.75 against the robot, which does not bounce.
            let soft = &k.compliance;
            if soft.ball_ground.is_soft() {
                assert!((soft.ball_ground.restitution() - 0.6).abs() < 1e-6, "{k:?}");
                assert!((soft.ball_robot.restitution() - 0.375).abs() < 1e-6, "{k:?}");
                assert_eq!(soft.ball_ground.time_constant_s, soft.ball_robot.time_constant_s);
            }
            assert!((0.8..=1.0).contains(&k.sole.width_scale) && k.sole.rounding_m == 0.0, "{k:?}");
            assert!((0.2..=1.0).contains(&k.pd_implicitness), "{k:?}");
            assert!((0.3..=1.0).contains(&k.foot_flatness), "{k:?}");
            assert!((0.0..=0.01).contains(&k.ball_spin_friction_m[0]) && k.ball_spin_friction_m[1] == 0.0);
        }
    }

    #[test]
    fn a_share_of_the_balls_bounces_as_filmed() {
        let task =
            TaskPreset::builtin_with("paper_stage2", &["randomization.real_ball_share=0.25".to_owned()])
                .expect("valid");
        let params = EnvParams { ball: task.ball_params, ..EnvParams::default() };
        let mut rng = Rng::new(1, 0, 0);
        let n = 4000;
        let mut filmed = 0;
        for _ in 0..n {
            let soft = draw_kind(&task.randomization, &task.scene, &params, &mut rng).compliance;
            if soft.ball_robot.is_soft() {
                filmed += 1;
                assert_eq!(soft.ball_robot, soft.ball_ground);
                assert!((0.799..0.891).contains(&soft.ball_robot.restitution()), "{soft:?}");
                assert!((0.00579..0.00701).contains(&soft.ball_robot.lasts_s()), "{soft:?}");
            }
        }
        assert!((f64::from(filmed) / f64::from(n) - 0.25).abs() < 0.02, "{filmed}");
    }

    #[test]
    fn values_out_of_range_are_refused_by_key() {
        for (set, hint) in [
            (
                "contact_kind.compliance.ball_robot.time_constant_s=-1",
                "ball_robot.time_constant_s is -1, expected 0 to 0.1",
            ),
            (
                "contact_kind.compliance.sole_ground.damping_ratio=0",
                "sole_ground.damping_ratio is 0, expected 0.01 to 1",
            ),
            ("contact_kind.foot_flatness=1.5", "contact_kind.foot_flatness is 1.5, expected 0 to 1"),
            ("contact_kind.pd_implicitness=1.5", "contact_kind.pd_implicitness"),
            ("contact_kind.sole.width_scale=0", "contact_kind.sole.width_scale"),
        ] {
            let error =
                TaskPreset::builtin_with("paper_stage2", &[set.to_owned()]).expect_err(set).to_string();
            assert!(error.contains(hint), "{set}: {error}");
        }
    }

    #[test]
    fn the_papers_contacts_are_the_engines_own() {
        let task = TaskPreset::builtin("paper_stage2").expect("valid");
        assert_eq!(task.contact_kind, ContactKind::default());
    }
}
