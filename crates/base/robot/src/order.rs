//! Orders by name: every interface permutes, none assumes an order.

use thiserror::Error;

/// Two lists of names that are not permutations of one another.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum OrderError {
    /// A name of the target order is missing from the source.
    #[error("'{name}' is expected but not found; found: {found}")]
    Missing {
        /// The missing name.
        name: String,
        /// What the source has.
        found: String,
    },
    /// A name occurs twice.
    #[error("'{0}' occurs twice")]
    Duplicate(String),
    /// The source has a name that the target does not know.
    #[error("'{0}' is not known to the robot")]
    Unknown(String),
}

/// Maps positions of one order of names to positions of another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Permutation(Vec<usize>);

impl Permutation {
    /// The permutation that brings values in order `from` into order `to`: `to[i]` is `from[p[i]]`.
    ///
    /// # Errors
    /// If the two lists do not hold the same names once each.
    pub fn between<A: AsRef<str>, B: AsRef<str>>(from: &[A], to: &[B]) -> Result<Self, OrderError> {
        refuse_duplicates(from)?;
        refuse_duplicates(to)?;
        let index = to
            .iter()
            .map(|name| {
                from.iter().position(|n| n.as_ref() == name.as_ref()).ok_or_else(|| OrderError::Missing {
                    name: name.as_ref().to_owned(),
                    found: from.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", "),
                })
            })
            .collect::<Result<Vec<_>, _>>()?;
        match from.iter().find(|n| !to.iter().any(|t| t.as_ref() == n.as_ref())) {
            Some(extra) => Err(OrderError::Unknown(extra.as_ref().to_owned())),
            None => Ok(Self(index)),
        }
    }

    /// From positions that are known to be all of `0..n`, once each.
    pub(crate) fn from_unique(index: Vec<usize>) -> Self {
        Self(index)
    }

    /// The permutation back.
    pub fn inverse(&self) -> Self {
        let mut back = vec![0; self.0.len()];
        for (target, &source) in self.0.iter().enumerate() {
            back[source] = target;
        }
        Self(back)
    }

    /// For each target position, the source position.
    pub fn indices(&self) -> &[usize] {
        &self.0
    }

    /// Reorders `values` from the source into the target order.
    ///
    /// # Panics
    /// If `values` is shorter than the permutation.
    pub fn apply<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.0.iter().map(|&i| values[i]).collect()
    }
}

fn refuse_duplicates<S: AsRef<str>>(names: &[S]) -> Result<(), OrderError> {
    for (i, name) in names.iter().enumerate() {
        if names[..i].iter().any(|n| n.as_ref() == name.as_ref()) {
            return Err(OrderError::Duplicate(name.as_ref().to_owned()));
        }
    }
    Ok(())
}
