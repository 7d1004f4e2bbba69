//! Observation terms of other crates.

use core::fmt;
use core::hash::{Hash, Hasher};
use core::marker::PhantomData;
use std::sync::OnceLock;

use paid_lanes::{Kernel, LaneTable, PerLane, Real};
use thiserror::Error;

use super::{Observation, ObservationId, ObservationInfo};
use crate::{Dimensions, Views};

static INSTALLED: OnceLock<Vec<Entry>> = OnceLock::new();

/// A set of terms that cannot be installed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TermSetError {
    /// The name is no key of a preset.
    #[error("{kind} term '{name}': expected a name of a-z, 0-9 and _ that begins with a letter")]
    Name {
        /// `observation`, `reward` or `termination`.
        kind: &'static str,
        /// The name.
        name: &'static str,
    },
    /// The name is taken.
    #[error("{kind} term '{name}': this key exists already; choose another name")]
    Taken {
        /// `observation`, `reward` or `termination`.
        kind: &'static str,
        /// The name.
        name: &'static str,
    },
    /// Terms have been used already.
    #[error(
        "terms are installed once, before the first preset is read; here they are installed twice or too late"
    )]
    Late,
}

impl TermSetError {
    /// Refuses a name that is no key, is in `taken`, or stands twice in `names`.
    ///
    /// # Errors
    /// The first such name.
    pub fn check(kind: &'static str, names: &[&'static str], taken: &[&str]) -> Result<(), Self> {
        for (k, &name) in names.iter().enumerate() {
            let begins = name.starts_with(|c: char| c.is_ascii_lowercase());
            if !begins || !name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_') {
                return Err(Self::Name { kind, name });
            }
            if taken.contains(&name) || names[..k].contains(&name) {
                return Err(Self::Taken { kind, name });
            }
        }
        Ok(())
    }
}

/// Error text for a name that no term of this program has.
pub fn no_such_term(kind: &str, name: &str, known: &[&str]) -> String {
    format!(
        "this program has no {kind} term '{name}'; if another crate adds it, build the program with that crate. Known here: {}",
        known.join(", ")
    )
}

/// Observation terms in addition to the built-in ones. A crate that has reward or termination terms too installs all of them at once,
/// with `paid_task::TermSet`.
#[derive(Debug, Default)]
pub struct ObservationSet(Vec<Entry>);

impl ObservationSet {
    /// Adds a term under the name that presets and policy files use.
    #[must_use]
    pub fn with<T: Observation>(mut self, name: &'static str) -> Self {
        let write = LaneTable::new::<Writers<T>>();
        self.0.push(Entry { info: ObservationInfo::of::<T>(name), write });
        self
    }

    /// Checks the names.
    ///
    /// # Errors
    /// If one is no key, is taken or occurs twice.
    pub fn check(&self) -> Result<(), TermSetError> {
        let names: Vec<_> = self.0.iter().map(|entry| entry.info.name).collect();
        TermSetError::check("observation", &names, &ObservationId::BUILTIN.map(|id| id.name()))
    }

    /// Makes the terms known to the whole program, once.
    ///
    /// # Errors
    /// If a name cannot be used, or terms have been used before.
    pub fn install(self) -> Result<(), TermSetError> {
        self.check()?;
        INSTALLED.set(self.0).map_err(|_| TermSetError::Late)
    }
}

/// The installed terms in order. From the first call on nothing can be installed.
pub(super) fn installed() -> impl Iterator<Item = OwnObservation> {
    INSTALLED.get_or_init(Vec::new).iter().map(OwnObservation)
}

/// An installed term: what it is, and its function for each lane type.
#[derive(Debug)]
struct Entry {
    info: ObservationInfo,
    write: LaneTable,
}

type Write<V> = fn(&Views<'_, V>, &mut Vec<V>);

struct Writers<T>(PhantomData<T>);

impl<T: Observation> PerLane for Writers<T> {
    type Of<V: Real> = Write<V>;

    fn of<V: Real>() -> Write<V> {
        |views, out| V::run(WriteOwn(views, out, PhantomData::<T>))
    }
}

struct WriteOwn<'a, 'v, V, T>(&'a Views<'v, V>, &'a mut Vec<V>, PhantomData<T>);

impl<V: Real, T: Observation> Kernel for WriteOwn<'_, '_, V, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        T::write(self.0, self.1);
    }
}

/// A term of another crate.
#[derive(Clone, Copy)]
pub struct OwnObservation(&'static Entry);

impl OwnObservation {
    /// What the term is.
    pub(super) fn info(self) -> ObservationInfo {
        self.0.info
    }

    /// The term's numbers.
    ///
    /// # Panics
    /// If it writes more or fewer than its shape says, or the views lack what it needs.
    #[inline(never)]
    pub(super) fn numbers<V: Real>(self, views: &Views<'_, V>) -> Vec<V> {
        let mut numbers = Vec::new();
        self.0.write.get::<Write<V>>()(views, &mut numbers);
        let bodies = views.privileged.as_ref().map_or(0, |view| view.bodies.len());
        let size = self.0.info.shape.size(Dimensions { joints: views.robot.joint_vel.len(), bodies });
        assert_eq!(
            numbers.len(),
            size,
            "observation term '{}': numbers written, and its shape's",
            self.0.info.name
        );
        numbers
    }
}

impl PartialEq for OwnObservation {
    fn eq(&self, other: &Self) -> bool {
        self.0.info.name == other.0.info.name
    }
}

impl Eq for OwnObservation {}

impl Hash for OwnObservation {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.info.name.hash(state);
    }
}

impl fmt::Debug for OwnObservation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.info.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Shape, Sink, fixture::Fixture};

    /// Twice the height of the ball.
    struct Twice;

    impl Observation for Twice {
        const SUMMARY: &'static str = "Twice the height of the ball.";
        const UNIT: &'static str = "m";
        const FRAME: &'static str = "base";
        const SHAPE: Shape = Shape::Scalar;

        #[inline(always)]
        fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
            out.push(views.scene().ball.z() * V::c(2.0));
        }
    }

    #[test]
    fn a_name_is_a_key_that_is_free() {
        let check = |name| ObservationSet::default().with::<Twice>(name).check().map_err(|e| e.to_string());
        assert_eq!(check("twice"), Ok(()));
        assert!(check("joint_vel").expect_err("taken").contains("'joint_vel': this key exists already"));
        for name in ["", "Twice", "2wice", "twice x", "twice.x"] {
            assert!(check(name).expect_err("no key").contains("expected a name of a-z"), "{name}");
        }
        let twice = ObservationSet::default().with::<Twice>("twice").with::<Twice>("twice");
        assert_eq!(twice.check(), Err(TermSetError::Taken { kind: "observation", name: "twice" }));
    }

    #[test]
    fn its_function_is_the_terms() {
        let set = ObservationSet::default().with::<Twice>("twice");
        let mut out = Vec::new();
        set.0[0].write.get::<Write<f64>>()(&Fixture::new().views(), &mut out);
        assert_eq!(out, [-1.2]);
    }
}
