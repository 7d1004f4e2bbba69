//! Ranges of a preset's numbers.

use paid_physics::{BallParams, Material, SceneConfig, Terrain};

use super::{Range, value_error};
use crate::TaskError;

/// Least and greatest value, and how that reads in an error.
pub(crate) type Limits = ([f64; 2], &'static str);

pub(crate) const SHARE: Limits = ([0.0, 1.0], "a share between 0 and 1");
pub(crate) const FRICTION: Limits = ([0.0, 10.0], "0 to 10");
/// With the greatest one a ball keeps half of its speed over a physics step of 5 ms.
pub(crate) const DAMPING: Limits = ([0.0, 100.0], "0 to 100 1/s");
pub(crate) const MASS: Limits = ([f64::MIN_POSITIVE, 100.0], "above 0, at most 100 kg");
pub(crate) const FACTOR: Limits = ([f64::MIN_POSITIVE, 10.0], "above 0, at most 10");
pub(crate) const LENGTH: Limits = ([0.0, 100.0], "0 to 100 m");
pub(crate) const POSITIVE_LENGTH: Limits = ([f64::MIN_POSITIVE, 100.0], "above 0, at most 100 m");
pub(crate) const PLACE: Limits = ([-100.0, 100.0], "-100 to 100 m");
pub(crate) const ANGLE: Limits = ([0.0, 3.15], "0 to 3.15 rad");
pub(crate) const SPEED: Limits = ([0.0, 100.0], "0 to 100 m/s");
pub(crate) const TURN_RATE: Limits = ([0.0, 100.0], "0 to 100 rad/s");
pub(crate) const TIME: Limits = ([0.0, 60.0], "0 to 60 s");
pub(crate) const POSITIVE_TIME: Limits = ([f64::MIN_POSITIVE, 3600.0], "above 0, at most 3600 s");
pub(crate) const COUNT: Limits = ([1.0, 1000.0], "at least 1, at most 1000");

/// A value, or the ends of what is drawn.
#[derive(Clone, Copy)]
pub(crate) enum Number {
    One(f64),
    Drawn(Range),
}

impl From<f64> for Number {
    fn from(value: f64) -> Self {
        Self::One(value)
    }
}

impl From<usize> for Number {
    fn from(value: usize) -> Self {
        Self::One(value as f64)
    }
}

impl From<Range> for Number {
    fn from(range: Range) -> Self {
        Self::Drawn(range)
    }
}

/// Refuses the first number outside its limits, and a range that does not ascend. Keys are in `table`.
pub(crate) fn check(table: &str, rows: &[(&str, Number, Limits)]) -> Result<(), TaskError> {
    for &(name, number, ([least, most], expected)) in rows {
        let (lo, hi, found) = match number {
            Number::One(value) => (value, value, value.to_string()),
            Number::Drawn([lo, hi]) => (lo, hi, format!("{:?}", [lo, hi])),
        };
        // A value that is no number is nowhere within limits; as an end of a range it is not ascending either.
        let ascends = lo <= hi || matches!(number, Number::One(_));
        let expected = if ascends { expected } else { "[lo, hi] with lo <= hi" };
        if !(ascends && (least..=most).contains(&lo) && (least..=most).contains(&hi)) {
            let key = if table.is_empty() { name.to_owned() } else { format!("{table}.{name}") };
            return Err(value_error(&key, expected, found));
        }
    }
    Ok(())
}

/// Checks a surface at `table`.
pub(crate) fn check_material(table: &str, material: &Material) -> Result<(), TaskError> {
    let Material { static_friction, dynamic_friction, restitution } = *material;
    check(
        table,
        &[
            ("static_friction", static_friction.into(), FRICTION),
            ("dynamic_friction", dynamic_friction.into(), FRICTION),
            ("restitution", restitution.into(), SHARE),
        ],
    )
}

/// Checks the nominal ball.
pub(crate) fn check_ball(ball: &BallParams) -> Result<(), TaskError> {
    check(
        "ball_params",
        &[
            ("mass_kg", ball.mass_kg.into(), MASS),
            ("radius_m", ball.radius_m.into(), ([f64::MIN_POSITIVE, 1.0], "above 0, at most 1 m")),
            ("inertia_factor", ball.inertia_factor.into(), ([f64::MIN_POSITIVE, 1.0], "above 0, at most 1")),
            ("linear_damping", ball.linear_damping.into(), DAMPING),
            ("angular_damping", ball.angular_damping.into(), DAMPING),
        ],
    )?;
    check_material("ball_params.material", &ball.material)
}

/// Checks ground, solver and control period.
pub(crate) fn check_scene(scene: &SceneConfig) -> Result<(), TaskError> {
    let step = ([f64::MIN_POSITIVE, 0.05], "above 0, at most 0.05 s");
    let joint_speed = ([f64::MIN_POSITIVE, 1e4], "above 0, at most 10000 rad/s");
    check(
        "scene",
        &[
            ("physics_dt_s", scene.physics_dt_s.into(), step),
            ("substeps", scene.substeps.into(), COUNT),
            ("gravity", scene.gravity.into(), ([-100.0, 0.0], "-100 to 0 m/s^2")),
            ("bounce_threshold", scene.bounce_threshold.into(), SPEED),
            ("solver_sweeps", scene.solver_sweeps.into(), COUNT),
            ("max_joint_speed", scene.max_joint_speed.into(), joint_speed),
        ],
    )?;
    if let Terrain::Rough { amplitude_m, step_m, cell_m, size, .. } = scene.terrain {
        let height = ([0.0, 10.0], "0 to 10 m");
        check(
            "scene.terrain",
            &[
                ("amplitude_m", amplitude_m.into(), height),
                ("step_m", step_m.into(), height),
                ("cell_m", cell_m.into(), POSITIVE_LENGTH),
                ("size", size.into(), ([2.0, 4096.0], "2 to 4096 grid points")),
            ],
        )?;
    }
    check_material("scene.ground", &scene.ground)
}

#[cfg(test)]
mod tests {
    use toml::Value;

    use crate::TaskPreset;

    /// A task that has every kind of number: a rough ground, a surface, a time of contact.
    fn task() -> TaskPreset {
        let sets = [
            r#"scene.terrain={kind="rough", amplitude_m=0.02, step_m=0.02, cell_m=0.1, size=128, seed=1}"#,
            r#"randomization.surfaces=["hard"]"#,
            "ball.contact_s={kick=1.0}",
        ];
        TaskPreset::builtin_with("paper_stage2", &sets.map(str::to_owned)).expect("valid")
    }

    /// Paths of the numbers below `value`, as `/ball/ahead_m/0`.
    fn numbers(value: &Value, path: &str, found: &mut Vec<String>) {
        match value {
            Value::Table(table) => table.iter().for_each(|(k, v)| numbers(v, &format!("{path}/{k}"), found)),
            Value::Array(items) => {
                items.iter().enumerate().for_each(|(k, v)| numbers(v, &format!("{path}/{k}"), found));
            }
            Value::Float(_) => found.push(path.to_owned()),
            _ => {}
        }
    }

    fn at<'a>(value: &'a mut Value, path: &str) -> &'a mut Value {
        path.split('/').skip(1).fold(value, |value, step| match value {
            Value::Array(items) => &mut items[step.parse::<usize>().expect("an index")],
            table => &mut table[step],
        })
    }

    #[test]
    fn every_number_must_be_finite_and_none_may_be_absurd() {
        let whole = Value::try_from(task()).expect("writes");
        let mut paths = Vec::new();
        numbers(&whole, "", &mut paths);
        assert!(paths.len() > 200, "{} numbers", paths.len());
        for path in &paths {
            // A price may be of any size, and a camera anywhere.
            let free = path.ends_with("/weight") || path.contains("/mount_m/");
            let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e6];
            for value in bad.into_iter().filter(|value| !(free && value.is_finite())) {
                let mut changed = whole.clone();
                *at(&mut changed, path) = Value::Float(value);
                let task: TaskPreset = changed.try_into().expect("a number is a number");
                let error = task.validate().expect_err(&format!("{path} = {value}")).to_string();
                let name = path.rsplit('/').find(|step| step.parse::<usize>().is_err()).expect("a name");
                assert!(error.contains(name) && error.contains("expected"), "{path} = {value}: {error}");
            }
        }
    }

    #[test]
    fn a_number_out_of_its_range_is_refused_by_key() {
        for (set, message) in [
            ("ball.velocity=nan", "ball.velocity is NaN, expected 0 to 100 m/s"),
            ("ball.clearance_m=-3", "ball.clearance_m is -3, expected 0 to 100 m"),
            ("ball.angle_deg=200", "ball.angle_deg is 200, expected 0 to 180 degrees"),
            ("ball.left_m=[-1, nan]", "ball.left_m is [-1.0, NaN], expected [lo, hi] with lo <= hi"),
            ("ball.ahead_m=[0, 200]", "ball.ahead_m is [0.0, 200.0], expected -100 to 100 m"),
            ("goal.distance_m=nan", "goal.distance_m is NaN, expected above 0, at most 100 m"),
            ("goal.width_m=-1", "goal.width_m is -1, expected above 0, at most 100 m"),
            (
                "rewards.kick.contact_force_n=nan",
                "rewards.kick.contact_force_n is NaN, expected 0 to 10000 N",
            ),
            ("rewards.kick.full_ball_speed=-1", "rewards.kick.full_ball_speed is -1, expected 0 to 100 m/s"),
            (
                "rewards.kick.window_steps=20000",
                "rewards.kick.window_steps is 20000, expected 0 to 10000 steps",
            ),
            ("resets.joint_rad=nan", "resets.joint_rad is NaN, expected 0 to 3.15 rad"),
            ("resets.velocity.yaw=-1", "resets.velocity.yaw is -1, expected 0 to 100 rad/s"),
            ("sampling.stop_after_kick_s=nan", "sampling.stop_after_kick_s is NaN, expected 0 to 60 s"),
            ("sampling.latest_start_before_strike_s=nan", "strike_s is NaN, expected -3600 to 3600 s"),
            ("sampling.miss_sampling_weight=-1", "miss_sampling_weight is -1, expected 0 to 1000"),
            ("sampling.kernel_size=0", "sampling.kernel_size is 0, expected at least 1, at most 1000"),
            ("sampling.kernel_ratio=2", "sampling.kernel_ratio is 2, expected a share between 0 and 1"),
            ("scene.substeps=0", "scene.substeps is 0, expected at least 1, at most 1000"),
            ("scene.gravity=9.81", "scene.gravity is 9.81, expected -100 to 0 m/s^2"),
            ("scene.ground.restitution=1.5", "scene.ground.restitution is 1.5, expected a share"),
            ("ball_params.material.restitution=5", "ball_params.material.restitution is 5, expected a share"),
            ("robot_material.dynamic_friction=-1", "robot_material.dynamic_friction is -1, expected 0 to 10"),
            ("randomization.ball_restitution=[-1, 5]", "ball_restitution is [-1.0, 5.0], expected a share"),
            (
                "randomization.ball_static_friction=[-1, 1]",
                "ball_static_friction is [-1.0, 1.0], expected 0 to 10",
            ),
            (
                "randomization.ball_linear_damping=[-5, -1]",
                "ball_linear_damping is [-5.0, -1.0], expected 0 to 100 1/s",
            ),
            ("randomization.base_com_x_m=[-2, 0]", "base_com_x_m is [-2.0, 0.0], expected -1 to 1 m"),
        ] {
            let error =
                TaskPreset::builtin_with("paper_stage2", &[set.to_owned()]).expect_err(set).to_string();
            assert!(error.contains(message), "{set}: {error}");
        }
    }
}
