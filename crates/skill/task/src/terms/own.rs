//! Reward and termination terms of other crates: their parameters in a preset, and their functions over lanes.

use core::any::Any;
use core::fmt;
use core::marker::PhantomData;
use std::sync::Arc;

use paid_lanes::{Kernel, LaneTable, Mask, PerLane, Real};
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use toml::Value;

use super::TermInput;
use super::set::{own_rewards, own_terminations};
use crate::TaskError;
use crate::config::TaskConfig;
use crate::terms::parameters::Requirement;
use crate::terms::rewards::{self, RewardTerm};
use crate::terms::table::TermInfo;
use crate::terms::terminations::{self, TerminationTerm};

/// A term of another crate.
#[derive(Debug)]
pub(super) struct OwnTerm {
    pub info: TermInfo,
    needs: &'static [Requirement],
    /// Parameters from TOML.
    read: fn(Value) -> Result<Arc<dyn Held>, toml::de::Error>,
    /// For each lane type a [`Pay`] or a [`Fail`].
    function: LaneTable,
}

impl OwnTerm {
    pub(super) fn reward<T: RewardTerm>(name: &'static str) -> Self {
        Self {
            info: TermInfo::new::<T>("reward", name, [T::UNIT, T::FRAME], T::NEEDS),
            needs: T::NEEDS,
            read: |value| Ok(Arc::new(Reward(T::deserialize(value)?))),
            function: LaneTable::new::<Pays<T>>(),
        }
    }

    pub(super) fn termination<T: TerminationTerm>(name: &'static str) -> Self {
        Self {
            info: TermInfo::new::<T>("termination", name, [T::UNIT, T::FRAME], T::NEEDS),
            needs: T::NEEDS,
            read: |value| Ok(Arc::new(Termination(T::deserialize(value)?))),
            function: LaneTable::new::<Fails<T>>(),
        }
    }
}

/// Parameters of a term, whatever its type.
trait Held: Any + fmt::Debug + Send + Sync {
    fn is_on(&self) -> bool;
    fn validate(&self, key: &str) -> Result<(), TaskError>;
    fn to_value(&self) -> Value;
}

#[derive(Debug)]
struct Reward<T>(T);

impl<T: RewardTerm> Held for Reward<T> {
    fn is_on(&self) -> bool {
        self.0.weight() != 0.0
    }
    fn validate(&self, key: &str) -> Result<(), TaskError> {
        self.0.validate(key)
    }
    fn to_value(&self) -> Value {
        Value::try_from(&self.0).expect("parameters are plain values")
    }
}

#[derive(Debug)]
struct Termination<T>(T);

impl<T: TerminationTerm> Held for Termination<T> {
    fn is_on(&self) -> bool {
        self.0.is_on()
    }
    fn validate(&self, key: &str) -> Result<(), TaskError> {
        self.0.validate(key)
    }
    fn to_value(&self) -> Value {
        Value::try_from(&self.0).expect("parameters are plain values")
    }
}

/// A term of a preset: its parameters, and what computes it.
#[derive(Clone, Debug)]
struct Set {
    term: &'static OwnTerm,
    parameters: Arc<dyn Held>,
}

impl Set {
    fn new(term: &'static OwnTerm) -> Self {
        let parameters = (term.read)(Value::Table(toml::Table::new()));
        Self { term, parameters: parameters.expect("every parameter has a default") }
    }

    /// True if it is to be computed.
    fn counts(&self, config: &TaskConfig) -> bool {
        let has_ball = config.preset.scene.ball || !self.term.needs.contains(&Requirement::Ball);
        has_ball && self.parameters.is_on()
    }
}

/// The installed terms of a kind, in their order.
#[derive(Clone, Debug)]
struct Sets(Vec<Set>);

impl Sets {
    fn new(terms: &'static [OwnTerm]) -> Self {
        Self(terms.iter().map(Set::new).collect())
    }

    fn validate(&self, kind: &str) -> Result<(), TaskError> {
        self.0.iter().try_for_each(|set| set.parameters.validate(&format!("{kind}.{}", set.term.info.name)))
    }

    fn active(&self) -> impl Iterator<Item = (&'static str, &'static [Requirement])> {
        let on = self.0.iter().filter(|set| set.parameters.is_on());
        on.map(|set| (set.term.info.name, set.term.needs))
    }

    fn read<'de, D: Deserializer<'de>>(
        self,
        known: &'static [&'static str],
        from: D,
    ) -> Result<Self, D::Error> {
        struct ByName(Sets, &'static [&'static str]);

        impl<'de> Visitor<'de> for ByName {
            type Value = Sets;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("terms by their names")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Sets, A::Error> {
                let Self(mut sets, known) = self;
                while let Some(name) = map.next_key::<String>()? {
                    let set = sets.0.iter_mut().find(|set| set.term.info.name == name);
                    let set = set.ok_or_else(|| A::Error::unknown_field(&name, known))?;
                    let fail = |error: toml::de::Error| {
                        A::Error::custom(format!("{name}: {}", error.to_string().trim_end()))
                    };
                    set.parameters = (set.term.read)(map.next_value()?).map_err(fail)?;
                }
                Ok(sets)
            }
        }

        from.deserialize_map(ByName(self, known))
    }
}

impl PartialEq for Sets {
    fn eq(&self, other: &Self) -> bool {
        let values = |sets: &Self| sets.0.iter().map(|set| set.parameters.to_value()).collect::<Vec<_>>();
        values(self) == values(other)
    }
}

impl Serialize for Sets {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|set| (set.term.info.name, set.parameters.to_value())))
    }
}

/// The reward terms of other crates, with their parameters in a preset.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct OwnRewards(Sets);

impl Default for OwnRewards {
    fn default() -> Self {
        Self(Sets::new(own_rewards()))
    }
}

impl<'de> Deserialize<'de> for OwnRewards {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::default().0.read(rewards::keys(), deserializer).map(Self)
    }
}

impl OwnRewards {
    /// Number of terms.
    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.0.0.len()
    }

    pub(crate) fn validate(&self) -> Result<(), TaskError> {
        self.0.validate("rewards")
    }

    pub(crate) fn active(&self) -> impl Iterator<Item = (&'static str, &'static [Requirement])> {
        self.0.active()
    }

    /// Writes value x weight x control period of every term, and returns their sum.
    #[inline(never)]
    pub(crate) fn evaluate<V: Real>(&self, input: &TermInput<'_, V>, terms: &mut [V]) -> V {
        let mut total = V::zero();
        for (set, place) in self.0.0.iter().zip(terms) {
            *place = V::zero();
            if set.counts(input.config) {
                *place = set.term.function.get::<Pay<V>>()(&*set.parameters, input);
                total += *place;
            }
        }
        total
    }
}

/// The termination terms of other crates, with their limits in a preset.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct OwnTerminations(Sets);

impl Default for OwnTerminations {
    fn default() -> Self {
        Self(Sets::new(own_terminations()))
    }
}

impl<'de> Deserialize<'de> for OwnTerminations {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::default().0.read(terminations::keys(), deserializer).map(Self)
    }
}

impl OwnTerminations {
    /// Number of terms.
    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.0.0.len()
    }

    pub(crate) fn validate(&self) -> Result<(), TaskError> {
        self.0.validate("terminations")
    }

    pub(crate) fn active(&self) -> impl Iterator<Item = (&'static str, &'static [Requirement])> {
        self.0.active()
    }

    /// Writes the lanes that each term fails, one bit per lane.
    #[inline(never)]
    pub(crate) fn evaluate<V: Real>(&self, input: &TermInput<'_, V>, failed: &mut [u32]) {
        for (set, lanes) in self.0.0.iter().zip(failed) {
            let counts = set.counts(input.config);
            *lanes = if counts { set.term.function.get::<Fail<V>>()(&*set.parameters, input) } else { 0 };
        }
    }
}

/// Names of the installed reward terms.
pub(crate) fn own_reward_names() -> impl Iterator<Item = &'static str> {
    own_rewards().iter().map(|term| term.info.name)
}

/// Names of the installed termination terms.
pub(crate) fn own_termination_names() -> impl Iterator<Item = &'static str> {
    own_terminations().iter().map(|term| term.info.name)
}

/// Rows of the table of terms.
pub(crate) fn own_reward_table() -> impl Iterator<Item = TermInfo> {
    own_rewards().iter().map(|term| term.info.clone())
}

/// Rows of the table of terms.
pub(crate) fn own_termination_table() -> impl Iterator<Item = TermInfo> {
    own_terminations().iter().map(|term| term.info.clone())
}

/// Value x weight x control period of a term.
type Pay<V> = fn(&dyn Held, &TermInput<'_, V>) -> V;
/// The lanes that fail, one bit per lane.
type Fail<V> = fn(&dyn Held, &TermInput<'_, V>) -> u32;

/// The parameters as what they are.
fn held<T: 'static>(held: &dyn Held) -> &T {
    (held as &dyn Any).downcast_ref().expect("a term's own parameters")
}

struct Pays<T>(PhantomData<T>);

impl<T: RewardTerm> PerLane for Pays<T> {
    type Of<V: Real> = Pay<V>;

    fn of<V: Real>() -> Pay<V> {
        |parameters, input| V::run(Weighted { term: &held::<Reward<T>>(parameters).0, input })
    }
}

/// [`RewardTerm::value`], entered with the lane type's instruction set.
struct Weighted<'a, 'i, T, V: Real> {
    term: &'a T,
    input: &'a TermInput<'i, V>,
}

impl<T: RewardTerm, V: Real> Kernel for Weighted<'_, '_, T, V> {
    type Output = V;
    #[inline(always)]
    fn run(self) -> V {
        self.term.value(self.input) * V::c(self.term.weight() * self.input.dt_s())
    }
}

struct Fails<T>(PhantomData<T>);

impl<T: TerminationTerm> PerLane for Fails<T> {
    type Of<V: Real> = Fail<V>;

    fn of<V: Real>() -> Fail<V> {
        |parameters, input| V::run(Check { term: &held::<Termination<T>>(parameters).0, input })
    }
}

/// [`TerminationTerm::fails`], entered with the lane type's instruction set.
struct Check<'a, 'i, T, V: Real> {
    term: &'a T,
    input: &'a TermInput<'i, V>,
}

impl<T: TerminationTerm, V: Real> Kernel for Check<'_, '_, T, V> {
    type Output = u32;
    #[inline(always)]
    fn run(self) -> u32 {
        self.term.fails(self.input).bits()
    }
}
