//! Any ONNX graph over float tensors.

use std::path::{Path, PathBuf};

use paid_files::{GIT_LFS_POINTER, is_git_lfs_pointer};
use paid_policy::Contract;
use prost::Message;

use crate::error::OnnxError;
use crate::external;
use crate::proto::{ModelProto, ValueInfo};
use crate::read::check_metadata;
use crate::runtime::Runtime;
use crate::sizes::oversized;

/// A graph that was read from a file, with its metadata; runs on the calling thread.
pub struct RawModel {
    path: PathBuf,
    proto: ModelProto,
    runtime: Runtime,
}

impl std::fmt::Debug for RawModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RawModel").field("path", &self.path).finish_non_exhaustive()
    }
}

impl RawModel {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, is no ONNX model, or has an operator that the runtime lacks.
    pub fn load(path: &Path) -> Result<Self, OnnxError> {
        Self::new(OnnxFile::read(path)?)
    }

    /// The runtime of a file that was read.
    ///
    /// # Errors
    /// If it has an operator that the runtime lacks, or the runtime fails.
    pub fn new(file: OnnxFile) -> Result<Self, OnnxError> {
        let OnnxFile { path, bytes, mut proto } = file;
        let failed = |reason: String| OnnxError::Graph { path: path.clone(), reason };
        if let Some(reason) = proto.graph.as_ref().and_then(oversized) {
            return Err(failed(reason));
        }
        let runtime = Runtime::new(bytes).map_err(failed)?;
        if let Some(graph) = &mut proto.graph {
            // The runtime has its own copy of the constants.
            graph.initializer.clear();
            graph.node.clear();
        }
        Ok(Self { path, proto, runtime })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A metadata entry.
    pub fn metadata(&self, key: &str) -> Option<&str> {
        self.proto.metadata(key)
    }

    /// Shape of an input or output: outer `None` if there is none of this name, inner `None` if it has no fixed shape.
    pub fn shape(&self, name: &str) -> Option<Option<Vec<i64>>> {
        self.proto.value(name).map(ValueInfo::shape)
    }

    /// Values of the named outputs; each must have the given number of elements.
    ///
    /// # Errors
    /// If an input or output does not exist, the runtime fails, or an output has another size.
    pub fn run(
        &self,
        inputs: &[(&str, Vec<usize>, &[f32])],
        outputs: &[(&str, usize)],
    ) -> Result<Vec<Vec<f32>>, OnnxError> {
        let failed = |reason| OnnxError::Graph { path: self.path.clone(), reason };
        self.runtime.run(inputs, outputs).map_err(failed)
    }
}

/// A file that was read and decoded, before it is decided what it is.
#[derive(Clone)]
pub struct OnnxFile {
    pub(crate) path: PathBuf,
    bytes: Vec<u8>,
    pub(crate) proto: ModelProto,
}

impl std::fmt::Debug for OnnxFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OnnxFile").field("path", &self.path).finish_non_exhaustive()
    }
}

impl OnnxFile {
    /// Reads a file, and the files of weights that it names.
    ///
    /// # Errors
    /// If it cannot be read or is no ONNX model, or a file of weights is missing, too short, or not in the file's folder or below.
    pub fn read(path: &Path) -> Result<Self, OnnxError> {
        let bytes = std::fs::read(path).map_err(|source| OnnxError::Io { path: path.to_owned(), source })?;
        Self::new(bytes, path, Some(path.parent().unwrap_or(Path::new(""))))
    }

    /// As [`Self::read`], from a file's bytes; `path` only names them in errors.
    ///
    /// # Errors
    /// If they are no ONNX model, or name a file of weights.
    pub fn from_bytes(bytes: Vec<u8>, path: &Path) -> Result<Self, OnnxError> {
        Self::new(bytes, path, None)
    }

    fn new(bytes: Vec<u8>, path: &Path, folder: Option<&Path>) -> Result<Self, OnnxError> {
        let mut proto = decode(&bytes, path)?;
        let bytes = match external::inlined(&bytes, path, folder)? {
            Some(whole) => {
                proto = decode(&whole, path)?;
                whole
            }
            None => bytes,
        };
        Ok(Self { path: path.to_owned(), bytes, proto })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A metadata entry.
    pub fn metadata(&self, key: &str) -> Option<&str> {
        self.proto.metadata(key)
    }

    /// What the file says about itself, if it was written by this program.
    ///
    /// # Errors
    /// If its metadata is incomplete, of another format, or contradicts itself.
    pub fn contract(&self) -> Result<Contract, OnnxError> {
        check_metadata(&self.proto, &self.path)
    }

    /// Names and types of the inputs.
    pub fn inputs(&self) -> &[ValueInfo] {
        self.proto.graph.as_ref().map_or(&[], |graph| &graph.input)
    }

    /// Names and types of the outputs.
    pub fn outputs(&self) -> &[ValueInfo] {
        self.proto.graph.as_ref().map_or(&[], |graph| &graph.output)
    }

    /// Size of the last dimension of an input or output, if it is fixed.
    pub fn width(&self, name: &str) -> Option<usize> {
        let shape = self.proto.value(name)?.r#type.as_ref()?.tensor_type.as_ref()?.shape.as_ref()?;
        shape.dim.last()?.dim_value.and_then(|d| usize::try_from(d).ok())
    }
}

/// What is said of a file that Git LFS has left as a pointer.
pub(crate) fn pointer(bytes: &[u8]) -> Option<String> {
    is_git_lfs_pointer(bytes).then(|| GIT_LFS_POINTER.join("; "))
}

/// Decodes a file's bytes; `path` only names them.
fn decode(bytes: &[u8], path: &Path) -> Result<ModelProto, OnnxError> {
    let wrong = |reason: String| OnnxError::Decode { path: path.to_owned(), reason };
    if let Some(words) = pointer(bytes) {
        return Err(wrong(words));
    }
    let proto = ModelProto::decode(bytes).map_err(|e| wrong(e.to_string()))?;
    if proto.graph.is_none() {
        return Err(wrong("it has no graph".to_owned()));
    }
    Ok(proto)
}
