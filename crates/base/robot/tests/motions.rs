//! Forward kinematics against the motion files.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use paid_lanes::{Quat, Vec3};
use paid_robot::kinematics::{forward, forward_velocity, origin_velocity};
use paid_robot::{RobotModel, RobotSpec, WorldAngVel};
use zip::ZipArchive;

/// An array of a motion file, row-major.
fn array(archive: &mut ZipArchive<File>, key: &str) -> Vec<f64> {
    let mut bytes = Vec::new();
    archive.by_name(&format!("{key}.npy")).expect(key).read_to_end(&mut bytes).expect(key);
    let file = npyz::NpyFile::new(&bytes[..]).expect(key);
    file.into_vec::<f32>().expect(key).into_iter().map(f64::from).collect()
}

fn npz_below(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            npz_below(&path, found);
        } else if path.extension().is_some_and(|e| e == "npz") {
            found.push(path);
        }
    }
}

fn three(values: &[f64], i: usize) -> Vec3<f64> {
    Vec3([values[3 * i], values[3 * i + 1], values[3 * i + 2]])
}

/// A file's frames in model order.
struct Motion {
    frames: usize,
    joint_pos: Vec<Vec<f64>>,
    joint_vel: Vec<Vec<f64>>,
    pos: Vec<Vec<Vec3<f64>>>,
    quat: Vec<Vec<Quat<f64>>>,
    com_vel: Vec<Vec<Vec3<f64>>>,
    ang_vel: Vec<Vec<Vec3<f64>>>,
}

fn read(path: &Path, model: &RobotModel, spec: &RobotSpec) -> Motion {
    let at = spec.indices(model).unwrap();
    let mut archive = ZipArchive::new(File::open(path).unwrap()).unwrap();
    let (joints, bodies) = (model.joints.len(), model.bodies.len());
    let mut joint_rows = |key| -> Vec<Vec<f64>> {
        array(&mut archive, key).chunks_exact(joints).map(|row| at.model_from_policy.apply(row)).collect()
    };
    let (joint_pos, joint_vel) = (joint_rows("joint_pos"), joint_rows("joint_vel"));
    let mut vectors = |key| -> Vec<Vec<Vec3<f64>>> {
        array(&mut archive, key)
            .chunks_exact(3 * bodies)
            .map(|row| {
                at.model_from_motion_bodies.apply(&(0..bodies).map(|b| three(row, b)).collect::<Vec<_>>())
            })
            .collect()
    };
    let (pos, com_vel, ang_vel) =
        (vectors("body_pos_w"), vectors("body_lin_vel_w"), vectors("body_ang_vel_w"));
    let quat = array(&mut archive, "body_quat_w")
        .chunks_exact(4 * bodies)
        .map(|row| {
            let quats: Vec<_> =
                row.chunks_exact(4).map(|q| Quat([q[0], q[1], q[2], q[3]]).normalize()).collect();
            at.model_from_motion_bodies.apply(&quats)
        })
        .collect();
    Motion { frames: joint_pos.len(), joint_pos, joint_vel, pos, quat, com_vel, ang_vel }
}

/// The motion files, or `None` (the test is skipped).
fn motions(test: &str) -> Option<Vec<(String, Motion)>> {
    let folder = paid_testing::shared_data(test, "data/motions")?;
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let mut paths = Vec::new();
    npz_below(&folder, &mut paths);
    assert!(paths.len() >= 13, "the motion files are there");
    let name = |p: &Path| p.file_name().unwrap().to_string_lossy().into_owned();
    Some(paths.iter().map(|p| (name(p), read(p, &model, &spec))).collect())
}

#[test]
fn every_body_of_every_motion_file_is_where_its_joints_put_it() {
    let Some(motions) = motions("every_body_of_every_motion_file_is_where_its_joints_put_it") else { return };
    let model = RobotModel::g1();
    for (name, m) in &motions {
        let (mut worst, mut turned) = (0.0_f64, 0.0_f64);
        for t in 0..m.frames {
            let poses = forward(&model, m.pos[t][0], m.quat[t][0], &m.joint_pos[t]);
            for (b, pose) in poses.iter().enumerate() {
                worst = worst.max((pose.pos - m.pos[t][b]).norm());
                turned = turned.max(pose.quat.conj().mul(m.quat[t][b]).to_mat().angle());
            }
        }
        println!(
            "{name}: {} frames, worst position {worst:.1e} m, worst orientation {turned:.1e} rad",
            m.frames
        );
        assert!(worst < 1e-5, "{name}: {worst} m");
        assert!(turned < 1e-4, "{name}: {turned} rad");
    }
}

#[test]
fn velocities_of_the_motion_files_are_those_of_centers_of_mass() {
    let Some(motions) = motions("velocities_of_the_motion_files_are_those_of_centers_of_mass") else {
        return;
    };
    let model = RobotModel::g1();
    for (name, m) in &motions {
        let (mut lin, mut ang, mut n) = (0.0, 0.0, 0.0);
        for t in 0..m.frames {
            let poses = forward(&model, m.pos[t][0], m.quat[t][0], &m.joint_pos[t]);
            let base_ang = WorldAngVel(m.ang_vel[t][0]);
            let base_lin = origin_velocity(&model, 0, &poses[0], m.com_vel[t][0], base_ang);
            let velocities = forward_velocity(&model, &poses, base_lin, base_ang, &m.joint_vel[t]);
            for (b, v) in velocities.iter().enumerate() {
                lin += (v.com - m.com_vel[t][b]).norm2();
                ang += (v.ang.0 - m.ang_vel[t][b]).norm2();
                n += 1.0;
            }
        }
        let (lin, ang) = ((lin / n).sqrt(), (ang / n).sqrt());
        println!("{name}: rms difference {lin:.1e} m/s, {ang:.1e} rad/s");
        assert!(lin < 1e-4, "{name}: {lin} m/s");
        assert!(ang < 1e-4, "{name}: {ang} rad/s");
    }
}
