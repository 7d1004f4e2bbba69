//! From the list of terms: their names, and the function that writes a term by its name.

/// Makes [`ObservationId`](super::ObservationId) from `name: Type` entries.
macro_rules! observations {
    ($($name:ident: $Term:ident,)*) => {
        $(pub use $name::$Term;)*

        /// A term, as presets name it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum ObservationId {
            $(
                #[doc = concat!("[`", stringify!($Term), "`].")]
                $Term,
            )*
            /// A term of another crate, see [`ObservationSet`].
            Own(OwnObservation),
        }

        impl ObservationId {
            /// Every built-in term.
            pub const BUILTIN: [Self; [$(stringify!($name)),*].len()] = [$(Self::$Term),*];

            /// Name in presets and policy files.
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$Term => stringify!($name),)*
                    Self::Own(term) => term.info().name,
                }
            }

            /// What the term is.
            pub fn info(&self) -> ObservationInfo {
                match self {
                    $(Self::$Term => ObservationInfo::of::<$Term>(self.name()),)*
                    Self::Own(term) => term.info(),
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
                    Self::Own(term) => out.push_all(&term.numbers(views)),
                }
            }
        }
    };
}

pub(crate) use observations;
