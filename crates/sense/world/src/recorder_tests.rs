//! What other programs need of a recording: names of joints, and the frames of the sensors.

use mcap::MessageStream;

use crate::cdr::CdrReader;
use crate::{Arrived, Believed, JointMessage, Message, OdometryState, Recorder, SightSetup, schema};

#[test]
fn joints_have_names_and_camera_and_lidar_hang_on_the_torso() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("named.mcap");
    let setup = SightSetup::g1().expect("the robot");
    let mut recorder = Recorder::create(&path, &setup).expect("a file");
    let joints = JointMessage { stamp_ns: 5, positions: vec![0.25; 29] };
    recorder.message(&Arrived { at_ns: 5, message: Message::Joints(joints) }).expect("written");
    let believed = Believed {
        at_ns: 7,
        torso: Some(paid_track::Pose::identity()),
        base: None,
        floor_m: None,
        ball: None,
        odometry: OdometryState::Tracking,
        picture: None,
    };
    recorder.believed(&believed).expect("written");
    recorder.finish().expect("written");
    let bytes = std::fs::read(&path).expect("a file");
    let mut seen = 0;
    for message in MessageStream::new(&bytes).expect("MCAP") {
        let message = message.expect("whole");
        let mut cdr = CdrReader::new(&message.data).expect("CDR");
        if message.channel.topic == schema::JOINTS.name {
            cdr.header().expect("a header");
            let names: Vec<String> =
                (0..cdr.length(5).expect("a list")).map(|_| cdr.string().expect("a name")).collect();
            assert_eq!((names.len(), names[0].as_str()), (29, "left_hip_pitch_joint"));
            assert_eq!(cdr.f64_list().expect("angles"), [0.25; 29]);
            seen += 1;
        }
        if message.channel.topic == schema::TRANSFORMS.name {
            let mut frames = Vec::new();
            for _ in 0..cdr.length(64).expect("a list") {
                let parent = cdr.header().expect("a header").1;
                let child = cdr.string().expect("a name");
                let [_, _, z] = cdr.f64s().expect("a place");
                let [x, _, _, _] = cdr.f64s().expect("a quaternion");
                frames.push((parent, child, z, x));
            }
            let names: Vec<[&str; 2]> = frames.iter().map(|f| [f.0.as_str(), f.1.as_str()]).collect();
            assert_eq!(
                names,
                [
                    ["odom", "torso_link"],
                    ["torso_link", "camera_color_optical_frame"],
                    ["torso_link", "livox_frame"]
                ]
            );
            // The LiDAR sits 0.41618 m above the torso's origin, turned half about x: x of its quaternion is cos(1.15 degrees).
            assert!((frames[2].2 - 0.41618).abs() < 1e-9 && (frames[2].3.abs() - 0.999_799).abs() < 1e-5);
            seen += 1;
        }
    }
    assert_eq!(seen, 2);
}
