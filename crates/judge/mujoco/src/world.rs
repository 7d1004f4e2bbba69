//! Safe access to one MuJoCo model with its own data.

mod arrays;
mod contact;

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::NonNull;

use thiserror::Error;

use crate::layout::{data, model};
use crate::library::{Library, LibraryError};

pub use contact::Contact;

/// `mjOBJ_XBODY`: a body with its regular frame.
const OBJECT_XBODY: c_int = 2;
/// `mjOBJ_GEOM`.
const OBJECT_GEOM: c_int = 5;

/// Why a scene cannot be simulated.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MujocoError {
    /// No library.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// MuJoCo refuses the scene.
    #[error("MuJoCo refuses the scene: {0}")]
    Scene(String),
    /// MuJoCo numbers the bodies of the robot otherwise.
    #[error("body '{body}': expected number {expected} in MuJoCo, found {found}")]
    BodyOrder {
        /// The body.
        body: String,
        /// Number by the model order.
        expected: usize,
        /// Number in MuJoCo.
        found: String,
    },
    /// A vector of the control numbers does not fit the robot.
    #[error("{name}: expected {expected} entries, found {found}")]
    Length {
        /// Which.
        name: &'static str,
        /// The robot's number.
        expected: usize,
        /// The given number.
        found: usize,
    },
}

/// A compiled scene and its state. Every world owns its model, so parameters may differ between worlds.
pub struct World {
    library: &'static Library,
    model: NonNull<c_void>,
    data: NonNull<c_void>,
}

// SAFETY: model and data belong to this value alone, and MuJoCo keeps no thread-local state for them.
unsafe impl Send for World {}

impl std::fmt::Debug for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "World {{ nq: {}, nv: {}, nu: {}, time: {} }}",
            self.nq(),
            self.nv(),
            self.nu(),
            self.time()
        )
    }
}

impl Drop for World {
    fn drop(&mut self) {
        // SAFETY: both were made by this library and are not used afterwards.
        unsafe {
            (self.library.functions.mj_deleteData)(self.data.as_ptr());
            (self.library.functions.mj_deleteModel)(self.model.as_ptr());
        }
    }
}

/// The field at `offset` bytes from `base`.
///
/// # Safety
/// There must be a field of type `T` at this place.
unsafe fn read<T: Copy>(base: NonNull<c_void>, offset: usize) -> T {
    // SAFETY: the caller vouches for the field; MuJoCo aligns structures as C does.
    unsafe { base.as_ptr().cast::<u8>().add(offset).cast::<T>().read() }
}

impl World {
    /// Compiles an MJCF text.
    ///
    /// # Errors
    /// If MuJoCo is missing or refuses the text.
    pub fn from_xml(xml: &str) -> Result<Self, MujocoError> {
        Self::compile(Library::get()?, xml)
    }

    pub(crate) fn compile(library: &'static Library, xml: &str) -> Result<Self, MujocoError> {
        let f = &library.functions;
        let text = CString::new(xml).map_err(|e| MujocoError::Scene(e.to_string()))?;
        let mut error = [0 as c_char; 1024];
        // SAFETY: text and buffer are valid for the call, the buffer's size is given, and what is returned is deleted once.
        unsafe {
            let spec = (f.mj_parseXMLString)(
                text.as_ptr(),
                std::ptr::null(),
                error.as_mut_ptr(),
                error.len() as c_int,
            );
            if spec.is_null() {
                return Err(MujocoError::Scene(
                    CStr::from_ptr(error.as_ptr()).to_string_lossy().into_owned(),
                ));
            }
            let model = (f.mj_compile)(spec, std::ptr::null());
            let refusal = if model.is_null() {
                CStr::from_ptr((f.mjs_getError)(spec)).to_string_lossy().into_owned()
            } else {
                String::new()
            };
            (f.mj_deleteSpec)(spec);
            let model = NonNull::new(model).ok_or(MujocoError::Scene(refusal))?;
            Self::with_model(library, model)
        }
    }

    /// Takes over `model`.
    ///
    /// # Safety
    /// `model` must be a model of this library that is used nowhere else.
    unsafe fn with_model(library: &'static Library, model: NonNull<c_void>) -> Result<Self, MujocoError> {
        // SAFETY: the model is valid; the data is deleted in `drop`.
        let data = unsafe { (library.functions.mj_makeData)(model.as_ptr()) };
        match NonNull::new(data) {
            Some(data) => Ok(Self { library, model, data }),
            None => {
                // SAFETY: the model is not used any more.
                unsafe { (library.functions.mj_deleteModel)(model.as_ptr()) };
                Err(MujocoError::Scene("no memory for the simulation state".to_owned()))
            }
        }
    }

    /// A second world with a copy of the model and a fresh state.
    ///
    /// # Errors
    /// If memory is short.
    pub fn duplicate(&self) -> Result<Self, MujocoError> {
        // SAFETY: the source model is valid; null requests a new copy, which the new world owns.
        unsafe {
            let copy = (self.library.functions.mj_copyModel)(std::ptr::null_mut(), self.model.as_ptr());
            let copy =
                NonNull::new(copy).ok_or_else(|| MujocoError::Scene("no memory for the model".to_owned()))?;
            Self::with_model(self.library, copy)
        }
    }

    fn count(&self, offset: usize) -> usize {
        // SAFETY: the offset is that of an `mjtSize` of the model, never negative.
        unsafe { read::<i64>(self.model, offset) as usize }
    }

    /// Number of position coordinates.
    pub fn nq(&self) -> usize {
        self.count(model::NQ)
    }
    /// Number of velocity coordinates.
    pub fn nv(&self) -> usize {
        self.count(model::NV)
    }
    /// Number of controls.
    pub fn nu(&self) -> usize {
        self.count(model::NU)
    }
    /// Number of bodies with the world, which is number 0.
    pub fn nbody(&self) -> usize {
        self.count(model::NBODY)
    }
    /// Number of geoms.
    pub fn ngeom(&self) -> usize {
        self.count(model::NGEOM)
    }
    /// Physics step `[s]`.
    pub fn timestep(&self) -> f64 {
        // SAFETY: the offset is that of a `double`.
        unsafe { read(self.model, model::TIMESTEP) }
    }
    /// Simulated time `[s]`.
    pub fn time(&self) -> f64 {
        // SAFETY: the offset is that of a `double`.
        unsafe { read(self.data, data::TIME) }
    }

    fn number(&self, kind: c_int, name: &str) -> Option<usize> {
        let name = CString::new(name).ok()?;
        // SAFETY: model and string are valid.
        let id = unsafe { (self.library.functions.mj_name2id)(self.model.as_ptr(), kind, name.as_ptr()) };
        usize::try_from(id).ok()
    }
    /// Number of a body by name.
    pub fn body(&self, name: &str) -> Option<usize> {
        self.number(OBJECT_XBODY, name)
    }
    /// Number of a geom by name.
    pub fn geom(&self, name: &str) -> Option<usize> {
        self.number(OBJECT_GEOM, name)
    }

    /// Back to the initial state.
    pub fn reset(&mut self) {
        // SAFETY: model and data belong together.
        unsafe { (self.library.functions.mj_resetData)(self.model.as_ptr(), self.data.as_ptr()) }
    }
    /// Recomputes what follows from changed masses, inertias and sizes. The state is kept.
    pub fn refresh_constants(&mut self) {
        let state = (self.qpos().to_vec(), self.qvel().to_vec(), self.qacc_warmstart().to_vec());
        // SAFETY: model and data belong together.
        unsafe { (self.library.functions.mj_setConst)(self.model.as_ptr(), self.data.as_ptr()) }
        self.qpos_mut().copy_from_slice(&state.0);
        self.qvel_mut().copy_from_slice(&state.1);
        self.qacc_warmstart_mut().copy_from_slice(&state.2);
    }
    /// Advances by one physics step.
    pub fn step(&mut self) {
        // SAFETY: model and data belong together.
        unsafe { (self.library.functions.mj_step)(self.model.as_ptr(), self.data.as_ptr()) }
    }
    /// Computes everything for the present state without advancing.
    pub fn forward(&mut self) {
        // SAFETY: model and data belong together.
        unsafe { (self.library.functions.mj_forward)(self.model.as_ptr(), self.data.as_ptr()) }
    }
    /// Computes poses and velocities of the bodies for the present state; contacts stay as they are.
    pub fn kinematics(&mut self) {
        let f = &self.library.functions;
        // SAFETY: model and data belong together; the order is that of mj_forward.
        unsafe {
            (f.mj_kinematics)(self.model.as_ptr(), self.data.as_ptr());
            (f.mj_comPos)(self.model.as_ptr(), self.data.as_ptr());
            (f.mj_comVel)(self.model.as_ptr(), self.data.as_ptr());
        }
    }

    /// The mass matrix `[nv * nv]`, row-major.
    pub fn mass_matrix(&self) -> Vec<f64> {
        let mut out = vec![0.0; self.nv() * self.nv()];
        // SAFETY: the buffer has nv * nv entries.
        unsafe {
            (self.library.functions.mj_fullM)(self.model.as_ptr(), self.data.as_ptr(), out.as_mut_ptr());
        }
        out
    }

    /// Angular `[rad/s]` and linear `[m/s]` velocity of a body's frame, world axes.
    pub fn body_velocity(&self, body: usize) -> ([f64; 3], [f64; 3]) {
        assert!(body < self.nbody(), "body {body} of {}", self.nbody());
        let mut out = [0.0; 6];
        // SAFETY: the body exists and the buffer has six entries; 0 means world axes.
        unsafe {
            (self.library.functions.mj_objectVelocity)(
                self.model.as_ptr(),
                self.data.as_ptr(),
                OBJECT_XBODY,
                body as c_int,
                out.as_mut_ptr(),
                0,
            );
        }
        ([out[0], out[1], out[2]], [out[3], out[4], out[5]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Library;

    #[test]
    fn a_wrong_scene_is_refused_with_mujocos_own_words() {
        let Some(_) = paid_testing::mujoco("a_wrong_scene_is_refused_with_mujocos_own_words", Library::get())
        else {
            return;
        };
        let error =
            World::from_xml("<mujoco><worldbody><geom type='cube'/></worldbody></mujoco>").unwrap_err();
        assert!(error.to_string().contains("geom"), "{error}");
        assert!(World::from_xml("no xml").is_err());
    }

    #[test]
    fn a_duplicate_has_its_own_model_and_state() {
        let Some(_) = paid_testing::mujoco("a_duplicate_has_its_own_model_and_state", Library::get()) else {
            return;
        };
        let xml =
            "<mujoco><worldbody><body><freejoint/><geom size='0.1' mass='2'/></body></worldbody></mujoco>";
        let mut first = World::from_xml(xml).unwrap();
        let mut second = first.duplicate().unwrap();
        second.body_mass_mut()[1] = 3.0;
        second.step();
        assert_eq!((first.body_mass()[1], second.body_mass()[1]), (2.0, 3.0));
        assert_eq!((first.time(), second.time()), (0.0, 0.002));
        first.reset();
    }
}
