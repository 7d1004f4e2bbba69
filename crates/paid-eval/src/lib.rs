//! Evaluation protocols, metrics, tables.
