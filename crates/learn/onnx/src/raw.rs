//! Any ONNX graph over float tensors.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use paid_policy::Contract;
use prost::Message;
use rten::{Model, NodeId, RunOptions, ThreadPool, Value, ValueOrView};

use crate::error::OnnxError;
use crate::proto::{ModelProto, ValueInfo};
use crate::read::check_metadata;
use crate::sizes::oversized;

/// A graph that was read from a file, with its metadata; runs on the calling thread.
pub struct RawModel {
    path: PathBuf,
    proto: ModelProto,
    model: Model,
    threads: Arc<ThreadPool>,
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
        let model = guarded(|| Model::load(bytes)).map_err(failed)?;
        if let Some(graph) = &mut proto.graph {
            // The runtime has its own copy of the constants.
            graph.initializer.clear();
            graph.node.clear();
        }
        // A policy is too small to gain from more than one thread.
        let threads = Arc::new(ThreadPool::with_num_threads(1));
        Ok(Self { path, proto, model, threads })
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
        let failed = |reason: String| OnnxError::Graph { path: self.path.clone(), reason };
        let node = |name: &str| self.model.node_id(name).map_err(|e| failed(one_line(&e)));
        let mut given: Vec<(NodeId, ValueOrView)> = Vec::with_capacity(inputs.len());
        for (name, shape, data) in inputs {
            let value = Value::from_shape(shape, data.to_vec()).map_err(|e| failed(one_line(&e)))?;
            given.push((node(name)?, value.into()));
        }
        let ids = outputs.iter().map(|(name, _)| node(name)).collect::<Result<Vec<_>, _>>()?;
        let options = RunOptions::default().with_thread_pool(Some(Arc::clone(&self.threads)));
        let values = guarded(|| self.model.run(given, &ids, Some(options))).map_err(failed)?;
        outputs
            .iter()
            .zip(values)
            .map(|(&(name, size), value)| match value.into_tensor::<f32>().map(|t| t.into_data()) {
                Some(data) if data.len() == size => Ok(data),
                Some(data) => {
                    Err(failed(format!("output '{name}' has {} numbers, expected {size}", data.len())))
                }
                None => Err(failed(format!("output '{name}' is no float tensor"))),
            })
            .collect()
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
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read or is no ONNX model.
    pub fn read(path: &Path) -> Result<Self, OnnxError> {
        let bytes = std::fs::read(path).map_err(|source| OnnxError::Io { path: path.to_owned(), source })?;
        Self::from_bytes(bytes, path)
    }

    /// As [`Self::read`], from a file's bytes; `path` only names them in errors.
    ///
    /// # Errors
    /// If they are no ONNX model.
    pub fn from_bytes(bytes: Vec<u8>, path: &Path) -> Result<Self, OnnxError> {
        let proto = decode(&bytes, path)?;
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

/// Decodes a file's bytes; `path` only names them.
fn decode(bytes: &[u8], path: &Path) -> Result<ModelProto, OnnxError> {
    let wrong = |reason: String| OnnxError::Decode { path: path.to_owned(), reason };
    let proto = ModelProto::decode(bytes).map_err(|e| wrong(e.to_string()))?;
    if proto.graph.is_none() {
        return Err(wrong("it has no graph".to_owned()));
    }
    Ok(proto)
}

/// Calls the runtime. It takes some numbers of a damaged file on trust and panics (rten 0.27); here that is an error like its others.
fn guarded<T, E: std::fmt::Display>(call: impl FnOnce() -> Result<T, E>) -> Result<T, String> {
    // What it was at work on is dropped, or belongs to this call alone.
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(result) => result.map_err(|error| one_line(&error)),
        Err(panic) => Err(format!("the runtime gave up: {}", said(&*panic))),
    }
}

/// The words of a panic as one line.
fn said(panic: &(dyn Any + Send)) -> String {
    let words = panic.downcast_ref::<String>().map(String::as_str);
    one_line(&words.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("without a word"))
}

/// An error of the runtime as one line.
pub(crate) fn one_line(error: &impl std::fmt::Display) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
