//! Finding and opening `libmujoco` at run time.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use thiserror::Error;

use crate::layout::log_message;
use crate::world::World;

/// The version that [`crate::World`] is written for.
pub const MUJOCO_VERSION: &str = "3.17.0";
/// Environment variable with the path of the library; it comes before every other place.
pub const LIBRARY_VARIABLE: &str = "MUJOCO_LIB";

/// Why MuJoCo cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LibraryError {
    /// It is nowhere.
    #[error(
        "MuJoCo {MUJOCO_VERSION} was not found (looked for {looked_for}); run `cargo mujoco` to fetch it, or set \
         {LIBRARY_VARIABLE} to the library file"
    )]
    NotFound {
        /// Where it was looked for.
        looked_for: String,
    },
    /// The file is no library for this machine, or lacks a function.
    #[error(
        "{file}: cannot be opened as MuJoCo {MUJOCO_VERSION}: {reason}; run `cargo mujoco` to fetch it again"
    )]
    Open {
        /// The file.
        file: PathBuf,
        /// What the loader says.
        reason: String,
    },
    /// Another version of MuJoCo.
    #[error(
        "{file}: expected MuJoCo {MUJOCO_VERSION}, found {found}; run `cargo mujoco` to fetch the expected one"
    )]
    Version {
        /// The file.
        file: PathBuf,
        /// Its version.
        found: String,
    },
    /// Known values of a test model do not come back.
    #[error("{file}: its data layout is not that of MuJoCo {MUJOCO_VERSION}: {quantity}")]
    Layout {
        /// The file.
        file: PathBuf,
        /// What differs.
        quantity: String,
    },
}

macro_rules! functions {
    ($($name:ident: fn($($arg:ty),*) $(-> $ret:ty)?;)*) => {
        /// The functions of the library that are used, under their own names.
        #[allow(non_snake_case)]
        pub(crate) struct Functions {
            $(pub(crate) $name: unsafe extern "C" fn($($arg),*) $(-> $ret)?,)*
        }
        impl Functions {
            /// Looks every function up by its name.
            #[allow(non_snake_case)]
            fn find(library: &libloading::Library) -> Result<Self, String> {
                $(
                    // SAFETY: the signature is that of the function of this name in the headers of MuJoCo 3.17.0.
                    let $name = unsafe {
                        *library
                            .get::<unsafe extern "C" fn($($arg),*) $(-> $ret)?>(concat!(stringify!($name), "\0").as_bytes())
                            .map_err(|e| e.to_string())?
                    };
                )*
                Ok(Self { $($name),* })
            }
        }
    };
}

// Handles of mjModel, mjData, mjSpec and mjVFS are opaque here; `mjtNum` is `double`.
functions! {
    mj_versionString: fn() -> *const c_char;
    mj_parseXMLString: fn(*const c_char, *const c_void, *mut c_char, c_int) -> *mut c_void;
    mj_compile: fn(*mut c_void, *const c_void) -> *mut c_void;
    mjs_getError: fn(*mut c_void) -> *const c_char;
    mj_deleteSpec: fn(*mut c_void);
    mj_copyModel: fn(*mut c_void, *const c_void) -> *mut c_void;
    mj_deleteModel: fn(*mut c_void);
    mj_makeData: fn(*const c_void) -> *mut c_void;
    mj_deleteData: fn(*mut c_void);
    mj_resetData: fn(*const c_void, *mut c_void);
    mj_setConst: fn(*mut c_void, *mut c_void);
    mj_step: fn(*const c_void, *mut c_void);
    mj_forward: fn(*const c_void, *mut c_void);
    mj_kinematics: fn(*const c_void, *mut c_void);
    mj_comPos: fn(*const c_void, *mut c_void);
    mj_comVel: fn(*const c_void, *mut c_void);
    mj_fullM: fn(*const c_void, *const c_void, *mut f64);
    mj_name2id: fn(*const c_void, c_int, *const c_char) -> c_int;
    mj_objectVelocity: fn(*const c_void, *const c_void, c_int, c_int, *mut f64, c_int);
    mj_contactForce: fn(*const c_void, *const c_void, c_int, *mut f64);
    mju_setLogHandler: fn(Option<LogHandler>) -> Option<LogHandler>;
}

/// `mjfLogHandler`.
type LogHandler = unsafe extern "C" fn(*const c_void);

static WARNINGS: AtomicUsize = AtomicUsize::new(0);

/// Takes MuJoCo's messages, so that it writes no log file into the working folder: errors go to standard error (MuJoCo ends the
/// program after one), warnings are counted.
unsafe extern "C" fn take_message(message: *const c_void) {
    let message = message.cast::<u8>();
    // SAFETY: MuJoCo passes a valid mjLogMessage; offsets and size are those of its header.
    let (level, subject) = unsafe {
        let level = message.add(log_message::LEVEL).cast::<i32>().read();
        (level, std::slice::from_raw_parts(message.add(log_message::SUBJECT), log_message::SUBJECT_SIZE))
    };
    if level == log_message::WARNING {
        WARNINGS.fetch_add(1, Ordering::Relaxed);
    } else if level > log_message::WARNING {
        let text = CStr::from_bytes_until_nul(subject).map_or_else(|_| "".into(), CStr::to_string_lossy);
        eprintln!("MuJoCo: {text}");
    }
}

/// The opened library. There is one a process; it stays open.
pub struct Library {
    pub(crate) functions: Functions,
    file: PathBuf,
    _library: libloading::Library,
}

impl std::fmt::Debug for Library {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "MuJoCo {MUJOCO_VERSION} ({})", self.file.display())
    }
}

impl Library {
    /// Finds and opens MuJoCo at the first call; later calls return the same result.
    ///
    /// Looked for: the file named by `MUJOCO_LIB`; the folder `mujoco` next to or above the running program (target folder,
    /// installation); `target/mujoco` in the working folder or above.
    ///
    /// # Errors
    /// If it is missing, not loadable, or of another version; the message names the remedy.
    pub fn get() -> Result<&'static Self, LibraryError> {
        static LIBRARY: OnceLock<Result<Library, LibraryError>> = OnceLock::new();
        static CHECK: OnceLock<Result<(), LibraryError>> = OnceLock::new();
        let library = LIBRARY.get_or_init(|| Self::open(&find()?)).as_ref().map_err(Clone::clone)?;
        CHECK
            .get_or_init(|| {
                World::check_layout(library)
                    .map_err(|quantity| LibraryError::Layout { file: library.file.clone(), quantity })
            })
            .clone()?;
        Ok(library)
    }

    /// The file that was opened.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Warnings that MuJoCo has raised in this process (for example of diverging states).
    pub fn warnings(&self) -> usize {
        WARNINGS.load(Ordering::Relaxed)
    }

    fn open(file: &Path) -> Result<Self, LibraryError> {
        let open_error = |reason: String| LibraryError::Open { file: file.to_owned(), reason };
        // SAFETY: loading runs the library's initializers; a file that the user or `cargo mujoco` put in place is trusted.
        let library = unsafe { libloading::Library::new(file) }.map_err(|e| open_error(e.to_string()))?;
        let functions = Functions::find(&library).map_err(open_error)?;
        // SAFETY: the function takes nothing and returns a static string.
        let version = unsafe { CStr::from_ptr((functions.mj_versionString)()) }.to_string_lossy();
        if version != MUJOCO_VERSION {
            return Err(LibraryError::Version { file: file.to_owned(), found: version.into_owned() });
        }
        // SAFETY: the handler has the right signature, is thread-safe and lives as long as the program.
        unsafe { (functions.mju_setLogHandler)(Some(take_message)) };
        Ok(Self { functions, file: file.to_owned(), _library: library })
    }
}

/// The library file of the first place that has one.
fn find() -> Result<PathBuf, LibraryError> {
    if let Some(file) = std::env::var_os(LIBRARY_VARIABLE) {
        let file = PathBuf::from(file);
        return if file.is_file() {
            Ok(file)
        } else {
            Err(LibraryError::NotFound { looked_for: format!("{} ({LIBRARY_VARIABLE})", file.display()) })
        };
    }
    let name = match std::env::consts::OS {
        "macos" => format!("libmujoco.{MUJOCO_VERSION}.dylib"),
        "windows" => "mujoco.dll".to_owned(),
        _ => format!("libmujoco.so.{MUJOCO_VERSION}"),
    };
    let program = std::env::current_exe().unwrap_or_default();
    let folder = std::env::current_dir().unwrap_or_default();
    let by_program = program.ancestors().skip(1).map(|a| a.join("mujoco").join(&name));
    let by_folder = folder.ancestors().map(|a| a.join("target").join("mujoco").join(&name));
    by_program.chain(by_folder).find(|file| file.is_file()).ok_or_else(|| LibraryError::NotFound {
        looked_for: format!("mujoco/{name} above the program, target/mujoco/{name} above the working folder"),
    })
}
