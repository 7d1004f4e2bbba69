//! Policies as ONNX files: written for deployment, read back and checked term by term.
//!
//! A policy file holds the graph (observation normalization, optional LSTM, layers), the metadata keys of PAiD's public release
//! (release-facts, "Released ONNX interface") and one entry of this project, [`CONTRACT_KEY`], in which the file describes itself
//! ([`Contract`]). The graph's interface is the released one:
//!
//! | input | shape | output | shape |
//! |---|---|---|---|
//! | `obs` | `[1, observation]` | `actions` | `[1, joints]` |
//! | `h_in`, `c_in` (recurrent only) | `[layers, 1, hidden]` | `h_out`, `c_out` | `[layers, 1, hidden]` |
//! | `time_step` (frame of the embedded reference) | `[1, 1]` | `joint_pos`, ... (only with a reference) | `[1, ...]` |
//!
//! A reference motion is embedded only on request ([`Reference`]), because a file that carries one inherits the motion's license.

mod error;
mod graph;
pub mod proto;
mod raw;
mod read;
mod reference;
mod released;
mod weights;
mod write;

// What files are written from and read as.
pub use error::OnnxError;
pub use paid_policy::contract::{Contract, FORMAT, JointContract, ObservationTerm, RecurrentContract};
pub use raw::{OnnxFile, RawModel};
pub use read::{OnnxPolicy, PolicyState};
pub use reference::Reference;
pub use released::{load_released, released_policy};
pub use weights::{DenseLayer, LstmLayer, Normalizer, PolicyWeights};
pub use write::{encode, write};

/// Metadata key of the self-describing contract.
pub const CONTRACT_KEY: &str = "paid_contract";
/// ONNX operator set that files are written in and read back from.
pub const OPSET: i64 = 17;
/// ONNX intermediate representation version that files are written in.
pub const IR_VERSION: i64 = 8;

/// Metadata keys of the released interface that every file carries, besides [`CONTRACT_KEY`].
pub const RELEASED_KEYS: [&str; 10] = [
    "joint_names",
    "joint_stiffness",
    "joint_damping",
    "default_joint_pos",
    "action_scale",
    "observation_names",
    "command_names",
    "anchor_body_name",
    "body_names",
    "run_path",
];
