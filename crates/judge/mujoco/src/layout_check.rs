//! Whether the fields of the library lie where [`crate::layout`] says.

use crate::library::Library;
use crate::world::World;

impl World {
    /// Compares values that are known for a small scene with what the offsets in [`crate::layout`] give.
    pub(crate) fn check_layout(library: &'static Library) -> Result<(), String> {
        const SCENE: &str = r#"<mujoco><option timestep="0.003"/><worldbody>
            <geom name="floor" type="plane" size="1 1 1" friction="0.7 0.06 0.005" solref="0.03 0.9"/>
            <body name="b" pos="0.2 0.3 0.09"><joint name="j" type="free" damping="0.4"/>
            <inertial pos="0 0 0.001" mass="2" diaginertia="0.03 0.02 0.01"/><geom name="s" size="0.1"/></body>
            </worldbody><actuator><position joint="j" gear="1 0 0 0 0 0" kp="50" kv="3"/></actuator></mujoco>"#;
        let mut w = Self::compile(library, SCENE).map_err(|e| e.to_string())?;
        let same = |name: &str, found: &[f64], expected: &[f64]| {
            let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-9;
            if found.len() == expected.len() && found.iter().zip(expected).all(close) {
                Ok(())
            } else {
                Err(format!("{name}: expected {expected:?}, found {found:?}"))
            }
        };
        let counts = [w.nq(), w.nv(), w.nu(), w.nbody(), w.ngeom()].map(|n| n as f64);
        same("counts", &counts, &[7.0, 6.0, 1.0, 2.0, 2.0])?;
        same("gain", &w.actuator_gainprm()[..1], &[50.0])?;
        same("actuator's bias", &w.actuator_biasprm()[..3], &[0.0, -50.0, -3.0])?;
        // A free joint's actuator sees no position.
        w.ctrl_mut()[0] = 0.1;
        w.forward();
        same("timestep", &[w.timestep(), w.time()], &[0.003, 0.0])?;
        same("masses", w.body_mass(), &[0.0, 2.0])?;
        same("inertias", &w.body_inertia()[3..], &[0.03, 0.02, 0.01])?;
        same("center of mass", &w.body_ipos()[3..], &[0.0, 0.0, 0.001])?;
        same("place", &w.body_pos()[3..], &[0.2, 0.3, 0.09])?;
        same("damping", w.dof_damping(), &[0.4; 6])?;
        same("size", &w.geom_size()[3..4], &[0.1])?;
        same("friction", &w.geom_friction()[..3], &[0.7, 0.06, 0.005])?;
        same("solref", &w.geom_solref()[..2], &[0.03, 0.9])?;
        same("geom's body", &[w.geom_body(0) as f64, w.geom_body(1) as f64], &[0.0, 1.0])?;
        same("position", &w.qpos()[..3], &[0.2, 0.3, 0.09])?;
        same("origin", &w.xpos()[3..], &[0.2, 0.3, 0.09])?;
        same("frame", &w.xmat()[9..], &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])?;
        same("center", &w.xipos()[3..], &[0.2, 0.3, 0.091])?;
        same("bias", &w.qfrc_bias()[..3], &[0.0, 0.0, 2.0 * 9.81])?;
        same("free acceleration", &w.qacc_smooth()[2..3], &[-9.81])?;
        same("contacts", &[w.contact_count() as f64], &[1.0])?;
        let contact = w.contact(0);
        same(
            "contact",
            &[contact.geoms[0] as f64, contact.geoms[1] as f64, contact.dist],
            &[0.0, 1.0, -0.01],
        )?;
        same("contact point", &contact.pos, &[0.2, 0.3, -0.005])?;
        same("normal", &contact.frame[0], &[0.0, 0.0, 1.0])?;
        // Newton's law ties acceleration and contact force together.
        let (force, acceleration) = (w.contact_force(0), w.qacc());
        same("actuator's force", w.actuator_force(), &[5.0])?;
        same("balance", &[2.0 * acceleration[2]], &[force[2] - 2.0 * 9.81])?;
        if force[0] >= 0.0 {
            return Err(format!("friction against the control: expected below 0, found {}", force[0]));
        }
        w.step();
        let moved = w.qpos()[2] - 0.09 - 0.003 * w.qvel()[2];
        same("step", &[w.time(), moved], &[0.003, 0.0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Library;

    #[test]
    fn the_library_has_the_expected_layout() {
        let Some(library) = paid_testing::mujoco("the_library_has_the_expected_layout", Library::get())
        else {
            return;
        };
        assert_eq!(World::check_layout(library), Ok(()));
    }
}
