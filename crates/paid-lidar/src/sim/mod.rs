//! A simulated Mid-360 in simple scenes: what the odometry is measured with where there is no robot.

mod body;
mod measure;
mod pattern;
mod pose_list;
mod scene;
mod sensor;
mod walk;

pub use body::Capsule;
pub use measure::{Fault, MeasureOptions, Report, measure};
pub use pattern::Pattern;
pub use pose_list::PoseList;
pub use scene::{Scene, SceneKind};
pub use sensor::{Frame, SensorModel, SimulatedMid360};
pub use walk::{Trajectory, Walk};
