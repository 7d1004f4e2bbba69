//! A human made of numbers, in LAFAN1's names and axes: stands, and swings its right leg.

use std::fmt::Write as _;

/// The text of a BVH file of `frames` frames at 60 Hz. Each bone has rotation channels Z, Y, X; its resting angles [degrees] put the
/// bones' x axes up the trunk, down the limbs and forward in the feet.
pub fn kick_bvh(frames: usize) -> String {
    // Depth, name, offset [cm], resting angles.
    type Line = (usize, &'static str, [f64; 3], [f64; 3]);
    let bones: [Line; 16] = [
        (0, "Hips", [0.0; 3], [90.0, 0.0, 90.0]),
        (1, "LeftUpLeg", [0.0, 0.0, 9.0], [0.0, 180.0, 0.0]),
        (2, "LeftLeg", [42.0, 0.0, 0.0], [0.0; 3]),
        (3, "LeftFoot", [42.0, 0.0, 0.0], [90.0, 0.0, 0.0]),
        (4, "LeftToe", [14.0, -6.0, 0.0], [0.0; 3]),
        (1, "RightUpLeg", [0.0, 0.0, -9.0], [0.0, 180.0, 0.0]),
        (2, "RightLeg", [42.0, 0.0, 0.0], [0.0; 3]),
        (3, "RightFoot", [42.0, 0.0, 0.0], [90.0, 0.0, 0.0]),
        (4, "RightToe", [14.0, -6.0, 0.0], [0.0; 3]),
        (1, "Spine2", [30.0, 0.0, 0.0], [0.0; 3]),
        (2, "LeftArm", [18.0, 0.0, 18.0], [180.0, 0.0, 0.0]),
        (3, "LeftForeArm", [28.0, 0.0, 0.0], [-90.0, 0.0, 0.0]),
        (4, "LeftHand", [26.0, 0.0, 0.0], [0.0; 3]),
        (2, "RightArm", [18.0, 0.0, -18.0], [180.0, 0.0, 0.0]),
        (3, "RightForeArm", [28.0, 0.0, 0.0], [-90.0, 0.0, 0.0]),
        (4, "RightHand", [26.0, 0.0, 0.0], [0.0; 3]),
    ];
    let mut text = String::from("HIERARCHY\n");
    for (i, (depth, name, [x, y, z], _)) in bones.iter().enumerate() {
        let (word, moves) = if i == 0 { ("ROOT", "6 Xposition Yposition Zposition") } else { ("JOINT", "3") };
        let _ = writeln!(
            text,
            "{word} {name}\n{{\nOFFSET {x} {y} {z}\nCHANNELS {moves} Zrotation Yrotation Xrotation"
        );
        let next = bones.get(i + 1).map_or(0, |b| b.0);
        if next <= *depth {
            text += "End Site\n{\nOFFSET 5 0 0\n}\n";
        }
        for _ in next..=*depth {
            text += "}\n";
        }
    }
    // The loop above closes the root twice less once: the last bone's `next` is 0.
    let _ = write!(text, "MOTION\nFrames: {frames}\nFrame Time: 0.0166667\n");
    for t in 0..frames {
        let time = t as f64 / 60.0;
        // Back by 30 degrees, then forward by 60, between 0.5 and 1.5 s.
        let phase = ((time - 0.5) * std::f64::consts::TAU).clamp(0.0, std::f64::consts::TAU);
        let swing = 45.0 * phase.sin() * (1.0 - 0.3 * phase.cos());
        let _ = write!(text, "0 94 0");
        for (_, name, _, [z, y, x]) in &bones {
            let z = if *name == "RightUpLeg" { z + swing } else { *z };
            let _ = write!(text, " {z:.4} {y} {x}");
        }
        text.push('\n');
    }
    text
}
