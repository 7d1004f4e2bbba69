//! The engine's inner functions, compiled once, in this crate, for every lane type.
//!
//! A generic function is compiled again in every crate that uses it. The engine's are large, so [`Engine`] calls them
//! through a table of function pointers that is filled here for the concrete lane types.

use core::any::Any;

use paid_lanes::{F32Array, Kernel, Real};
#[cfg(target_arch = "x86_64")]
use paid_lanes::{F32x8, F32x16};

use super::step::{Constants, Phase, physics_step};
use super::{Engine, report, validate};

/// Entry points for one lane type.
#[derive(Clone, Copy)]
pub(crate) struct Kernels<V: Real> {
    /// One control step of a group under joint targets.
    pub step: fn(&mut Engine<V>, usize, &[V]),
    /// Body poses and velocities of a group from its joints and base.
    pub refresh: fn(&mut Engine<V>, usize),
    /// Accelerations of a group under a base wrench and joint torques.
    pub accelerations: fn(&mut Engine<V>, usize, [V; 6], &[V]) -> Vec<V>,
}

impl<V: Real> Kernels<V> {
    const fn new() -> Self {
        Self { step: step::<V>, refresh: refresh::<V>, accelerations: validate::accelerations::<V> }
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

fn step<V: Real>(engine: &mut Engine<V>, group: usize, targets: &[V]) {
    let Engine { scene, plan, ground, groups, work, .. } = engine;
    let g = &mut groups[group];
    let constants = Constants::new(scene, ground);
    report::start(g);
    for _ in 0..scene.substeps {
        if ground.is_plane() {
            physics_step::<V, true>(plan, &constants, g, work, targets);
        } else {
            physics_step::<V, false>(plan, &constants, g, work, targets);
        }
        V::run(Forces(Phase { plan, constants: &constants, g, w: work }));
    }
    V::run(Torques(Phase { plan, constants: &constants, g, w: work }, targets));
    refresh(engine, group);
}

fn refresh<V: Real>(engine: &mut Engine<V>, group: usize) {
    let Engine { scene, plan, ground, groups, work, .. } = engine;
    let constants = &Constants::new(scene, ground);
    V::run(Poses(Phase { plan, constants, g: &mut groups[group], w: work }));
}

struct Forces<'a, V: Real>(Phase<'a, V>);
impl<V: Real> Kernel for Forces<'_, V> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        report::forces(self.0.g, self.0.w);
    }
}

struct Torques<'a, V: Real>(Phase<'a, V>, &'a [V]);
impl<V: Real> Kernel for Torques<'_, V> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        report::torques(self.0.plan, self.0.g, self.1);
    }
}

struct Poses<'a, V: Real>(Phase<'a, V>);
impl<V: Real> Kernel for Poses<'_, V> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        report::poses(self.0.plan, self.0.g, self.0.w);
    }
}
