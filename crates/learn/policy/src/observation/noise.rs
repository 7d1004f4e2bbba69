//! Noise on the policy's copy of the terms, as presets state it.

use core::fmt;

use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::ObservationId;

/// Half-widths of the uniform noise on the policy's copy of the terms, by name and in the term's unit; 0, the default, is none.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservationNoise(Vec<(ObservationId, f64)>);

impl Default for ObservationNoise {
    fn default() -> Self {
        Self(ObservationId::all().map(|id| (id, 0.0)).collect())
    }
}

impl ObservationNoise {
    /// The half-widths that the terms themselves state, with their reasons.
    pub fn standard() -> Self {
        Self(ObservationId::all().map(|id| (id, id.info().noise.half_width)).collect())
    }

    /// Half-width of a term.
    pub fn half_width(&self, id: ObservationId) -> f64 {
        self.0.iter().find(|(of, _)| *of == id).map_or(0.0, |(_, half_width)| *half_width)
    }
}

impl Serialize for ObservationNoise {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(id, half_width)| (id.name(), half_width)))
    }
}

impl<'de> Deserialize<'de> for ObservationNoise {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ByName;

        impl<'de> Visitor<'de> for ByName {
            type Value = ObservationNoise;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("half-widths by the names of observation terms")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<ObservationNoise, A::Error> {
                let mut noise = ObservationNoise::default();
                while let Some(name) = map.next_key::<String>()? {
                    let place = noise.0.iter_mut().find(|(id, _)| id.name() == name);
                    let (_, half_width) =
                        place.ok_or_else(|| A::Error::unknown_field(&name, ObservationId::names()))?;
                    *half_width = map.next_value()?;
                }
                Ok(noise)
            }
        }

        deserializer.deserialize_map(ByName)
    }
}
