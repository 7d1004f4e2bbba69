//! The ONNX runtime `rten`.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use rten::{Model, NodeId, RunOptions, ThreadPool, Value, ValueOrView};

/// A graph that is ready to run on the calling thread.
pub(crate) struct Runtime {
    model: Model,
    threads: Arc<ThreadPool>,
}

impl Runtime {
    /// Loads a file's bytes.
    ///
    /// # Errors
    /// Why the runtime cannot run it.
    pub fn new(bytes: Vec<u8>) -> Result<Self, String> {
        let model = guarded(|| Model::load(bytes))?;
        // A policy is too small to gain from more than one thread.
        Ok(Self { model, threads: Arc::new(ThreadPool::with_num_threads(1)) })
    }

    /// Values of the named outputs; each must have the given number of elements.
    ///
    /// # Errors
    /// If an input or output does not exist, the runtime fails, or an output has another size.
    pub fn run(
        &self,
        inputs: &[(&str, Vec<usize>, &[f32])],
        outputs: &[(&str, usize)],
    ) -> Result<Vec<Vec<f32>>, String> {
        let node = |name: &str| self.model.node_id(name).map_err(|e| one_line(&e));
        let mut given: Vec<(NodeId, ValueOrView)> = Vec::with_capacity(inputs.len());
        for (name, shape, data) in inputs {
            let value = Value::from_shape(shape, data.to_vec()).map_err(|e| one_line(&e))?;
            given.push((node(name)?, value.into()));
        }
        let ids = outputs.iter().map(|(name, _)| node(name)).collect::<Result<Vec<_>, _>>()?;
        let options = RunOptions::default().with_thread_pool(Some(Arc::clone(&self.threads)));
        let values = guarded(|| self.model.run(given, &ids, Some(options)))?;
        outputs
            .iter()
            .zip(values)
            .map(|(&(name, size), value)| match value.into_tensor::<f32>().map(|t| t.into_data()) {
                Some(data) if data.len() == size => Ok(data),
                Some(data) => Err(format!("output '{name}' has {} numbers, expected {size}", data.len())),
                None => Err(format!("output '{name}' is no float tensor")),
            })
            .collect()
    }
}

/// Calls the runtime. It does not check some numbers of a damaged file and panics (rten 0.27); here that is an error like its others.
fn guarded<T, E: std::fmt::Display>(call: impl FnOnce() -> Result<T, E>) -> Result<T, String> {
    // Its unfinished work is dropped, or belongs to this call alone.
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(result) => result.map_err(|error| one_line(&error)),
        Err(panic) => Err(format!("the runtime panicked: {}", said(&*panic))),
    }
}

/// The message of a panic as one line.
fn said(panic: &(dyn Any + Send)) -> String {
    let words = panic.downcast_ref::<String>().map(String::as_str);
    one_line(&words.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("without a message"))
}

/// An error of the runtime as one line.
fn one_line(error: &impl std::fmt::Display) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
