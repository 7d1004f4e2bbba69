//! The built-in engine under the clock.

use paid_eval::EvalError;
use paid_lanes::{Isa, IsaVisitor, Real};
use paid_physics::{
    Compliance, Cone, ContactCompliance, ContactKind, Engine, EngineSpec, EnvParams, Simulator, SoleShape,
};

use super::clock::{Rate, timed};
use super::workload::{EPISODE, Means, Workload};
use super::{Contender, Row, Speed};

/// The engine with an instruction set and a number of groups per thread.
pub struct BuiltIn<'a> {
    pub isa: Isa,
    pub groups: usize,
    pub scene: &'static str,
    pub workload: &'a Workload,
    /// Contacts and controllers of all kinds.
    pub kinds: bool,
}

/// The kind of a lane: soft and hard contacts, every cone, other soles, other controllers.
fn kind(lane: usize) -> ContactKind {
    let share = lane as f64 / 8.0 % 1.0;
    let contact = Compliance::returning(0.025 * share, 0.6 * share);
    ContactKind {
        compliance: ContactCompliance { ball_robot: contact, ball_ground: contact, sole_ground: contact },
        ball_spin_friction_m: [0.01 * share, 0.0001],
        cone: Cone { pyramid: lane.is_multiple_of(2), convex: lane % 4 < 2 },
        sole: SoleShape {
            length_scale: 1.0 - 0.1 * share,
            rounding_m: 0.005 * share,
            ..SoleShape::default()
        },
        foot_flatness: share,
        pd_implicitness: 1.0 - 0.6 * share,
    }
}

struct Runner<V: Real> {
    engine: Engine<V>,
    /// Targets by step of the episode and joint; all groups share them, lanes differ.
    targets: Vec<Vec<V>>,
    step: usize,
}

impl<V: Real> Runner<V> {
    fn new(workload: &Workload, groups: usize, kinds: bool) -> Result<Self, EvalError> {
        let spec = EngineSpec {
            feet: workload.feet.to_vec(),
            stiffness: workload.control.stiffness.clone(),
            damping: workload.control.damping.clone(),
        };
        let mut engine = Engine::new(&workload.model, spec, &workload.scene, groups)?;
        let mut targets = vec![vec![V::zero(); workload.model.joints.len()]; EPISODE];
        for lane in 0..V::LANES {
            for (out, values) in targets.iter_mut().zip(workload.targets(lane as u32)) {
                for (out, value) in out.iter_mut().zip(values) {
                    out.set_lane(lane, value);
                }
            }
        }
        for group in 0..groups {
            for lane in 0..V::LANES {
                let offset = [0.37 * group as f64, 0.53 * lane as f64];
                let kind = if kinds { kind(lane) } else { ContactKind::default() };
                let params = EnvParams { terrain_offset: offset, kind, ..EnvParams::default() };
                engine.set_params(group, lane, &params);
            }
        }
        let mut runner = Self { engine, targets, step: 0 };
        for group in 0..groups {
            runner.reset(workload, group);
        }
        Ok(runner)
    }

    fn reset(&mut self, workload: &Workload, group: usize) {
        for lane in 0..V::LANES {
            // The robot stands above the highest point under its feet.
            let spots = [[0.15, 0.15], [0.15, -0.15], [-0.1, 0.15], [-0.1, -0.15], [0.0, 0.0], [0.45, 0.0]];
            let heights = spots.map(|xy| self.engine.ground_height(group, lane, xy));
            let ground = heights.into_iter().fold(f64::MIN, f64::max);
            let state = workload.start((group * V::LANES + lane) as u32, ground);
            self.engine.reset_lane(group, lane, &state);
        }
        self.engine.refresh(group);
    }

    /// One control step of every group, of which every `EPISODE`th is reset first. Returns physics steps.
    fn round(&mut self, workload: &Workload) -> u64 {
        let groups = self.engine.groups();
        for group in 0..groups {
            let step = (self.step + group) % EPISODE;
            if step == 0 {
                self.reset(workload, group);
            }
            self.engine.step(group, &self.targets[step]);
        }
        self.step += 1;
        (groups * V::LANES * workload.scene.substeps) as u64
    }
}

struct Time<'a> {
    workload: &'a Workload,
    groups: usize,
    threads: usize,
    seconds: f64,
    kinds: bool,
}

impl IsaVisitor for Time<'_> {
    type Output = Result<Rate, EvalError>;
    fn visit<V: Real<Scalar = f32>>(self) -> Self::Output {
        let make = || Runner::<V>::new(self.workload, self.groups, self.kinds);
        timed(self.threads, self.seconds, make, |r| r.round(self.workload))
    }
}

struct Look<'a> {
    workload: &'a Workload,
    kinds: bool,
}

impl IsaVisitor for Look<'_> {
    type Output = Result<(f64, f64), EvalError>;
    fn visit<V: Real<Scalar = f32>>(self) -> Self::Output {
        let mut runner = Runner::<V>::new(self.workload, 1, self.kinds)?;
        let mut means = Means::default();
        for _ in 0..EPISODE {
            runner.round(self.workload);
            means.take(runner.engine.state(0), self.workload.feet);
        }
        Ok(means.get())
    }
}

impl Contender for BuiltIn<'_> {
    fn speed(&self, threads: usize, seconds: f64) -> Result<Rate, EvalError> {
        self.isa.dispatch(Time {
            workload: self.workload,
            groups: self.groups,
            threads,
            seconds,
            kinds: self.kinds,
        })
    }

    fn row(&self) -> Result<Row, EvalError> {
        let (foot_contact_share, mean_base_height_m) =
            self.isa.dispatch(Look { workload: self.workload, kinds: self.kinds })?;
        Ok(Row {
            simulator: "built-in".to_owned(),
            scene: self.scene.to_owned(),
            one_core: Speed::default(),
            all_cores: Speed::default(),
            foot_contact_share,
            mean_base_height_m,
            mean_contacts: None,
            engine_is_faster_by: None,
        })
    }
}
