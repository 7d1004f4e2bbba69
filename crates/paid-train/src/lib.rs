//! Rollout workers, stages, logging, resume.
