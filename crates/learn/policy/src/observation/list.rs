//! From the list of terms: their names, the noise of a preset, and the function that writes a term by its name.

/// Makes [`ObservationId`](super::ObservationId) and [`ObservationNoise`](super::ObservationNoise) from `name: Type` entries.
macro_rules! observations {
    ($($name:ident: $Term:ident,)*) => {
        $(pub use $name::$Term;)*

        /// A term of the list, as presets name it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum ObservationId {
            $(
                #[doc = concat!("[`", stringify!($Term), "`].")]
                $Term,
            )*
        }

        impl ObservationId {
            /// Every term.
            pub const ALL: [Self; [$(stringify!($name)),*].len()] = [$(Self::$Term),*];

            /// Name in presets and policy files.
            pub const fn name(&self) -> &'static str {
                match self {
                    $(Self::$Term => stringify!($name),)*
                }
            }

            /// The term of a name.
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|id| id.name() == name)
            }

            /// What the term is.
            pub fn info(&self) -> ObservationInfo {
                match self {
                    $(Self::$Term => ObservationInfo::of::<$Term>(self.name()),)*
                }
            }

            /// Writes the term's numbers.
            ///
            /// # Panics
            /// If the views lack what the term needs, see [`check`].
            #[inline(always)]
            pub fn write<V: Real>(self, views: &Views<'_, V>, out: &mut impl Sink<V>) {
                match self {
                    $(Self::$Term => $Term::write(views, out),)*
                }
            }
        }

        /// Half-widths of the uniform noise on the policy's copy of the terms; 0, the default, is none.
        #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct ObservationNoise {
            $(
                #[doc = concat!("On [`", stringify!($Term), "`], in its unit.")]
                pub $name: f64,
            )*
        }

        impl ObservationNoise {
            /// The half-widths that the terms themselves state, with their reasons.
            pub fn standard() -> Self {
                Self { $($name: $Term::NOISE.half_width,)* }
            }

            /// Half-width of a term.
            pub fn half_width(&self, id: ObservationId) -> f64 {
                match id {
                    $(ObservationId::$Term => self.$name,)*
                }
            }
        }
    };
}

pub(crate) use observations;
