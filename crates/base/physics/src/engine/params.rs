//! Physical parameters, one value per lane.

use paid_lanes::{Real, Vec3};

use super::block::Friction;
use super::cone::ConeLanes;
use super::spring::SpringLanes;
use crate::{BallParams, Cone, ContactKind, EnvParams, Material, MotorScale, SceneConfig, SoleShape};

/// Coefficients of a contact between two surfaces, one value per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactLanes<V> {
    pub static_friction: V,
    pub dynamic_friction: V,
    pub restitution: V,
}

impl<V: Real> ContactLanes<V> {
    /// Coulomb friction of a contact of one point.
    #[inline(always)]
    pub fn friction(&self) -> Friction<V> {
        Friction { stick: self.static_friction, slide: self.dynamic_friction }
    }
    fn new(m: Material) -> Self {
        Self {
            static_friction: V::c(m.static_friction),
            dynamic_friction: V::c(m.dynamic_friction),
            restitution: V::c(m.restitution),
        }
    }
    fn set_lane(&mut self, lane: usize, m: Material) {
        self.static_friction.set_lane(lane, m.static_friction);
        self.dynamic_friction.set_lane(lane, m.dynamic_friction);
        self.restitution.set_lane(lane, m.restitution);
    }
}

/// Ball constants, one value per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BallLanes<V> {
    pub radius: V,
    pub inv_mass: V,
    pub inv_inertia: V,
    /// Velocity factors of a physics step.
    pub linear_keep: V,
    pub angular_keep: V,
}

/// Changes of the soles' shape, one value per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoleLanes<V> {
    /// Scales less 1.
    pub length: V,
    pub width: V,
    pub rounding: V,
}

/// A joint's [`MotorScale`], one value per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotorLanes<V> {
    pub armature: V,
    pub stiffness: V,
    pub damping: V,
    pub effort: V,
    pub friction: V,
}

impl<V: Real> MotorLanes<V> {
    fn one() -> Self {
        let one = V::one();
        Self { armature: one, stiffness: one, damping: one, effort: one, friction: one }
    }
    fn set_lane(&mut self, lane: usize, motor: MotorScale) {
        self.armature.set_lane(lane, motor.armature);
        self.stiffness.set_lane(lane, motor.stiffness);
        self.damping.set_lane(lane, motor.damping);
        self.effort.set_lane(lane, motor.effort);
        self.friction.set_lane(lane, motor.friction);
    }
}

/// [`EnvParams`] of a group, prepared for stepping.
#[derive(Clone, Debug)]
pub(crate) struct GroupParams<V> {
    pub lanes: Vec<EnvParams>,
    pub base_com_offset: Vec3<V>,
    /// Per body; `None` while every lane has the model's masses.
    pub mass_scale: Option<Vec<V>>,
    pub gain_scale: [V; 2],
    /// Per joint; `None` while every lane has the model's motors.
    pub motor_scale: Option<Vec<MotorLanes<V>>>,
    pub terrain_offset: [V; 2],
    pub ball: BallLanes<V>,
    /// The robot's surface against itself.
    pub robot: ContactLanes<V>,
    pub robot_ground: ContactLanes<V>,
    pub ball_ground: ContactLanes<V>,
    pub ball_robot: ContactLanes<V>,
    pub sole_spring: SpringLanes<V>,
    pub ball_ground_spring: SpringLanes<V>,
    pub ball_robot_spring: SpringLanes<V>,
    /// Torsional and rolling friction of the ball; `None` while no lane has any.
    pub spin_friction: Option<[V; 2]>,
    /// Kinds of the ball's friction cone; `None` while every lane has the usual one and no friction of spin.
    pub cone: Option<ConeLanes<V>>,
    /// `None` while every lane has the model's soles.
    pub sole_shape: Option<SoleLanes<V>>,
    /// Between capsule (0) and plate (1); `None` while every lane has the model's feet.
    pub foot_flatness: Option<V>,
    pub pd_implicitness: V,
}

impl<V: Real> GroupParams<V> {
    pub fn new(scene: &SceneConfig, bodies: usize) -> Self {
        let zero = Material { static_friction: 0.0, dynamic_friction: 0.0, restitution: 0.0 };
        let z = V::zero();
        let ball = BallLanes {
            radius: V::one(),
            inv_mass: V::one(),
            inv_inertia: V::one(),
            linear_keep: V::one(),
            angular_keep: V::one(),
        };
        let mut params = Self {
            lanes: vec![EnvParams::default(); V::LANES],
            base_com_offset: Vec3::zero(),
            mass_scale: None,
            gain_scale: [V::one(); 2],
            motor_scale: None,
            terrain_offset: [z; 2],
            ball,
            robot: ContactLanes::new(zero),
            robot_ground: ContactLanes::new(zero),
            ball_ground: ContactLanes::new(zero),
            ball_robot: ContactLanes::new(zero),
            sole_spring: SpringLanes::hard(),
            ball_ground_spring: SpringLanes::hard(),
            ball_robot_spring: SpringLanes::hard(),
            spin_friction: None,
            cone: None,
            sole_shape: None,
            foot_flatness: None,
            pd_implicitness: V::one(),
        };
        for lane in 0..V::LANES {
            params.set_lane(lane, &EnvParams::default(), scene, bodies);
        }
        params
    }

    fn set_ball(&mut self, lane: usize, b: &BallParams, dt: f64) {
        let ball = &mut self.ball;
        ball.radius.set_lane(lane, b.radius_m);
        ball.inv_mass.set_lane(lane, 1.0 / b.mass_kg);
        ball.inv_inertia.set_lane(lane, 1.0 / (b.inertia_factor * b.mass_kg * b.radius_m * b.radius_m));
        ball.linear_keep.set_lane(lane, (1.0 - b.linear_damping * dt).max(0.0));
        ball.angular_keep.set_lane(lane, (1.0 - b.angular_damping * dt).max(0.0));
    }

    /// Sets the parameters of one lane. `mass_scale` must be empty or have one value per body, `motor_scale` one per joint.
    pub fn set_lane(&mut self, lane: usize, p: &EnvParams, scene: &SceneConfig, bodies: usize) {
        assert!(
            p.mass_scale.is_empty() || p.mass_scale.len() == bodies,
            "mass_scale: expected 0 or {bodies} values, found {}",
            p.mass_scale.len()
        );
        let joints = bodies - 1;
        assert!(
            p.motor_scale.is_empty() || p.motor_scale.len() == joints,
            "motor_scale: expected 0 or {joints} values, found {}",
            p.motor_scale.len()
        );
        self.base_com_offset.set_lane(lane, p.base_com_offset);
        for k in 0..2 {
            self.gain_scale[k].set_lane(lane, p.gain_scale[k]);
            self.terrain_offset[k].set_lane(lane, p.terrain_offset[k]);
        }
        if !p.mass_scale.is_empty() || self.mass_scale.is_some() {
            let scale = self.mass_scale.get_or_insert_with(|| vec![V::one(); bodies]);
            for (b, s) in scale.iter_mut().enumerate() {
                s.set_lane(lane, p.mass_scale.get(b).copied().unwrap_or(1.0));
            }
        }
        if !p.motor_scale.is_empty() || self.motor_scale.is_some() {
            let motors = self.motor_scale.get_or_insert_with(|| vec![MotorLanes::one(); joints]);
            for (j, motor) in motors.iter_mut().enumerate() {
                motor.set_lane(lane, p.motor_scale.get(j).copied().unwrap_or(MotorScale::ONE));
            }
        }
        self.set_ball(lane, &p.ball, scene.physics_dt_s);
        self.robot.set_lane(lane, SceneConfig::contact_of_robot_and_itself(p.robot));
        self.robot_ground.set_lane(lane, scene.contact_with_ground(p.robot));
        self.ball_ground.set_lane(lane, scene.contact_with_ground(p.ball.material));
        self.ball_robot.set_lane(lane, SceneConfig::contact_of_ball_and_robot(p.ball.material, p.robot));
        self.lanes[lane] = p.clone();
        self.set_kind(lane, &p.kind);
    }

    /// Sets the kind of one lane; what no lane uses costs nothing in the step. `lanes` must be up to date.
    fn set_kind(&mut self, lane: usize, kind: &ContactKind) {
        let compliance = &kind.compliance;
        self.sole_spring.set_lane(lane, &compliance.sole_ground);
        self.ball_ground_spring.set_lane(lane, &compliance.ball_ground);
        self.ball_robot_spring.set_lane(lane, &compliance.ball_robot);
        let any = |what: fn(&ContactKind) -> bool| self.lanes.iter().any(|p| what(&p.kind));
        self.sole_spring.any = any(|k| k.compliance.sole_ground.is_soft());
        self.ball_ground_spring.any = any(|k| k.compliance.ball_ground.is_soft());
        self.ball_robot_spring.any = any(|k| k.compliance.ball_robot.is_soft());
        let kinds = |of: fn(&ContactKind) -> f64| {
            let mut lanes = V::zero();
            for (i, p) in self.lanes.iter().enumerate() {
                lanes.set_lane(i, of(&p.kind));
            }
            lanes
        };
        self.spin_friction = any(|k| k.ball_spin_friction_m != [0.0; 2])
            .then(|| [kinds(|k| k.ball_spin_friction_m[0]), kinds(|k| k.ball_spin_friction_m[1])]);
        let usual = |k: &ContactKind| k.cone == Cone::default() && k.ball_spin_friction_m == [0.0; 2];
        self.cone = self.lanes.iter().any(|p| !usual(&p.kind)).then(|| ConeLanes {
            pyramid: kinds(|k| if k.cone.pyramid { 1.0 } else { 0.0 }),
            convex: kinds(|k| if k.cone.convex { 1.0 } else { 0.0 }),
        });
        self.sole_shape = any(|k| k.sole != SoleShape::default()).then(|| SoleLanes {
            length: kinds(|k| k.sole.length_scale - 1.0),
            width: kinds(|k| k.sole.width_scale - 1.0),
            rounding: kinds(|k| k.sole.rounding_m),
        });
        self.foot_flatness = any(|k| k.foot_flatness != 0.0).then(|| kinds(|k| k.foot_flatness));
        self.pd_implicitness.set_lane(lane, kind.pd_implicitness);
    }
}
