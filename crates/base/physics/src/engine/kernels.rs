//! The engine's inner functions, compiled once, in this crate, for every lane type.
//!
//! A generic function is compiled again in every crate that uses it. The engine's are large, so [`Engine`] calls them
//! through a table of function pointers that is filled here for the concrete lane types.

use core::any::Any;

use paid_lanes::{F32Array, Real};
#[cfg(target_arch = "x86_64")]
use paid_lanes::{F32x8, F32x16};

use super::phase::phase;
use super::step::{Constants, physics_step};
use super::{Engine, ball, report, validate};
use crate::LateTargets;

/// Group, base wrench, joint torques; see [`Engine::accelerations_under`].
type Accelerations<V> = fn(&mut Engine<V>, usize, [V; 6], &[V]) -> Vec<V>;

/// Entry points for one lane type.
#[derive(Clone, Copy)]
pub(crate) struct Kernels<V: Real> {
    /// One control step of a group under joint targets.
    pub step: fn(&mut Engine<V>, usize, LateTargets<'_, V>),
    /// Body poses and velocities of a group from its joints and base.
    pub refresh: fn(&mut Engine<V>, usize),
    /// Physics steps of the balls of a group alone.
    pub balls: fn(&mut Engine<V>, usize, usize),
    /// Accelerations of a group under a base wrench and joint torques.
    pub accelerations: Accelerations<V>,
}

impl<V: Real> Kernels<V> {
    const fn new() -> Self {
        Self {
            step: step::<V>,
            refresh: refresh::<V>,
            balls: ball_steps::<V>,
            accelerations: validate::accelerations::<V>,
        }
    }

    /// The table of a lane type.
    ///
    /// # Panics
    /// If `V` is none of the types of `paid-lanes` that the engine is compiled for.
    pub fn for_lanes() -> Self {
        let found = tables().into_iter().find_map(|table| table.downcast_ref::<Self>().copied());
        found.unwrap_or_else(|| panic!("the engine is not compiled for the lane type {}", V::NAME))
    }
}

/// All tables. Not generic and not inlined: what they point to is compiled here and nowhere else.
#[inline(never)]
fn tables() -> Vec<&'static dyn Any> {
    vec![
        #[cfg(target_arch = "x86_64")]
        &const { Kernels::<F32x16>::new() },
        #[cfg(target_arch = "x86_64")]
        &const { Kernels::<F32x8>::new() },
        &const { Kernels::<F32Array<8>>::new() },
        &const { Kernels::<f64>::new() },
    ]
}

fn step<V: Real>(engine: &mut Engine<V>, group: usize, targets: LateTargets<'_, V>) {
    control_step(engine, group, targets);
    refresh(engine, group);
}

fn refresh<V: Real>(engine: &mut Engine<V>, group: usize) {
    report::poses(&engine.layout, &mut engine.groups[group], &mut engine.work);
}

phase! {
/// All physics steps of a control step, and the reports that only they can make.
fn control_step<'a, V>(engine: &'a mut Engine<V>, group: usize, targets: LateTargets<'a, V>) -> () {
    let Engine { scene, layout, ground, groups, work, .. } = engine;
    let g = &mut groups[group];
    let constants = Constants::new(scene, ground);
    report::start(g);
    let mut reached = std::mem::take(&mut work.targets);
    for i in 0..scene.substeps {
        targets.fill(i, scene.substeps, &mut reached);
        physics_step(layout, &constants, g, work, &reached);
        report::forces(g, work);
    }
    report::torques(layout, g, &reached);
    work.targets = reached;
}
}

phase! {
/// Physics steps of the balls of a group: ground contact as in a full step, no robot.
fn ball_steps<'a, V>(engine: &'a mut Engine<V>, group: usize, steps: usize) -> () {
    let Engine { scene, layout, ground, groups, work, .. } = engine;
    let g = &mut groups[group];
    let constants = Constants::new(scene, ground);
    report::start(g);
    for touch in &mut work.touches {
        touch.active = false;
    }
    for _ in 0..steps {
        ball::prepare_ground(&constants, g, work);
        for _ in 0..constants.sweeps {
            ball::sweep_ground(g, work);
        }
        ball::finish(layout, &constants, g, work);
    }
    report::ball(g);
}
}
