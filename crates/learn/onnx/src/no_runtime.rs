//! In the place of the runtime, in a program that was built without it.

/// There is none: no value of this type exists.
pub(crate) enum Runtime {}

impl Runtime {
    /// Refuses.
    ///
    /// # Errors
    /// Always: what to do.
    pub fn new(_bytes: Vec<u8>) -> Result<Self, String> {
        Err("this program was built without the ONNX runtime that such files need; build it with --features full".to_owned())
    }

    /// Cannot be called.
    ///
    /// # Errors
    /// None.
    pub fn run(
        &self,
        _inputs: &[(&str, Vec<usize>, &[f32])],
        _outputs: &[(&str, usize)],
    ) -> Result<Vec<Vec<f32>>, String> {
        match *self {}
    }
}
