//! What can be wrong with a policy file.

use std::path::PathBuf;

use thiserror::Error;

/// A policy that cannot be written or read.
#[derive(Debug, Error)]
pub enum OnnxError {
    /// The file system refused.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The bytes are no ONNX model: truncated or of another format.
    #[error("{path}: not a complete ONNX model: {reason}")]
    Decode {
        /// The file.
        path: PathBuf,
        /// The decoder's words.
        reason: String,
    },
    /// Weights in a second file cannot be had.
    #[error(
        "{path}: the numbers of '{tensor}' are in a second file: expected {expected}, found {found}; keep both files in one folder, or \
         export the model as one file (torch.onnx.export(..., external_data=False))"
    )]
    External {
        /// The model's file.
        path: PathBuf,
        /// The constant.
        tensor: String,
        /// Which file, or how many bytes.
        expected: String,
        /// What is there.
        found: String,
    },
    /// The model uses another operator set.
    #[error("{path}: expected ONNX operator set {expected}, found {found}")]
    Opset {
        /// The file.
        path: PathBuf,
        /// What this reader knows.
        expected: i64,
        /// What the file says.
        found: String,
    },
    /// A metadata entry is missing.
    #[error("{path}: metadata has no '{key}'{}", if *.key == crate::CONTRACT_KEY { ": not a policy written by this program" } else { "" })]
    MissingMetadata {
        /// The file.
        path: PathBuf,
        /// The missing key.
        key: &'static str,
    },
    /// A metadata entry cannot be understood or contradicts the contract.
    #[error("{path}: metadata '{key}': {reason}")]
    Metadata {
        /// The file.
        path: PathBuf,
        /// The key.
        key: String,
        /// Expected and found.
        reason: String,
    },
    /// The contract is written in a later format and says what this program does not know.
    #[error(
        "{path}: it has format {found}, which is newer than this program's format {expected}, and cannot be read ({reason}); use the \
         program that wrote it"
    )]
    ContractFormat {
        /// The file.
        path: PathBuf,
        /// The known format.
        expected: u32,
        /// The file's.
        found: u64,
        /// What is not known.
        reason: String,
    },
    /// The contract is not the expected one.
    #[error("{path}: the policy's contract differs in {} place(s):\n  {}", .differences.len(), .differences.join("\n  "))]
    ContractDiffers {
        /// The file.
        path: PathBuf,
        /// One sentence per difference, with expected and found.
        differences: Vec<String>,
    },
    /// A tensor, input or output has another size than the contract says.
    #[error("{path}: {what}: expected {expected}, found {found}")]
    Shape {
        /// The file.
        path: PathBuf,
        /// The tensor, input or output.
        what: String,
        /// The expected shape.
        expected: String,
        /// The shape found.
        found: String,
    },
    /// The graph cannot be run.
    #[error("{path}: graph: {reason}")]
    Graph {
        /// The file.
        path: PathBuf,
        /// The runtime's words.
        reason: String,
    },
    /// Weights that do not form a network that fits the contract (on writing).
    #[error("policy cannot be exported: {0}")]
    Weights(String),
    /// An observation or state of the wrong size, or one with a number that is not finite (on acting).
    #[error("{what}: expected {expected}, found {found}")]
    Input {
        /// The argument.
        what: &'static str,
        /// What was expected.
        expected: String,
        /// What was given.
        found: String,
    },
}
