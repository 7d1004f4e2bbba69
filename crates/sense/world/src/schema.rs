//! Topics of a recording and the definitions of their messages, as ROS 2 has them.

/// A topic.
pub(crate) struct Topic {
    pub name: &'static str,
    /// Package and type.
    pub schema: &'static str,
    /// Definitions: of the type itself, then of those that it refers to, each behind a line of `=`.
    pub definition: &'static str,
}

macro_rules! with_header {
    ($own:literal $(, $name:literal: $part:literal)*) => {
        concat!(
            "std_msgs/Header header\n", $own,
            "================================================================================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n",
            "================================================================================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
            $("================================================================================\nMSG: ", $name, "\n", $part,)*
        )
    };
}

const IMAGE: &str = with_header!(
    "uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n"
);

pub(crate) const COLOR: Topic =
    Topic { name: "/camera/color/image_raw", schema: "sensor_msgs/msg/Image", definition: IMAGE };
pub(crate) const DEPTH: Topic = Topic {
    name: "/camera/aligned_depth_to_color/image_raw",
    schema: "sensor_msgs/msg/Image",
    definition: IMAGE,
};
pub(crate) const CAMERA: Topic = Topic {
    name: "/camera/color/camera_info",
    schema: "sensor_msgs/msg/CameraInfo",
    definition: with_header!(
        "uint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n",
        "sensor_msgs/RegionOfInterest": "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"
    ),
};
pub(crate) const BOXES: Topic = Topic {
    name: "/camera/boxes",
    schema: "paid_msgs/msg/Boxes",
    definition: with_header!("# left, top, right and bottom side of every box in pixels\nfloat64[] sides\n"),
};
pub(crate) const IMU: Topic = Topic {
    name: "/livox/imu",
    schema: "sensor_msgs/msg/Imu",
    definition: with_header!(
        "geometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n",
        "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
        "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n"
    ),
};
pub(crate) const LIDAR: Topic = Topic {
    name: "/livox/lidar",
    schema: "sensor_msgs/msg/PointCloud2",
    definition: with_header!(
        "uint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
        "sensor_msgs/PointField": "string name\nuint32 offset\nuint8 datatype\nuint32 count\n"
    ),
};
pub(crate) const JOINTS: Topic = Topic {
    name: "/joint_states",
    schema: "sensor_msgs/msg/JointState",
    definition: with_header!("string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"),
};
pub(crate) const ODOMETRY: Topic = Topic {
    name: "/odometry",
    schema: "nav_msgs/msg/Odometry",
    definition: with_header!(
        "string child_frame_id\ngeometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n",
        "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance\n",
        "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist\nfloat64[36] covariance\n",
        "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
        "geometry_msgs/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
        "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z\n",
        "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
        "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n"
    ),
};
pub(crate) const TRANSFORMS: Topic = Topic {
    name: "/tf",
    schema: "tf2_msgs/msg/TFMessage",
    definition: concat!(
        "geometry_msgs/TransformStamped[] transforms\n",
        "================================================================================\nMSG: geometry_msgs/TransformStamped\n",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
        "================================================================================\nMSG: geometry_msgs/Transform\n",
        "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
        "================================================================================\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n",
        "================================================================================\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
        "================================================================================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n",
        "================================================================================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
    ),
};
pub(crate) const STEP: Topic = Topic {
    name: "/paid/step",
    schema: "paid_msgs/msg/Step",
    definition: "# time until the motion strikes in seconds; infinite before one is chosen\nfloat64 to_strike\n",
};
pub(crate) const SETUP: Topic =
    Topic { name: "/paid/setup", schema: "std_msgs/msg/String", definition: "string data\n" };
pub(crate) const BELIEVED: Topic = Topic {
    name: "/paid/believed",
    schema: "paid_msgs/msg/Believed",
    definition: with_header!(
        "# the torso in the odometry frame: rows of its rotation, place in meters; empty while it is not known\nfloat64[] torso\n# height of the floor in meters; empty while it is not known\nfloat64[] floor\n# the own ball: position (m), velocity (m/s), covariance (pp, pv, vv), probability of rest, age (s); empty without one\nfloat64[] ball\n# seen, remembered, lost, or empty\nstring state\nuint32 id\nstring odometry\nstring picture\n"
    ),
};
pub(crate) const BALL: Topic = Topic {
    name: "/paid/ball",
    schema: "geometry_msgs/msg/PointStamped",
    definition: with_header!(
        "geometry_msgs/Point point\n",
        "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z\n"
    ),
};

/// All of them, in the order of their channels.
pub(crate) const ALL: [&Topic; 13] = [
    &SETUP,
    &CAMERA,
    &DEPTH,
    &BOXES,
    &COLOR,
    &IMU,
    &LIDAR,
    &JOINTS,
    &ODOMETRY,
    &TRANSFORMS,
    &STEP,
    &BELIEVED,
    &BALL,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_that_a_definition_refers_to_is_defined_in_it() {
        for topic in ALL {
            for line in topic.definition.lines().filter(|line| !line.starts_with(['#', '='])) {
                let Some((kind, _)) = line.split_once(' ') else { continue };
                let kind = kind.split('[').next().unwrap_or(kind);
                if kind.contains('/') && !line.starts_with("MSG:") {
                    let named = format!("MSG: {kind}\n");
                    assert!(topic.definition.contains(&named), "{}: {kind}", topic.name);
                }
            }
        }
        assert!(with_header!("").contains("int32 sec\nuint32 nanosec\n"));
    }
}
