//! Balls, floors, clutter and lamps.

use super::draw::Draw;
use crate::render::{
    BallPaint, BallPattern, ColorSensor, DepthSensor, Form, Ground, GroundKind, Light, Mark, Paint, Solid, V3,
};

const WHITE: V3 = [0.82, 0.82, 0.80];
const BLACK: V3 = [0.015, 0.015, 0.018];

/// A ball's looks: white, patterned, colored, worn. `patterns` are those that may occur.
pub(super) fn ball_paint(draw: &mut Draw, patterns: &[BallPattern]) -> BallPaint {
    let pattern = draw.one_of(patterns);
    let light = |draw: &mut Draw| draw.near(WHITE, 0.12);
    let vivid = |draw: &mut Draw| draw.color([0.6, 1.0], [0.35, 0.95]);
    let colors = match draw.0.below(4) {
        // The classic one.
        0 => [light(draw), draw.near(BLACK, 0.5), vivid(draw)],
        // White with colored patches.
        1 => [light(draw), vivid(draw), vivid(draw)],
        // Colored.
        2 => [vivid(draw), draw.one_of(&[WHITE, BLACK]), vivid(draw)],
        // Pale: yellow, orange, beige.
        _ => [draw.color([0.1, 0.5], [0.5, 0.9]), draw.color([0.0, 1.0], [0.02, 0.9]), light(draw)],
    };
    let worn = draw.chance(0.35);
    BallPaint {
        pattern,
        colors,
        turn: draw.rotation(),
        gloss: draw.between_f32(0.0, 0.8),
        wear: if worn { draw.between_f32(0.1, 0.7) } else { 0.0 },
        size: draw.between_f32(0.6, 1.4),
    }
}

/// A floor with lines.
pub(super) fn ground(draw: &mut Draw) -> Ground {
    let kind = draw.one_of(&GroundKind::ALL);
    let base = match kind {
        GroundKind::Turf => {
            let green =
                [draw.between_f32(0.02, 0.12), draw.between_f32(0.08, 0.3), draw.between_f32(0.01, 0.07)];
            if draw.chance(0.15) { [green[1], 0.8 * green[1], green[2]] } else { green }
        }
        GroundKind::Hall => match draw.0.below(3) {
            0 => draw.near([0.45, 0.28, 0.13], 0.4),
            1 => draw.color([0.2, 0.8], [0.1, 0.6]),
            _ => draw.color([0.0, 0.15], [0.1, 0.7]),
        },
        GroundKind::Carpet => draw.color([0.0, 0.8], [0.02, 0.6]),
        GroundKind::Tiles => draw.color([0.0, 0.2], [0.1, 0.75]),
    };
    let spread = draw.between_f32(1.3, 2.2);
    let marks = marks(draw);
    Ground {
        kind,
        colors: [base.map(|v| v / spread), base.map(|v| (v * spread).min(0.9))],
        pattern_m: match kind {
            GroundKind::Turf => draw.between_f32(0.8, 2.5),
            GroundKind::Hall => draw.between_f32(0.06, 0.2),
            GroundKind::Carpet => 0.5,
            GroundKind::Tiles => draw.between_f32(0.2, 1.0),
        },
        contrast: draw.between_f32(0.2, 1.0),
        heading: draw.heading(),
        offset: [draw.between_f32(0.0, 50.0), draw.between_f32(0.0, 50.0)],
        marks,
        gloss: if kind == GroundKind::Hall { draw.between_f32(0.0, 0.9) } else { 0.0 },
    }
}

/// Lines of a pitch or of a gym, spots, and discs that lie about.
fn marks(draw: &mut Draw) -> Vec<Mark> {
    let mut marks = Vec::new();
    let place = |draw: &mut Draw| [draw.between_f32(-0.5, 4.0), draw.between_f32(-2.5, 2.5)];
    let paint = |draw: &mut Draw| {
        if draw.chance(0.7) { draw.near(WHITE, 0.15) } else { draw.color([0.3, 1.0], [0.1, 0.9]) }
    };
    let lines = draw.one_of(&[0, 0, 1, 2, 3, 5]);
    let color = paint(draw);
    let half_width = draw.between_f32(0.02, 0.06);
    let [c, s] = draw.heading();
    for _ in 0..lines {
        // Lines are parallel or at right angles.
        let along = if draw.chance(0.5) { [c, s] } else { [-s, c] };
        let half_length = if draw.chance(0.7) { 10.0 } else { draw.between_f32(0.3, 3.0) };
        let color = if draw.chance(0.8) { color } else { paint(draw) };
        marks.push(Mark::Straight { point: place(draw), along, half_length, half_width, color });
    }
    if draw.chance(0.25) {
        marks.push(Mark::Circle {
            middle: place(draw),
            radius: draw.between_f32(0.15, 2.0),
            half_width,
            color,
        });
    }
    // Penalty spots, coins, lids, rings, patches of light.
    for _ in 0..draw.one_of(&[0, 0, 1, 1, 2, 4]) {
        let ring = draw.chance(0.25);
        let half_width = if ring { draw.between_f32(0.01, 0.03) } else { draw.between_f32(0.02, 0.2) };
        let radius = if ring { draw.between_f32(0.05, 0.2) } else { 0.0 };
        marks.push(Mark::Circle { middle: place(draw), radius, half_width, color: paint(draw) });
    }
    marks
}

/// Things that stand about, many of them round, none of them a ball: bottles, cones' lower halves, domes, rolls, boxes.
pub(super) fn clutter(draw: &mut Draw) -> Vec<Solid> {
    let count = draw.one_of(&[0, 0, 1, 2, 3, 5]);
    (0..count)
        .map(|_| {
            let [x, y] = [draw.between_f32(0.4, 4.5), draw.between_f32(-2.0, 2.0)];
            let color =
                if draw.chance(0.4) { draw.near(WHITE, 0.2) } else { draw.color([0.0, 1.0], [0.02, 0.9]) };
            let plain = Paint::Plain { color, gloss: draw.between_f32(0.0, 0.8) };
            let [c, s] = draw.heading();
            let (form, paint) = match draw.0.below(5) {
                // A bottle, a post, a lamp's foot.
                0 => {
                    let radius = draw.between_f32(0.03, 0.09);
                    let top = radius + draw.between_f32(2.5 * radius, 0.5);
                    let axis = [0.0, 0.0, draw.between_f32(2.0, 8.0)];
                    let bands = Paint::Bands { colors: [color, draw.color([0.0, 1.0], [0.02, 0.9])], axis };
                    let paint = if draw.chance(0.3) { bands } else { plain };
                    (Form::Capsule { ends: [[x, y, 0.0], [x, y, top]], radius }, paint)
                }
                // A marker dome: at most half of a sphere looks out of the floor.
                1 => {
                    let radius = draw.between_f32(0.08, 0.22);
                    (Form::Sphere { center: [x, y, -radius * draw.between_f32(0.1, 0.8)], radius }, plain)
                }
                // A roll, a shoe, a bag.
                2 => {
                    let radius = draw.between_f32(0.03, 0.15);
                    let half = draw.between_f32(1.0, 4.0) * radius;
                    let ends = [[x - c * half, y - s * half, radius], [x + c * half, y + s * half, radius]];
                    (Form::Capsule { ends, radius }, plain)
                }
                // Boxes.
                3 => {
                    let half_size = [0; 3].map(|_| draw.between_f32(0.04, 0.3));
                    let axes = [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]];
                    (Form::Box { center: [x, y, half_size[2]], half_size, axes }, plain)
                }
                // A goal's post or a chair's leg.
                _ => {
                    let radius = draw.between_f32(0.02, 0.06);
                    let top = [x + draw.between_f32(-0.2, 0.2), y + draw.between_f32(-0.2, 0.2), 1.8];
                    (Form::Capsule { ends: [[x, y, 0.0], top], radius }, plain)
                }
            };
            Solid { form, paint, velocity: [0.0; 3] }
        })
        .collect()
}

/// A goal: two posts and a bar, its mouth toward the robot.
pub(super) fn goal(draw: &mut Draw) -> Vec<Solid> {
    let (x, y) = (draw.between_f32(1.5, 5.0), draw.between_f32(-1.0, 1.0));
    let (half, height, radius) =
        (draw.between_f32(0.6, 1.6), draw.between_f32(0.8, 1.8), draw.between_f32(0.03, 0.06));
    let color = draw.near(WHITE, 0.15);
    let [a, b] = [[x, y - half], [x, y + half]];
    let bar = |ends: [V3; 2]| Solid {
        form: Form::Capsule { ends, radius },
        paint: Paint::Plain { color, gloss: 0.3 },
        velocity: [0.0; 3],
    };
    vec![
        bar([[a[0], a[1], 0.0], [a[0], a[1], height]]),
        bar([[b[0], b[1], 0.0], [b[0], b[1], height]]),
        bar([[a[0], a[1], height], [b[0], b[1], height]]),
    ]
}

/// Lamps or sun, and sky.
pub(super) fn light(draw: &mut Draw) -> Light {
    let (height, [c, s]) = (draw.between_f32(0.35, 1.45), draw.heading());
    let toward = [c * height.cos(), s * height.cos(), height.sin()];
    let warmth = draw.between_f32(-0.15, 0.15);
    let tint = [1.0 + warmth, 1.0, 1.0 - warmth];
    let lamp = draw.between_f32(0.0, 1.1);
    let ambient = draw.between_f32(0.15, 0.7);
    Light {
        toward,
        lamp: tint.map(|t| t * lamp),
        ambient: [1.0 - 0.5 * warmth, 1.0, 1.0 + 0.5 * warmth].map(|t| t * ambient),
        softness: draw.one_of(&[0.02, 0.1, 0.3]),
    }
}

/// A color camera: exposure, white balance, blur and noise. `turning` is the image's motion during the exposure `[px]`.
pub(super) fn color_sensor(draw: &mut Draw, light: &Light, turning: [f32; 2]) -> ColorSensor {
    // An automatic exposure that is a little off.
    let bright = 0.6 * (light.ambient[1] + light.lamp[1] * light.toward[2]);
    let gain = (0.55 / bright.max(0.05)) * draw.between(-0.6, 0.6).exp() as f32;
    ColorSensor {
        gain,
        balance: [draw.between_f32(0.85, 1.15), 1.0, draw.between_f32(0.85, 1.15)],
        blur_px: draw.between_f32(0.2, 1.1),
        shake_px: turning,
        dark_noise: draw.between_f32(0.001, 0.02),
        shot_noise: draw.between_f32(0.0, 0.03),
        vignette: draw.between_f32(0.0, 0.4),
        seed: draw.0.next_u32(),
    }
}

/// A depth camera with holes.
pub(super) fn depth_sensor(draw: &mut Draw) -> DepthSensor {
    DepthSensor { holes: draw.between_f32(0.0, 0.08), seed: draw.0.next_u32(), ..DepthSensor::default() }
}
