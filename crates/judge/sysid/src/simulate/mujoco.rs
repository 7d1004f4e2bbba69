//! The experiments with MuJoCo's ball, whose contact is another one: a spring and damper, and a rolling friction.

use paid_mujoco::{BallOptions, World};

use crate::SysidError;

/// Physics step `[s]`; short, so that the stiff contact is resolved.
const STEP_S: f64 = 0.0005;
/// Coordinates of a free joint: position, then orientation.
const FREE_NQ: usize = 7;

/// A ball on a plane in MuJoCo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MujocoBall {
    /// Mass, radius, inertia, friction, contact impedance; `damped` adds the parameters' linear and angular damping.
    pub options: BallOptions,
}

impl Default for MujocoBall {
    /// The ball of PAiD's public evaluation with a contact that bounces: a damping ratio of 0.15 returns about 0.6 of the
    /// approach speed, as turf does; and with a rolling friction of 1 cm, about 0.5 m/s^2.
    fn default() -> Self {
        let known = BallOptions::default();
        let [sliding, torsional, _] = known.friction;
        Self { options: BallOptions { solref: [0.02, 0.15], friction: [sliding, torsional, 0.01], ..known } }
    }
}

fn words(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

impl MujocoBall {
    fn mjcf(&self) -> String {
        let (o, p) = (&self.options, &self.options.params);
        let (mass, radius) = (p.mass_kg, p.radius_m);
        let inertia = p.inertia_factor * mass * radius * radius;
        let contact = format!(
            r#"condim="6" friction="{}" solref="{}" solimp="{}""#,
            words(&o.friction),
            words(&o.solref),
            words(&o.solimp)
        );
        format!(
            r#"<mujoco><option timestep="{STEP_S}" gravity="0 0 -9.81" cone="elliptic" integrator="implicitfast"/>
<worldbody><geom name="floor" type="plane" size="0 0 1"/>
<body name="ball" pos="0 0 {radius}"><freejoint name="ball"/>
<inertial pos="0 0 0" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
<geom name="ball" type="sphere" size="{radius}" priority="1" {contact}/></body></worldbody></mujoco>"#
        )
    }

    /// Follows the ball from a height of its lowest point `[m]`, a speed along x `[m/s]` and a turning about y `[rad/s]`; returns x
    /// and the lowest point's height at `times`.
    fn follow(&self, start: [f64; 3], times: &[f64]) -> Result<Vec<[f64; 2]>, SysidError> {
        let [height, speed, turning] = start;
        let p = &self.options.params;
        let mut world = World::from_xml(&self.mjcf()).map_err(|e| SysidError::Mujoco(e.to_string()))?;
        let qpos = world.qpos_mut();
        debug_assert_eq!(qpos.len(), FREE_NQ);
        qpos[2] = p.radius_m + height;
        let qvel = world.qvel_mut();
        (qvel[0], qvel[4]) = (speed, turning);
        let mut last = [0.0, height];
        let mut before = last;
        let (mut steps, mut out) = (0_u64, Vec::with_capacity(times.len()));
        for &t in times {
            while (steps as f64) * STEP_S < t - 1e-9 {
                if self.options.damped {
                    for (i, v) in world.qvel_mut().iter_mut().enumerate() {
                        let rate = if i < 3 { p.linear_damping } else { p.angular_damping };
                        *v *= 1.0 - rate * STEP_S;
                    }
                }
                world.step();
                steps += 1;
                let q = world.qpos();
                before = last;
                last = [q[0], q[2] - p.radius_m];
            }
            // A frame between two steps shows what lies between them.
            let early = ((steps as f64) * STEP_S - t) / STEP_S;
            let share = if early > 1e-5 { early } else { 0.0 };
            out.push([0, 1].map(|k| last[k] + share * (before[k] - last[k])));
        }
        if out.as_flattened().iter().all(|x| x.is_finite()) {
            return Ok(out);
        }
        Err(SysidError::option("MuJoCo's ball", "a stable contact", "a state that is not finite"))
    }

    /// Heights of the lowest point `[m]` after a release at `height`.
    pub(crate) fn drop(&self, height: f64, times: &[f64]) -> Result<Vec<f64>, SysidError> {
        Ok(self.follow([height, 0.0, 0.0], times)?.iter().map(|p| p[1]).collect())
    }

    /// Distances `[m]` of a ball that begins at `speed` `[m/s]`, `spin` times rolling.
    pub(crate) fn roll(&self, speed: f64, spin: f64, times: &[f64]) -> Result<Vec<f64>, SysidError> {
        let turning = spin * speed / self.options.params.radius_m;
        Ok(self.follow([0.0, speed, turning], times)?.iter().map(|p| p[0]).collect())
    }
}

#[cfg(test)]
mod tests {
    use paid_mujoco::Library;

    use super::*;

    #[test]
    fn mujocos_ball_falls_bounces_and_rolls_on() {
        if paid_testing::mujoco("mujocos_ball_falls_bounces_and_rolls_on", Library::get()).is_none() {
            return;
        }
        let times: Vec<f64> = (0..=40).map(|i| 0.05 * f64::from(i)).collect();
        let ball = MujocoBall::default();
        let heights = ball.drop(2.0, &times).expect("runs");
        let fall = 2.0 - 0.5 * 9.81 * 0.25;
        assert!((heights[10] - fall).abs() < 0.01, "{}", heights[10]);
        let rebound = heights[14..].iter().copied().fold(0.0, f64::max);
        assert!((0.4..1.2).contains(&rebound), "{rebound}");
        // A camera's frame in the middle between two steps.
        let frames = ball.drop(2.0, &[0.0, 0.1, 0.10025, 0.1005]).expect("runs");
        assert!((frames[2] - 0.5 * (frames[1] + frames[3])).abs() < 1e-9, "{frames:?}");
        let distances = ball.roll(2.0, 1.0, &times).expect("runs");
        // Constant deceleration by the rolling friction: mu g / (r (1 + k)).
        let slowing = 0.01 / 0.11 * 9.81 / (1.0 + 2.0 / 3.0);
        let exact = 2.0 * 2.0 - 0.5 * slowing * 4.0;
        assert!((distances[40] - exact).abs() < 0.1, "{} of {exact}", distances[40]);
    }
}
