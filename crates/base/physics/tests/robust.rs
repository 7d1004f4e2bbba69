//! Repeatability, isolation of lanes, save and restore, survival.

use crate::common::{biped, lane_at, reset_all, stance};
use paid_lanes::rng::Rng;
use paid_lanes::{F32Array, Isa, IsaVisitor, Real};
use paid_physics::{
    Engine, EnvParams, LaneState, LateTargets, Material, MotorScale, SceneConfig, Simulator, Terrain,
};

type V = F32Array<8>;

/// Rough ground, ball near, everything on.
fn scene() -> SceneConfig {
    SceneConfig {
        terrain: Terrain::Rough { amplitude_m: 0.02, step_m: 0.02, cell_m: 0.1, size: 32, seed: 3 },
        ..SceneConfig::default()
    }
}

fn start(model: &paid_robot::RobotModel, env: u32) -> LaneState {
    let mut rng = Rng::new(11, env, 0);
    let mut s = lane_at(model.joints.len(), 0.8);
    s.joint_pos = stance(model);
    s.base_ang_vel = [0.0, 0.0, rng.uniform(-0.5, 0.5)];
    s.ball_pos = [rng.uniform(0.2, 0.6), rng.uniform(-0.2, 0.2), 0.13];
    s.ball_vel = [rng.uniform(-2.0, 0.0), 0.0, 0.0];
    s
}

/// Different parameters in every environment.
fn params(env: u32) -> EnvParams {
    let mut rng = Rng::new(12, env, 0);
    let mut p = EnvParams { mass_scale: vec![1.0; biped().0.bodies.len()], ..EnvParams::default() };
    p.mass_scale[0] = rng.uniform(0.9, 1.1);
    p.base_com_offset = [rng.uniform(-0.02, 0.02), 0.0, 0.0];
    p.gain_scale = [rng.uniform(0.9, 1.1), rng.uniform(0.9, 1.1)];
    if env % 2 == 1 {
        p.motor_scale =
            vec![
                MotorScale { armature: 2.0, stiffness: 1.5, damping: 0.5, effort: 0.7, friction: 5.0 };
                biped().0.joints.len()
            ];
    }
    p.robot = Material { static_friction: rng.uniform(0.4, 1.2), dynamic_friction: 0.4, restitution: 0.1 };
    p.terrain_offset = [rng.uniform(0.0, 3.0), rng.uniform(0.0, 3.0)];
    p
}

fn targets(model: &paid_robot::RobotModel, env: u32, step: u64) -> Vec<f64> {
    let mut rng = Rng::new(13, env, 0);
    rng.seek(step * 64);
    stance(model).iter().map(|q| q + rng.uniform(-0.4, 0.4)).collect()
}

/// Runs the environments `envs` as the lanes of one group.
fn run(envs: &[u32], steps: std::ops::Range<u64>, from: Option<&[LaneState]>) -> Engine<V> {
    let (model, spec) = biped();
    let mut engine = Engine::<V>::new(&model, spec, &scene(), 1).unwrap();
    for (lane, &env) in envs.iter().enumerate() {
        engine.set_params(0, lane, &params(env));
        let state = from.map_or_else(|| start(&model, env), |f| f[lane].clone());
        engine.reset_lane(0, lane, &state);
    }
    engine.refresh(0);
    for step in steps {
        let mut batch = vec![V::zero(); model.joints.len()];
        for (lane, &env) in envs.iter().enumerate() {
            for (x, t) in batch.iter_mut().zip(targets(&model, env, step)) {
                x.set_lane(lane, t);
            }
        }
        engine.step(0, &batch);
    }
    engine
}

fn saved(engine: &Engine<V>) -> Vec<LaneState> {
    (0..8).map(|lane| engine.save_lane(0, lane)).collect()
}

#[test]
fn repeats_bit_for_bit() {
    let envs: Vec<u32> = (0..8).collect();
    assert_eq!(saved(&run(&envs, 0..150, None)), saved(&run(&envs, 0..150, None)));
}

#[test]
fn a_lane_does_not_depend_on_its_neighbors() {
    let a = saved(&run(&[0, 1, 2, 3, 4, 5, 6, 7], 0..150, None));
    let b = saved(&run(&[20, 1, 21, 22, 23, 5, 24, 2], 0..150, None));
    assert_eq!(a[1], b[1]);
    assert_eq!(a[5], b[5]);
    assert_eq!(a[2], b[7]);
}

#[test]
fn an_environment_with_other_motors_is_a_robot_that_is_built_with_them() {
    let scale = MotorScale { armature: 2.0, stiffness: 1.5, damping: 0.5, effort: 0.75, friction: 3.0 };
    let run = |built: bool| {
        let (mut model, mut spec) = biped();
        let joints = model.joints.len();
        let scene = scene();
        let mut params = EnvParams { terrain_offset: [0.5, 0.5], ..EnvParams::default() };
        if built {
            for joint in &mut model.joints {
                joint.armature *= scale.armature;
                joint.effort_limit *= scale.effort;
                joint.friction_loss *= scale.friction;
            }
            spec.stiffness.iter_mut().for_each(|x| *x *= scale.stiffness);
            spec.damping.iter_mut().for_each(|x| *x *= scale.damping);
        } else {
            params.motor_scale = vec![scale; joints];
        }
        let mut engine = Engine::<f64>::new(&model, spec, &scene, 1).unwrap();
        engine.set_params(0, 0, &params);
        engine.reset_lane(0, 0, &start(&model, 1));
        engine.refresh(0);
        for step in 0..40 {
            engine.step(0, &targets(&model, 1, step));
        }
        (engine.save_lane(0, 0), engine.state(0).joint_torque.clone())
    };
    let ((scaled, torques), (built, expected)) = (run(false), run(true));
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9 * b.abs().max(1.0));
    assert!(
        near(&scaled.joint_pos, &built.joint_pos) && near(&torques, &expected),
        "{torques:?} {expected:?}"
    );
}

#[test]
fn targets_that_arrive_in_the_middle_are_two_steps_of_half_the_length() {
    let (model, spec) = biped();
    let engine = |substeps: usize| {
        let scene = SceneConfig { substeps, ..scene() };
        let mut engine = Engine::<f64>::new(&model, spec.clone(), &scene, 1).unwrap();
        engine.reset_lane(0, 0, &start(&model, 1));
        engine.refresh(0);
        engine
    };
    let (mut late, mut halves) = (engine(4), engine(2));
    for step in 0..20 {
        let [before, now] = [step, step + 1].map(|step| targets(&model, 1, step));
        late.step_late(0, LateTargets { before: &before, now: &now, late: 0.5 });
        halves.step(0, &before);
        halves.step(0, &now);
    }
    let [late, halves] = [&late, &halves].map(|engine| engine.save_lane(0, 0).joint_pos);
    let error = late.iter().zip(&halves).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(error < 1e-9, "{error}");
}

#[test]
fn a_physics_step_in_which_targets_arrive_has_their_mean() {
    let mut reached = [0.0];
    let targets = LateTargets { before: &[1.0], now: &[3.0], late: 0.375 };
    let of_steps = [0, 1, 2, 3].map(|i| {
        targets.fill(i, 4, &mut reached);
        reached[0]
    });
    assert_eq!(of_steps, [1.0, 2.0, 3.0, 3.0]);
}

#[test]
fn a_restored_state_continues_bit_for_bit() {
    let envs: Vec<u32> = (0..8).collect();
    let through = run(&envs, 0..120, None);
    let half = saved(&run(&envs, 0..60, None));
    let resumed = run(&envs, 60..120, Some(&half));
    assert_eq!(saved(&through), saved(&resumed));
}

#[test]
fn a_broken_lane_stays_alone() {
    let (model, spec) = biped();
    let run = |broken: bool| {
        let mut engine = Engine::<V>::new(&model, spec.clone(), &scene(), 2).unwrap();
        for group in 0..2 {
            for lane in 0..8 {
                engine.reset_lane(group, lane, &start(&model, lane as u32));
            }
        }
        if broken {
            let mut bad = start(&model, 3);
            bad.base_pos[0] = f64::NAN;
            bad.joint_vel[4] = f64::INFINITY;
            bad.ball_vel[1] = f64::NAN;
            engine.reset_lane(0, 3, &bad);
        }
        let zeros = vec![V::zero(); model.joints.len()];
        for _ in 0..30 {
            engine.step(0, &zeros);
            engine.step(1, &zeros);
        }
        engine
    };
    let (sound, broken) = (run(false), run(true));
    for group in 0..2 {
        for lane in (0..8).filter(|&lane| group == 1 || lane != 3) {
            assert_eq!(
                sound.save_lane(group, lane),
                broken.save_lane(group, lane),
                "group {group} lane {lane}"
            );
        }
    }
    let lost = broken.save_lane(0, 3);
    assert!(lost.base_pos.iter().any(|x| !x.is_finite()), "the loss must show");
    // A reset repairs it.
    let mut engine = broken;
    engine.reset_lane(0, 3, &start(&model, 3));
    engine.refresh(0);
    let zeros = vec![V::zero(); model.joints.len()];
    engine.step(0, &zeros);
    let state = engine.save_lane(0, 3);
    assert!(state.base_pos.iter().chain(&state.joint_vel).chain(&state.ball_pos).all(|x| x.is_finite()));
}

#[test]
fn a_reset_clears_the_contact_reports_of_its_lane_only() {
    let (model, _) = biped();
    let mut engine = run(&[0, 1, 2, 3, 4, 5, 6, 7], 0..20, None);
    let foot = model.body_index("left_foot").unwrap();
    let before = engine.state(0).contact_force[foot];
    engine.reset_lane(0, 2, &start(&model, 2));
    engine.refresh(0);
    let s = engine.state(0);
    assert_eq!(s.contact_force[foot].lane(2), [0.0; 3]);
    assert_eq!(s.contact_force[foot].lane(1), before.lane(1));
    assert_eq!(s.bodies[0].pos.0[2].lane(2), f64::from(0.8_f32));
}

#[test]
fn a_push_adds_to_the_base_velocity() {
    let (model, _) = biped();
    let mut engine = crate::common::engine::<V>(&SceneConfig::default());
    reset_all(&mut engine, &lane_at(model.joints.len(), 2.0));
    engine.push_lane(0, 4, [0.5, 0.0, -0.25], [0.0, 1.0, 0.0]);
    let (pushed, other) = (engine.save_lane(0, 4), engine.save_lane(0, 3));
    assert_eq!(pushed.base_lin_vel, [0.5, 0.0, -0.25]);
    assert_eq!(pushed.base_ang_vel, [0.0, 1.0, 0.0]);
    assert_eq!(other.base_lin_vel, [0.0; 3]);
}

/// Random targets of up to 1.5 rad per joint, on this CPU's widest lanes, reset every 100 control steps to random states.
struct RandomActions {
    control_steps: usize,
}

impl IsaVisitor for RandomActions {
    type Output = ();

    fn visit<V: Real<Scalar = f32>>(self) {
        random_actions::<V>(self.control_steps);
    }
}

fn random_actions<V: Real>(control_steps: usize) {
    let (model, spec) = biped();
    let mut engine = Engine::<V>::new(&model, spec, &scene(), 1).unwrap();
    let mut rng = Rng::new(5, 0, 0);
    let n = model.joints.len();
    for round in 0..control_steps.div_ceil(V::LANES) {
        if round % 100 == 0 {
            for lane in 0..V::LANES {
                engine.set_params(0, lane, &params(rng.next_u32()));
                let mut s = start(&model, rng.next_u32());
                for k in 0..3 {
                    s.base_lin_vel[k] = rng.uniform(-1.0, 1.0);
                    s.base_ang_vel[k] = rng.uniform(-2.0, 2.0);
                }
                engine.reset_lane(0, lane, &s);
            }
            engine.refresh(0);
        }
        let mut batch = vec![V::zero(); n];
        for x in &mut batch {
            for lane in 0..V::LANES {
                x.set_lane(lane, rng.uniform(-1.5, 1.5));
            }
        }
        engine.step(0, &batch);
        let s = engine.state(0);
        for lane in 0..V::LANES {
            let speed = s.bodies[0].lin_vel.norm().lane(lane);
            let ball = s.ball.vel.norm().lane(lane);
            assert!(speed < 50.0 && ball < 100.0, "round {round} lane {lane}: base {speed}, ball {ball} m/s");
            assert!(s.joint_vel.iter().all(|v| v.lane(lane).is_finite()), "round {round} lane {lane}");
            assert!(
                s.contact_force.iter().all(|f| f.lane(lane).iter().all(|x| x.is_finite())),
                "round {round} lane {lane}"
            );
        }
    }
}

#[test]
fn survives_a_hundred_thousand_random_control_steps() {
    Isa::detect().dispatch(RandomActions { control_steps: 100_000 });
}

#[test]
#[ignore = "takes minutes: cargo test --release -p paid-physics --test all robust:: -- --ignored"]
fn survives_ten_million_random_control_steps() {
    Isa::detect().dispatch(RandomActions { control_steps: 10_000_000 });
}
