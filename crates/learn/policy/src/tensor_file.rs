//! Named tensors in a safetensors file.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use safetensors::tensor::{Dtype, SafeTensors, TensorView};

use crate::CheckpointError;

/// A tensor as bytes, little-endian.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensor {
    /// Element type.
    pub dtype: Dtype,
    /// Shape.
    pub shape: Vec<usize>,
    /// Elements.
    pub data: Vec<u8>,
}

impl Tensor {
    /// Replaces the elements, in the tensor's precision.
    pub fn set_numbers(&mut self, values: impl Iterator<Item = f64>) {
        self.data = match self.dtype {
            Dtype::F64 => values.flat_map(f64::to_le_bytes).collect(),
            _ => values.flat_map(|x| (x as f32).to_le_bytes()).collect(),
        };
    }
}

/// All tensors and metadata of a file.
#[derive(Clone, Debug, Default)]
pub struct TensorFile {
    /// Where it is or will be; of bytes that came another way, what errors call them.
    pub path: PathBuf,
    /// Tensors by name.
    pub tensors: BTreeMap<String, Tensor>,
    /// Text by name.
    pub metadata: BTreeMap<String, String>,
}

macro_rules! numbers {
    ($read:ident, $put:ident, $type:ty, $dtype:expr) => {
        /// Elements of a tensor after checking type, shape and that they are finite.
        ///
        /// # Errors
        /// Naming the tensor, what was expected and what was found.
        pub fn $read(&self, name: &str, shape: &[usize]) -> Result<Vec<$type>, CheckpointError> {
            let data = &self.checked(name, $dtype, shape)?.data;
            let chunks = data.chunks_exact(size_of::<$type>());
            let values: Vec<$type> = chunks
                .map(|chunk| {
                    let mut word = [0; size_of::<$type>()];
                    word.copy_from_slice(chunk);
                    <$type>::from_le_bytes(word)
                })
                .collect();
            if let Some(k) = values.iter().position(|x| !(*x as f64).is_finite()) {
                let reason =
                    format!("tensor {name}: element {k}: expected a finite number, found {}", values[k]);
                return Err(CheckpointError::Format { path: self.path.clone(), reason });
            }
            Ok(values)
        }

        /// Adds a tensor.
        pub fn $put(&mut self, name: impl Into<String>, shape: &[usize], values: &[$type]) {
            let data = values.iter().flat_map(|x| x.to_le_bytes()).collect();
            self.tensors.insert(name.into(), Tensor { dtype: $dtype, shape: shape.to_vec(), data });
        }
    };
}

impl TensorFile {
    numbers!(f32s, put_f32s, f32, Dtype::F32);
    numbers!(f64s, put_f64s, f64, Dtype::F64);
    numbers!(u64s, put_u64s, u64, Dtype::U64);

    /// Elements of a tensor of single or double precision, as [`TensorFile::f32s`] and [`TensorFile::f64s`].
    ///
    /// # Errors
    /// Naming the tensor, what was expected and what was found.
    pub fn numbers(&self, name: &str, shape: &[usize]) -> Result<Vec<f64>, CheckpointError> {
        if self.tensors.get(name).is_some_and(|tensor| tensor.dtype == Dtype::F64) {
            return self.f64s(name, shape);
        }
        Ok(self.f32s(name, shape)?.into_iter().map(f64::from).collect())
    }

    /// Adds bytes.
    pub fn put_bytes(&mut self, name: impl Into<String>, bytes: &[u8]) {
        let tensor = Tensor { dtype: Dtype::U8, shape: vec![bytes.len()], data: bytes.to_vec() };
        self.tensors.insert(name.into(), tensor);
    }

    fn checked(&self, name: &str, dtype: Dtype, shape: &[usize]) -> Result<&Tensor, CheckpointError> {
        let tensor = self.tensors.get(name);
        match tensor {
            Some(tensor) if tensor.dtype == dtype && tensor.shape == shape => Ok(tensor),
            _ => Err(CheckpointError::Tensor {
                path: self.path.clone(),
                tensor: name.to_owned(),
                expected: format!("{dtype:?} {shape:?}"),
                found: tensor.map_or("none".to_owned(), |t| format!("{:?} {:?}", t.dtype, t.shape)),
            }),
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read or is not in the safetensors format.
    pub fn load(path: &Path) -> Result<Self, CheckpointError> {
        let bytes = fs::read(path).map_err(|source| CheckpointError::Io {
            path: path.to_owned(),
            action: "read",
            source,
        })?;
        Self::from_bytes(&bytes, path)
    }

    /// As [`TensorFile::load`], from a file's bytes; `path` only names them in errors.
    ///
    /// # Errors
    /// If they are not in the safetensors format.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, CheckpointError> {
        let wrong = |error: safetensors::SafeTensorError| CheckpointError::Format {
            path: path.to_owned(),
            reason: error.to_string(),
        };
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(wrong)?;
        let parsed = SafeTensors::deserialize(bytes).map_err(wrong)?;
        let mut file = Self { path: path.to_owned(), ..Self::default() };
        for (name, view) in parsed.iter() {
            let tensor =
                Tensor { dtype: view.dtype(), shape: view.shape().to_vec(), data: view.data().to_vec() };
            file.tensors.insert(name.to_owned(), tensor);
        }
        if let Some(metadata) = header.metadata() {
            file.metadata.extend(metadata.iter().map(|(key, value)| (key.clone(), value.clone())));
        }
        Ok(file)
    }

    /// The file's bytes.
    ///
    /// # Errors
    /// If a tensor's bytes do not fit its shape.
    pub fn to_bytes(&self) -> Result<Vec<u8>, CheckpointError> {
        let wrong = |error: safetensors::SafeTensorError| CheckpointError::Format {
            path: self.path.clone(),
            reason: error.to_string(),
        };
        let mut views = Vec::new();
        for (name, tensor) in &self.tensors {
            let view = TensorView::new(tensor.dtype, tensor.shape.clone(), &tensor.data).map_err(wrong)?;
            views.push((name.as_str(), view));
        }
        let metadata: HashMap<String, String> =
            self.metadata.iter().map(|(key, value)| (key.clone(), value.clone())).collect();
        safetensors::serialize(views, Some(metadata)).map_err(wrong)
    }

    /// Writes the file under its path; an older one stays whole if this fails.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn save(&self) -> Result<(), CheckpointError> {
        paid_files::write_atomically(&self.path, &self.to_bytes()?).map_err(|source| CheckpointError::Io {
            path: self.path.clone(),
            action: "write",
            source,
        })
    }
}
