//! Human motion onto the robot.
//!
//! A file of human motion ([`read_human`]: BVH, ASF with AMC, or positions of points with a description of the skeleton) gives a [`Skeleton`] and its angles; forward kinematics makes a
//! [`HumanMotion`] of them: positions and orientations of all bones, world, meters, z up. [`retarget`] scales it, turns it into
//! goals for bodies of the robot (a [`Table`]) and finds the joint angles that meet them best, frame by frame, within the joints'
//! ranges and speeds. The result is a [`paid_motion::Clip`].
//!
//! The method and the tables are those of GMR (General Motion Retargeting, arXiv 2510.02252); the solver is our own.
//!
//! A person of two bones, in centimeters with y up, comes out in meters with z up:
//!
//! ```
//! use paid_retarget::parse_bvh;
//!
//! let text = "HIERARCHY
//! ROOT Hips
//! {
//!   OFFSET 0 0 0
//!   CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
//!   JOINT Head
//!   {
//!     OFFSET 0 60 0
//!     CHANNELS 3 Zrotation Xrotation Yrotation
//!     End Site
//!     {
//!       OFFSET 0 10 0
//!     }
//!   }
//! }
//! MOTION
//! Frames: 2
//! Frame Time: 0.04
//! 0 90 0 0 0 0 0 0 0
//! 0 95 0 0 0 0 0 0 0
//! ";
//! let person = parse_bvh(text, "person.bvh".as_ref(), 0.01)?;
//! let head = person.skeleton.find("Head").expect("a bone");
//! assert_eq!((person.frames, person.fps), (2, 25.0));
//! assert!((person.pos(0)[head][2] - 1.5).abs() < 1e-9);
//! # Ok::<(), paid_retarget::RetargetError>(())
//! ```

mod amc_text;
mod asf;
mod axes;
mod boxed;
mod bvh;
mod bvh_text;
mod ends;
mod error;
mod files;
mod goals;
mod human;
mod ik;
mod local;
mod points;
mod recognize;
mod retarget;
mod roles;
mod skeleton;
mod table;
#[cfg(test)]
mod testing;
mod text;
mod words;

pub use amc_text::amc_texts;
pub use asf::{parse_amc, parse_asf};
pub use boxed::BoxedSystem;
pub use bvh::parse_bvh;
pub use bvh_text::bvh_text;
pub use ends::{EndDistance, Ends};
pub use error::{RetargetError, Setting};
pub use files::{HumanOptions, is_human_file, read_human};
pub use goals::{Goal, Goals};
pub use human::HumanMotion;
pub use ik::{Pose, SolveLimits, Solved, Solver};
pub use local::TEXT_UNIT_M;
pub use points::{PointSkeleton, motion_of_points, parse_skeleton};
pub use retarget::{Report, RetargetOptions, Retargeted, TimeScale, retarget};
pub use roles::{Naming, Role, RoleSource};
pub use skeleton::{Bone, BonePose, Skeleton};
pub use table::{BodyTask, Table};
