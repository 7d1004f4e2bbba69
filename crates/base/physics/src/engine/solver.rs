//! The solver's constants: what is no property of a robot, a ball or a scene.

/// Constants of contacts, joint stops and joint friction.
///
/// The values are tuned for humanoids of 20 to 60 kg at steps of 2 to 5 ms. They are fixed when the engine is compiled;
/// what a user may choose is in [`SceneConfig`](crate::SceneConfig).
///
/// ```
/// use paid_physics::SolverConstants;
///
/// let solver = SolverConstants::DEFAULT;
/// // A resting sole keeps its contact: the overlap that stays is inside the distance at which it is checked.
/// assert!(solver.sole_slop_m < solver.sole_reach_m);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverConstants {
    /// Factor on the inverse mass of every contact: it bounds the inverse of a nearly singular one.
    pub inverse_mass_factor: f64,
    /// Share of an overlap that one step removes. All at once would throw the bodies apart.
    pub overlap_correction: f64,

    /// Gap above which a sole point is left out `[m]`. A foot at 4 m/s travels as far in a 5 ms step.
    pub sole_reach_m: f64,
    /// Overlap of a sole that stays `[m]`: it keeps resting contacts closed.
    pub sole_slop_m: f64,
    /// Fastest correction of a sole's overlap `[m/s]`: 2.5 mm in a 5 ms step.
    pub sole_max_push: f64,

    /// Gap up to which soft soles are in touch `[m]`: a resting foot rocks by less.
    pub sole_soft_reach_m: f64,

    /// Gap up to which a soft ball is in touch `[m]`: a ball that rests or rolls hovers by less.
    pub ball_soft_reach_m: f64,
    /// Gap above which no contact of ball and robot is looked for `[m]`. Nothing moves faster than 50 m/s for long, which is
    /// 0.25 m in a 5 ms step.
    pub ball_horizon_m: f64,
    /// A contact of ball and robot is prepared if the gap closes to this within the step `[m]`: room for the
    /// 2 m/s that a 5 ms step itself may add.
    pub ball_margin_m: f64,
    /// Overlap of the ball that stays `[m]`: none, so that a ball at rest lies at its radius.
    pub ball_slop_m: f64,
    /// Fastest correction of the ball's overlap `[m/s]`: 1 cm in a 5 ms step, four times a sole's, for
    /// a foot drives deep into the ball.
    pub ball_max_push: f64,

    /// Gap above which two limbs are not checked `[m]`: 20 m/s in a 5 ms step.
    pub limb_horizon_m: f64,
    /// A contact of two limbs is prepared if the gap closes to this within the step `[m]`: room for 1 m/s.
    pub limb_margin_m: f64,
    /// Overlap of two limbs that stays `[m]`, as at the soles.
    pub limb_slop_m: f64,
    /// Fastest correction of two limbs' overlap `[m/s]`: motion references overlap by up to 3 cm, which must not kick.
    pub limb_max_push: f64,

    /// Stiffness of the ground under a body other than a foot `[N/m]`: a 33 kg robot that lies on four points sinks 4 mm.
    pub body_ground_stiffness: f64,
    /// Damping of that ground `[N s/m]`: near critical for the 5 to 10 kg that a point carries.
    pub body_ground_damping: f64,
    /// Bound on the viscosity that stands for that ground's friction at low speed `[N s/m]`. What lies on a
    /// slope creeps: 10 N across move a point at 2 cm/s.
    pub body_ground_max_viscosity: f64,
    /// Sliding speed below which that friction is viscous `[m/s]`.
    pub body_ground_slide_speed: f64,

    /// Stiffness of a joint stop `[N m/rad]`: 1 mrad of overrun per 5 N m. Stiff against actuators of 50 to 139 N m, soft
    /// enough for a 5 ms step.
    pub joint_stop_stiffness: f64,
    /// Damping of a joint stop `[N m s/rad]`: it takes the speed out of a hit.
    pub joint_stop_damping: f64,
    /// Joint speed below which dry friction turns viscous `[rad/s]`: a torque that jumps at rest would let
    /// the joint chatter.
    pub joint_friction_speed: f64,
}

impl SolverConstants {
    /// The engine's values.
    pub const DEFAULT: Self = Self {
        inverse_mass_factor: 1.001,
        overlap_correction: 0.2,
        sole_reach_m: 0.02,
        sole_slop_m: 0.001,
        sole_max_push: 0.5,
        sole_soft_reach_m: 0.001,
        ball_soft_reach_m: 0.0002,
        ball_horizon_m: 0.25,
        ball_margin_m: 0.01,
        ball_slop_m: 0.0,
        ball_max_push: 2.0,
        limb_horizon_m: 0.1,
        limb_margin_m: 0.005,
        limb_slop_m: 0.001,
        limb_max_push: 0.5,
        body_ground_stiffness: 2.0e4,
        body_ground_damping: 400.0,
        body_ground_max_viscosity: 500.0,
        body_ground_slide_speed: 0.01,
        joint_stop_stiffness: 5000.0,
        joint_stop_damping: 20.0,
        joint_friction_speed: 0.1,
    };
}

/// The values as the inner loops read them; a constant, so that they are folded into the code.
pub(crate) const SOLVER: SolverConstants = SolverConstants::DEFAULT;
