//! Depths made by hand: what is a ball, and what only has its size.

use super::{Fix, Source, locate};
use crate::detect::Detection;
use crate::{DepthImage, Intrinsics};

/// Radius of the ball `[m]`.
const R: f64 = 0.11;
/// Distance of the ball's center, straight ahead `[m]`.
const FAR: f64 = 1.0;

fn camera() -> Intrinsics {
    Intrinsics { width: 400, height: 300, focal: [300.0; 2], center: [200.0, 150.0] }
}

/// What `locate` makes of depths `[m]`, a function of a pixel's ray (its third component is 1), under the outline of a ball at [`FAR`].
fn place(depth_m: impl Fn([f64; 3]) -> f64) -> Option<Fix> {
    let camera = camera();
    let mm = |i: usize| {
        let ray = camera.ray([(i % 400) as f64 + 0.5, (i / 400) as f64 + 0.5]);
        (1000.0 * depth_m(ray)).round() as u16
    };
    let depth = DepthImage::new(400, 300, (0..400 * 300).map(mm).collect()).expect("whole");
    let outline = camera.sphere_box([0.0, 0.0, FAR], R).expect("ahead");
    let detection = Detection { outline, score: 0.9, mask: None, whole: true };
    locate(&detection, Some(&depth), &camera, R, None)
}

/// Depth of a ball straight ahead, with a wall 2 m behind it.
fn ball(ray: [f64; 3]) -> f64 {
    let length2 = ray.iter().map(|v| v * v).sum::<f64>();
    let root = FAR * FAR - length2 * (FAR * FAR - R * R);
    if root > 0.0 { (FAR - root.sqrt()) / length2 } else { FAR + 2.0 }
}

#[test]
fn a_ball_is_placed_also_half_behind_a_leg_or_in_a_frame_that_is_a_tenth_too_large() {
    let with_leg = |ray: [f64; 3]| if ray[0] < 0.0 { 0.6 } else { ball(ray) };
    let smaller = |ray: [f64; 3]| {
        let wide = [1.1 * ray[0], 1.1 * ray[1], 1.0];
        ball(wide)
    };
    for fix in [place(ball), place(with_leg), place(smaller)] {
        let fix = fix.expect("a ball");
        assert_eq!(fix.source, Source::Depth);
        assert!((fix.position[2] - FAR).abs() < 6e-3, "{fix:?}");
    }
}

#[test]
fn the_flat_side_of_a_box_is_no_ball() {
    // Where the front of a ball would be, and where its middle would be.
    for z in [FAR - R, FAR - 0.5 * R, FAR] {
        assert_eq!(place(|_| z), None, "{z} m");
    }
}

#[test]
fn a_foot_or_a_small_box_with_floor_around_it_is_no_ball() {
    // The camera looks down on a floor that a ball would lie on.
    let floor = FAR + R;
    // A capsule of 4 cm lies across the image.
    let foot = |ray: [f64; 3]| {
        let (r, middle) = (0.04, floor - 0.04);
        let length2 = ray[1] * ray[1] + 1.0;
        let root = middle * middle - length2 * (middle * middle - r * r);
        if root > 0.0 { (middle - root.sqrt()) / length2 } else { floor }
    };
    assert_eq!(place(foot), None);
    // A cube of 12 cm: its top is nearer than the floor by its edge.
    let cube = |ray: [f64; 3]| {
        let top = floor - 0.12;
        if ray[0].abs().max(ray[1].abs()) * top < 0.06 { top } else { floor }
    };
    assert_eq!(place(cube), None);
    assert_eq!(place(|_| floor), None);
}
