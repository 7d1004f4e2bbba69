//! What a generated kick must be.

use super::*;

#[test]
fn look() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let control = spec.resolve(&model).unwrap();
    let t0 = std::time::Instant::now();
    for kick in builtin_kicks() {
        let made = match generate_kick(&model, &spec, &kick.request) {
            Ok(m) => m,
            Err(e) => {
                println!("{} {e}", kick.request.name);
                continue;
            }
        };
        let clip = &made.clip;
        let margins = made.margins();
        let worst = margins.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).unwrap();
        let foot = model.body_index(&spec.feet[clip.kick_leg.index()]).unwrap();
        let speed = Vec3(clip.body_lin_vel(made.contact_frame)[foot]).norm();
        let facts = crate::kick_facts(clip, &model, &spec).unwrap();
        let mut share = (0.0, 0, 0);
        let mut jump = (0.0, 0, 0);
        let mut over = (0.0, 0, 0);
        for t in 0..clip.frames {
            for j in 0..clip.joints {
                let s = clip.joint_vel(t)[j].abs() / control.velocity_limit[j];
                if s > share.0 {
                    share = (s, t, j)
                }
                let q = clip.joint_pos(t)[j];
                let [lo, hi] = model.joints[j].range;
                let o = (lo - q).max(q - hi);
                if t == 0 || o > over.0 {
                    over = (o, t, j)
                }
                if t > 0 && t + 1 < clip.frames {
                    let a = (clip.joint_pos(t + 1)[j] - 2.0 * q + clip.joint_pos(t - 1)[j]) * 2500.0;
                    if a.abs() > jump.0 {
                        jump = (a.abs(), t, j)
                    }
                }
            }
        }
        let name = |j: usize| model.joints[j].name.trim_end_matches("_joint").to_owned();
        println!(
            "{} T {} contact {} margin {:.4} at {} mean {:.4}; foot at ball {:.2} peak {:.2} at {}; speed share {:.2} {} at {}; acc {:.0} {} at {}; over {:.3} {} at {}; disp {:.4?} ball {:.4?}; low {:.4}",
            clip.name,
            clip.frames,
            made.contact_frame,
            worst.1,
            worst.0,
            margins.iter().sum::<f64>() / margins.len() as f64,
            speed,
            facts.peak_foot_speed,
            facts.kick_frame,
            share.0,
            name(share.2),
            share.1,
            jump.0,
            name(jump.2),
            jump.1,
            over.0,
            name(over.2),
            over.1,
            facts.anchor_displacement,
            made.ball,
            facts.lowest_point_m,
        );
        if let Ok(dir) = std::env::var("PAID_DUMP") {
            let mut text = String::new();
            for t in 0..clip.frames {
                let b = &made.balance[t];
                text += &format!(
                    "{t} m {:.4} zmp {:.3} {:.3} com {:.3} {:.3} {:.3} f {:.0} {:.0} {:.0} yaw {:.1} |",
                    margins[t],
                    b.zmp[0],
                    b.zmp[1],
                    b.com[0],
                    b.com[1],
                    b.com[2],
                    b.force[0],
                    b.force[1],
                    b.force[2],
                    b.yaw_moment
                );
                for side in 0..2 {
                    text +=
                        &format!(" {:.3?}", clip.body_pos(t)[model.body_index(&spec.feet[side]).unwrap()]);
                }
                text += &format!(" base {:.3?} |", clip.body_pos(t)[0]);
                for j in 0..15 {
                    text += &format!(" {:.3}", clip.joint_pos(t)[j]);
                }
                text += "\n";
            }
            let mut poses = String::new();
            for t in 0..clip.frames {
                for p in clip.body_pos(t) {
                    poses += &format!("{:.4} {:.4} {:.4} ", p[0], p[1], p[2]);
                }
                poses += "\n";
            }
            let parents: Vec<String> =
                model.bodies.iter().map(|b| b.parent.map_or("-1".into(), |p| p.to_string())).collect();
            std::fs::write(
                format!("{dir}/{}.pos", clip.name),
                format!(
                    "{} {} {} {}\n{}\n{poses}",
                    clip.fps,
                    made.contact_frame,
                    made.ball[0],
                    made.ball[1],
                    parents.join(" ")
                ),
            )
            .unwrap();
            std::fs::write(format!("{dir}/{}.txt", clip.name), text).unwrap();
        }
    }
    println!("{:?}", t0.elapsed());
}

#[test]
fn look_check() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let mut clips: Vec<Clip> = generate_builtin(&model, &spec).unwrap().into_iter().map(|k| k.clip).collect();
    let dir = std::path::Path::new("/work/shared/data/motions/paid");
    clips.extend(crate::MotionLibrary::load(dir, &model, &spec, 50.0).unwrap().clips);
    for clip in clips {
        let t0 = std::time::Instant::now();
        let r =
            crate::check::check_clip(&clip, &model, &spec, &crate::check::CheckLimits::default()).unwrap();
        let m = &r.measures;
        println!(
            "{} {} foot {:.2} speed {:.2} jump {:.2} range {:.3} pen {:.4} float {:.4} slide {:.3} over {:.3} inside {:.2} unb {:.2} margin {:.3} slip {:.2} shot {:.2} {:?}",
            r.name,
            r.verdict,
            m.foot_speed.value,
            m.joint_speed.value,
            m.joint_jump.value,
            m.joint_range.value,
            m.penetration_m.value,
            m.floating_m.value,
            m.sliding_m.value,
            m.overlap_m.value,
            m.pressure_inside,
            m.unbalanced,
            m.pressure_margin_m,
            m.slippery,
            m.shot_angle,
            t0.elapsed()
        );
        for f in r.findings {
            println!("    {:?} {} {:?} {}", f.aspect, f.verdict, f.frame, f.reason);
        }
    }
}
