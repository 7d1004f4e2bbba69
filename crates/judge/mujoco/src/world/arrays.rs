//! The arrays of a world's model and state.

use std::ffi::c_int;

use super::{World, read};
use crate::layout::{data, model};

/// Functions that give an array of `mjtNum` as a slice, and some of them as a writable one.
macro_rules! slices {
    ($($(#[$doc:meta])* $get:ident $(, $get_mut:ident)?: $home:ident $offset:path, |$world:ident| $len:expr;)*) => {
        $(
            $(#[$doc])*
            pub fn $get(&self) -> &[f64] {
                let $world = self;
                // SAFETY: the offset is that of an array of this many `mjtNum`, owned by self for its whole life.
                unsafe { std::slice::from_raw_parts(read(self.$home, $offset), $len) }
            }
            $(
                /// The same, writable.
                pub fn $get_mut(&mut self) -> &mut [f64] {
                    let $world = &*self;
                    // SAFETY: as for reading; the exclusive borrow keeps every other access out.
                    unsafe { std::slice::from_raw_parts_mut(read(self.$home, $offset), $len) }
                }
            )?
        )*
    };
}

impl World {
    slices! {
        /// Body masses `[nbody]`, kg.
        body_mass, body_mass_mut: model model::BODY_MASS, |w| w.nbody();
        /// Principal inertias [nbody * 3], kg m^2.
        body_inertia, body_inertia_mut: model model::BODY_INERTIA, |w| w.nbody() * 3;
        /// Body origins in the frames of their parents [nbody * 3], m.
        body_pos, body_pos_mut: model model::BODY_POS, |w| w.nbody() * 3;
        /// Centers of mass in body frames [nbody * 3], m.
        body_ipos, body_ipos_mut: model model::BODY_IPOS, |w| w.nbody() * 3;
        /// Passive damping of the velocity coordinates `[nv]`.
        dof_damping, dof_damping_mut: model model::DOF_DAMPING, |w| w.nv();
        /// Geom sizes [ngeom * 3], m.
        geom_size, geom_size_mut: model model::GEOM_SIZE, |w| w.ngeom() * 3;
        /// Sliding, torsional and rolling friction [ngeom * 3].
        geom_friction, geom_friction_mut: model model::GEOM_FRICTION, |w| w.ngeom() * 3;
        /// Time constant and damping ratio of contacts [ngeom * 2].
        geom_solref, geom_solref_mut: model model::GEOM_SOLREF, |w| w.ngeom() * 2;
        /// Gain parameters of the actuators `[nu * 10]`; the first is the stiffness of a position actuator.
        actuator_gainprm, actuator_gainprm_mut: model model::ACTUATOR_GAINPRM, |w| w.nu() * model::ACTUATOR_PARAMETERS;
        /// Bias parameters of the actuators `[nu * 10]`; of a position actuator 0, -stiffness, -damping.
        actuator_biasprm, actuator_biasprm_mut: model model::ACTUATOR_BIASPRM, |w| w.nu() * model::ACTUATOR_PARAMETERS;
        /// Positions `[nq]`.
        qpos, qpos_mut: data data::QPOS, |w| w.nq();
        /// Velocities `[nv]`.
        qvel, qvel_mut: data data::QVEL, |w| w.nv();
        /// Controls `[nu]`.
        ctrl, ctrl_mut: data data::CTRL, |w| w.nu();
        /// Start of the next solve `[nv]`.
        qacc_warmstart, qacc_warmstart_mut: data data::QACC_WARMSTART, |w| w.nv();
        /// Accelerations of the last forward computation `[nv]`.
        qacc: data data::QACC, |w| w.nv();
        /// Forces of the actuators in the last step `[nu]`.
        actuator_force: data data::ACTUATOR_FORCE, |w| w.nu();
        /// Accelerations without constraints (contact, limits, friction loss) `[nv]`.
        qacc_smooth: data data::QACC_SMOOTH, |w| w.nv();
        /// Bias forces: gravity, Coriolis, centrifugal `[nv]`.
        qfrc_bias: data data::QFRC_BIAS, |w| w.nv();
        /// Body origins in the world [nbody * 3], m.
        xpos: data data::XPOS, |w| w.nbody() * 3;
        /// Body frames in the world, row-major [nbody * 9].
        xmat: data data::XMAT, |w| w.nbody() * 9;
        /// Centers of mass in the world [nbody * 3], m.
        xipos: data data::XIPOS, |w| w.nbody() * 3;
    }

    /// Body of a geom.
    pub fn geom_body(&self, geom: usize) -> usize {
        assert!(geom < self.ngeom(), "geom {geom} of {}", self.ngeom());
        // SAFETY: the array has `ngeom` entries of type int, none negative.
        unsafe { read::<*const c_int>(self.model, model::GEOM_BODYID).add(geom).read() as usize }
    }
}
