//! Policies as ONNX files: written for deployment, read back and checked term by term.
//!
//! A policy file holds the graph (observation normalization, optional LSTM, layers), the metadata keys of PAiD's public release,
//! and one entry of this project, [`CONTRACT_KEY`], in which the file describes itself
//! ([`Contract`]). The graph's interface is the released one:
//!
//! | input | shape | output | shape |
//! |---|---|---|---|
//! | `obs` | `[1, observation]` | `actions` | `[1, joints]` |
//! | `mirror` (only if left-footed kicks are played in the mirror) | `[1, 1]` | | |
//! | `h_in`, `c_in` (recurrent only) | `[layers, 1, hidden]` | `h_out`, `c_out` | `[layers, 1, hidden]` |
//! | `time_step` (frame of the embedded reference) | `[1, 1]` | `joint_pos`, ... (only with a reference) | `[1, ...]` |
//!
//! With `mirror` = 1 the policy acts as in a mirrored world, for kicks of the left foot; with 0 as it was trained.
//!
//! A trained policy's file also holds its run's resolved preset ([`Training`]) and is read back to the same numbers without a runtime
//! ([`OnnxFile::stored`]): it is the policy, its ONNX graph and its contract in one.
//!
//! A reference motion is embedded only on request ([`Reference`]), because a file that carries one inherits the motion's license.
//!
//! A policy of one joint, written and read back without a file:
//!
//! ```
//! use paid_onnx::{
//!     Contract, DenseLayer, FORMAT, JointContract, ObservationTerm, OnnxPolicy, PolicyWeights, encode,
//! };
//!
//! let knee = JointContract {
//!     name: "knee".into(),
//!     default_pos: 0.6,
//!     stiffness: 99.0,
//!     damping: 6.3,
//!     action_scale: 0.35,
//! };
//! let angle = ObservationTerm {
//!     name: "joint_pos_rel".into(),
//!     size: 1,
//!     order: "joints".into(),
//!     frame: "joint".into(),
//!     unit: "rad".into(),
//!     scale: 1.0,
//! };
//! let contract = Contract {
//!     format: FORMAT,
//!     robot: "leg".into(),
//!     mode_machines: Vec::new(),
//!     license: "MIT".into(),
//!     control_period_s: 0.02,
//!     action: "joint position target = default_pos + action_scale * action".into(),
//!     joints: vec![knee],
//!     anchor_body: "hip".into(),
//!     bodies: vec!["hip".into()],
//!     observation: vec![angle],
//!     commands: vec![],
//!     recurrent: None,
//!     reference: None,
//!     play: None,
//! };
//! let layer = DenseLayer { inputs: 1, outputs: 1, w: vec![-2.0], b: vec![0.5] };
//! let weights = PolicyWeights { normalizer: None, lstm: vec![], layers: vec![layer], mirror: None };
//!
//! let bytes = encode(&weights, &contract, None, "example", None)?;
//! let policy = OnnxPolicy::from_bytes(&bytes, "example".as_ref())?;
//! let mut state = policy.initial_state();
//! assert_eq!(policy.act(&[0.25], &mut state)?, [0.0]);
//! # Ok::<(), paid_onnx::OnnxError>(())
//! ```

mod error;
mod external;
mod graph;
pub mod proto;
mod raw;
mod read;
mod reference;
mod released;
#[cfg_attr(not(feature = "rten"), path = "no_runtime.rs")]
mod runtime;
mod sizes;
mod stored;
mod weights;
mod write;

// What files are written from and read as.
pub use error::OnnxError;
pub use paid_policy::contract::{
    Contract, FORMAT, JointContract, ObservationTerm, PlayContract, RecurrentContract,
};
pub use raw::{OnnxFile, RawModel};
pub use read::{OnnxPolicy, OnnxState};
pub use reference::Reference;
pub use released::{load_released, released_policy};
pub use stored::{StoredPolicy, Training};
pub use weights::{DenseLayer, LstmLayer, NormalizerWeights, PolicyWeights};
pub use write::{encode, write};

/// Metadata key of the self-describing contract.
pub const CONTRACT_KEY: &str = "paid_contract";
/// Metadata key of the run's resolved preset, as TOML.
pub const PRESET_KEY: &str = "paid_preset";
/// Metadata key of the standard deviation of each action at the end of training, as JSON.
pub const STD_KEY: &str = "paid_action_std";
/// Metadata key of the name of the run, one of the released ones.
pub const RUN_KEY: &str = "run_path";
/// ONNX operator set that files are written in and read back from.
pub const OPSET: i64 = 17;
/// ONNX intermediate representation version that files are written in.
pub const IR_VERSION: i64 = 8;

/// Metadata keys of the released interface that every file carries in addition to [`CONTRACT_KEY`].
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
    RUN_KEY,
];
