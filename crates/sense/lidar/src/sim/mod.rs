//! A simulated Mid-360 in simple scenes: what the odometry is measured with where there is no robot.

mod body;
mod boxes;
mod device;
mod fault;
mod measure;
mod pattern;
mod pose_list;
mod scene;
mod sensor;
mod stream;
mod walk;

pub use body::Capsule;
pub use device::{Device, SensorModel};
pub use fault::{Fault, FaultKind};
pub use measure::{MeasureOptions, Report, measure};
pub use pattern::Pattern;
pub use pose_list::PoseList;
pub use scene::{Scene, SceneKind};
pub use sensor::{Frame, SimulatedMid360};
pub use stream::PacketWriter;
pub use walk::{Trajectory, Walk};
