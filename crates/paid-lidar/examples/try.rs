//! Scratch.
use paid_lidar::sim::*;
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    s.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let kind: SceneKind = a[1].parse().unwrap();
    let mut o = MeasureOptions::new(kind, a[2].parse().unwrap(), a[3].parse().unwrap());
    for kv in &a[4..] {
        let (k, v) = kv.split_once('=').unwrap();
        let v: f64 = v.parse().unwrap();
        let c = &mut o.config;
        let at = 10.0;
        match k {
            "pts" => o.model.points_per_s = v,
            "gyro" => c.imu_noise.gyro = v,
            "accel" => c.imu_noise.accel = v,
            "gb" => c.imu_noise.gyro_bias = v,
            "ab" => c.imu_noise.accel_bias = v,
            "r" => c.plane_variance = v,
            "sv" => c.scan_voxel_m = v,
            "mv" => c.map_voxel_m = v,
            "face" => c.facing_planes = v,
            "off" => o.model.imu_offset_s = v,
            "thick" => c.plane_thickness_m = v,
            "it" => c.iterations = v as usize,
            "sat" => c.saturated_variance = v,
            "covered" => o.fault = Some((at, Fault::Covered(v))),
            "kidnap" => o.fault = Some((at, Fault::Kidnapped(nalgebra::Vector3::new(v, 0.3 * v, 0.0)))),
            "late" => o.fault = Some((at, Fault::Late(v, 1.0))),
            "gap" => o.fault = Some((at, Fault::ImuGap(v))),
            "back" => o.fault = Some((at, Fault::Backwards(v))),
            "silent" => o.fault = Some((at, Fault::Silent(v))),
            _ => panic!("{k}"),
        }
    }
    let t = cpu();
    let r = measure(&o, &cpu).unwrap();
    println!("{} {:?} rms {:.4} max {:.4} rot {:.3}/{:.3} deg v {:.3} | scans {} track {} deg {} lost {} | x{:.1} map {} {:.1} MB total {:.1}s",
        a[1], &a[4..], r.position_rms_m, r.position_max_m, r.rotation_rms_deg, r.rotation_max_deg, r.velocity_rms, r.scans, r.tracking, r.degenerate, r.lost, r.times_real_time, r.map_points, r.map_mb, cpu() - t);
    if r.degenerate > 0 { println!("   dir {:?} across {:?} along {:?} dev {:?}", r.direction, r.across_rms_m, r.along_error_m, r.along_deviation_m); }
    if o.fault.is_some() { println!("   said {:?} recovered {:?}", r.fault_said_after_s, r.fault_recovered_after_s); }
    for s in r.said.iter().skip(1).take(6) { println!("   {:.1} {}", s.0, s.1); }
}
