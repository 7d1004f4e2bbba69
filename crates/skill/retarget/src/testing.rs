//! Random human motions and how they differ.

use std::path::Path;

use paid_lanes::Vec3;
use proptest::prelude::*;

use crate::{Bone, HumanMotion, Skeleton};

/// Largest differences of points `[m]` and orientations (1 - |cosine of half the angle|) of `a`'s bones, matched by name; `b` may have
/// more bones.
pub(crate) fn differences(a: &HumanMotion, b: &HumanMotion) -> [f64; 2] {
    assert_eq!(a.frames, b.frames);
    let mut worst = [0.0_f64; 2];
    for (i, bone) in a.skeleton.bones.iter().enumerate() {
        let j = b.skeleton.find(&bone.name).expect("the same bones");
        for t in 0..a.frames {
            worst[0] = worst[0].max((Vec3(a.pos(t)[i]) - Vec3(b.pos(t)[j])).norm());
            let cosine: f64 = a.quat(t)[i].iter().zip(b.quat(t)[j]).map(|(x, y)| x * y).sum();
            worst[1] = worst[1].max(1.0 - cosine.abs());
        }
    }
    worst
}

/// Two frames of two to nine bones with offsets of either format.
pub(crate) fn any_motion() -> impl Strategy<Value = HumanMotion> {
    (
        prop::collection::vec(0usize..100, 1..8),
        // For every bone: offset [cm], and whether it ends elsewhere (ASF).
        prop::collection::vec((prop::array::uniform3(-50.0..50.0), any::<bool>()), 9),
        prop::collection::vec(-3.1..3.1f64, 3 * (3 + 9 * 3)),
        20.0..240.0f64,
    )
        .prop_map(|(parents, shapes, values, fps)| {
            let mut skeleton = Skeleton { bones: vec![Bone::new("root", None)], channels: 3 };
            skeleton.bones[0].moves = [Some(0), Some(1), Some(2)];
            for (i, p) in parents.iter().enumerate() {
                skeleton.bones.push(Bone::new(format!("bone{i}"), Some(p % (i + 1))));
            }
            for (i, bone) in skeleton.bones.iter_mut().enumerate() {
                let (offset, asf) = shapes[i];
                if asf {
                    bone.tail = offset;
                } else if i > 0 {
                    bone.head = offset;
                }
                bone.turns = (0..3).map(|k| ((k + i) % 3, skeleton.channels + k)).collect();
                skeleton.channels += 3;
            }
            let channels = skeleton.channels;
            HumanMotion::from_channels(Path::new("a"), skeleton, fps, 0.01, &values[..2 * channels])
        })
}
