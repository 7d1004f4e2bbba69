//! Functions that are generic over the lane type, as values.

use core::any::Any;

use crate::{F32Array, Real};

/// A generic function, to be stored as one function pointer per lane type. `Of<V>` is the pointer's type, the same for every
/// generic function of a kind: it must not name the type that implements this trait.
pub trait PerLane {
    /// The function over lanes of type `V`, say `fn(V) -> V`.
    type Of<V: Real>: Copy + Send + Sync + 'static;

    /// Its instance for a lane type.
    fn of<V: Real>() -> Self::Of<V>;
}

/// The instances of a generic function for every lane type that [`crate::Isa`] can choose, and for `f64`.
#[derive(Debug)]
pub struct LaneTable(Vec<Box<dyn Any + Send + Sync>>);

impl LaneTable {
    /// The instances of `F`.
    pub fn new<F: PerLane>() -> Self {
        Self(vec![
            Box::new(F::of::<f64>()),
            Box::new(F::of::<F32Array<8>>()),
            #[cfg(target_arch = "x86_64")]
            Box::new(F::of::<crate::F32x8>()),
            #[cfg(target_arch = "x86_64")]
            Box::new(F::of::<crate::F32x16>()),
        ])
    }

    /// The instance of type `F`, which names the lane type.
    ///
    /// # Panics
    /// If there is none: the function is of another kind, or the lane type is none of these.
    pub fn get<F: Copy + 'static>(&self) -> F {
        let found = self.0.iter().find_map(|function| function.downcast_ref());
        *found.expect("an instance for each lane type")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Twice;

    impl PerLane for Twice {
        type Of<V: Real> = fn(V) -> V;

        fn of<V: Real>() -> fn(V) -> V {
            |x| x + x
        }
    }

    #[test]
    fn each_lane_type_has_its_function() {
        let table = LaneTable::new::<Twice>();
        assert_eq!(table.get::<fn(f64) -> f64>()(1.5), 3.0);
        assert_eq!(table.get::<fn(F32Array<8>) -> F32Array<8>>()(F32Array([1.5; 8])).0, [3.0; 8]);
    }
}
