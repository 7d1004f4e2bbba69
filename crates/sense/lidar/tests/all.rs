//! The tests of `paid-lidar` as one program: one link instead of one a file. `cargo test -p paid-lidar --test all FILE::` runs a file's.

mod mutation;
mod odometry;
