//! Where MuJoCo 3.17.0 keeps the fields that are read and written directly.
//!
//! Byte offsets in `mjModel`, `mjData`, `mjContact` and `mjLogMessage`, as `offsetof` gives them for the headers of 3.17.0 on
//! platforms with 64-bit pointers and 8-byte alignment of `double` (x86-64 and ARM64; Linux, macOS, Windows). The structures are
//! plain C, so these hold for every build of that version; [`super::library`] refuses other versions and compares
//! known values read through these offsets when it opens the library.

/// `mjModel`: counts are `int64_t`, arrays are pointers.
pub(crate) mod model {
    pub const NQ: usize = 0;
    pub const NV: usize = 8;
    pub const NU: usize = 16;
    pub const NBODY: usize = 48;
    pub const NGEOM: usize = 136;
    pub const TIMESTEP: usize = 792;
    pub const BODY_POS: usize = 1912;
    pub const BODY_IPOS: usize = 1928;
    pub const BODY_MASS: usize = 1944;
    pub const BODY_INERTIA: usize = 1960;
    pub const DOF_DAMPING: usize = 2336;
    pub const GEOM_BODYID: usize = 2448;
    pub const GEOM_SOLREF: usize = 2512;
    pub const GEOM_SIZE: usize = 2528;
    pub const GEOM_FRICTION: usize = 2568;
    pub const ACTUATOR_GAINPRM: usize = 4856;
    pub const ACTUATOR_BIASPRM: usize = 4864;
    /// Numbers an actuator in each of the two.
    pub const ACTUATOR_PARAMETERS: usize = 10;
}

/// `mjData`: counts are `int`, arrays are pointers.
pub(crate) mod data {
    pub const NCON: usize = 160_560;
    pub const TIME: usize = 160_648;
    pub const QPOS: usize = 160_688;
    pub const QVEL: usize = 160_696;
    pub const QACC_WARMSTART: usize = 160_720;
    pub const CTRL: usize = 160_736;
    pub const QACC: usize = 160_784;
    pub const XPOS: usize = 160_840;
    pub const XMAT: usize = 160_856;
    pub const XIPOS: usize = 160_864;
    pub const QFRC_BIAS: usize = 161_296;
    pub const ACTUATOR_FORCE: usize = 161_400;
    pub const QACC_SMOOTH: usize = 161_424;
    pub const CONTACT: usize = 161_472;
}

/// `mjContact`.
pub(crate) mod contact {
    pub const SIZE: usize = 584;
    pub const DIST: usize = 0;
    pub const POS: usize = 8;
    pub const FRAME: usize = 32;
    pub const GEOM: usize = 540;
}

/// `mjLogMessage`.
pub(crate) mod log_message {
    pub const LEVEL: usize = 0;
    pub const SUBJECT: usize = 8;
    pub const SUBJECT_SIZE: usize = 1024;
    /// Value of `level` for warnings; errors are above.
    pub const WARNING: i32 = 2;
}
