//! Contacts of a world.

use std::ffi::c_int;

use super::{World, read};
use crate::layout::{contact, data};

/// A point of contact between two geoms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Numbers of the geoms.
    pub geoms: [usize; 2],
    /// Distance of the surfaces, negative in penetration `[m]`.
    pub dist: f64,
    /// Midpoint between the surfaces, world axes `[m]`.
    pub pos: [f64; 3],
    /// Rows: normal from the first to the second geom, two tangents; world axes.
    pub frame: [[f64; 3]; 3],
}

impl World {
    /// Number of contacts of the last step or forward computation.
    pub fn contact_count(&self) -> usize {
        // SAFETY: the offset is that of an `int` that is never negative.
        unsafe { read::<c_int>(self.data, data::NCON) as usize }
    }

    /// A contact. The force at it is [`World::contact_force`].
    pub fn contact(&self, index: usize) -> Contact {
        assert!(index < self.contact_count(), "contact {index} of {}", self.contact_count());
        // SAFETY: the array has `ncon` structures of this size with fields at these offsets.
        unsafe {
            let base = read::<*const u8>(self.data, data::CONTACT).add(index * contact::SIZE);
            let geoms = base.add(contact::GEOM).cast::<[c_int; 2]>().read_unaligned();
            Contact {
                geoms: [geoms[0] as usize, geoms[1] as usize],
                dist: base.add(contact::DIST).cast::<f64>().read(),
                pos: base.add(contact::POS).cast::<[f64; 3]>().read(),
                frame: base.add(contact::FRAME).cast::<[[f64; 3]; 3]>().read(),
            }
        }
    }

    /// Force on the second geom of a contact, world axes `[N]`.
    pub fn contact_force(&self, index: usize) -> [f64; 3] {
        let frame = self.contact(index).frame;
        let mut out = [0.0; 6];
        // SAFETY: the contact exists and the buffer has six entries.
        unsafe {
            let (model, data) = (self.model.as_ptr(), self.data.as_ptr());
            (self.library.functions.mj_contactForce)(model, data, index as c_int, out.as_mut_ptr());
        }
        std::array::from_fn(|k| frame[0][k] * out[0] + frame[1][k] * out[1] + frame[2][k] * out[2])
    }
}
