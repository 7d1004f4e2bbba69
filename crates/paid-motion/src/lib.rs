//! Motion clips and libraries: file formats, resampling, checks.
