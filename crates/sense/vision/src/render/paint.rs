//! What things look like.

use super::noise::Tile;
use super::vector::{V3, dot, mix, rotate, scale, smooth};

/// The surface of a thing. Colors are linear, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paint {
    /// One color.
    Plain {
        /// The color.
        color: V3,
        /// Strength of the highlight, 0 to 1.
        gloss: f32,
    },
    /// The ball. There is at most one in a scene.
    Ball(BallPaint),
    /// Two colors that take turns along an axis: trousers, cones, tape.
    Bands {
        /// The colors.
        colors: [V3; 2],
        /// The axis times bands per meter, world `[1/m]`.
        axis: V3,
    },
}

/// What a ball looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallPaint {
    /// How its colors are laid out.
    pub pattern: BallPattern,
    /// Ground, patches, and a third color. Linear.
    pub colors: [V3; 3],
    /// World from ball: rows.
    pub turn: [V3; 3],
    /// Strength of the highlight, 0 to 1.
    pub gloss: f32,
    /// Dirt and wear, 0 (new) to 1.
    pub wear: f32,
    /// Size of patches, 0.5 to 1.5.
    pub size: f32,
}

/// The layout of a ball's colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BallPattern {
    /// One color.
    Plain,
    /// Twelve round patches about the corners of an icosahedron: the football of pictograms.
    Patches,
    /// Stripes along circles of latitude.
    Stripes,
    /// Panels of three planes' sides.
    Panels,
    /// Blots without order.
    Blots,
}

impl BallPattern {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Plain, Self::Patches, Self::Stripes, Self::Panels, Self::Blots];
}

/// Six of the twelve corners of an icosahedron; the others are opposite.
const CORNERS: [V3; 6] = [
    [0.0, 0.525_731, 0.850_651],
    [0.0, -0.525_731, 0.850_651],
    [0.525_731, 0.850_651, 0.0],
    [-0.525_731, 0.850_651, 0.0],
    [0.850_651, 0.0, 0.525_731],
    [-0.850_651, 0.0, 0.525_731],
];

impl Paint {
    /// Color and gloss at a point of the surface, given point `[m]` and normal in the world.
    #[inline(always)]
    pub(super) fn at(&self, point: V3, normal: V3) -> (V3, f32) {
        match self {
            Self::Plain { color, gloss } => (*color, *gloss),
            Self::Bands { colors, axis } => {
                let place = dot(point, *axis);
                (colors[usize::from(place - place.floor() > 0.5)], 0.1)
            }
            Self::Ball(ball) => (ball.at(normal), ball.gloss),
        }
    }

    /// Whether it is the ball.
    pub(super) fn is_ball(&self) -> bool {
        matches!(self, Self::Ball(_))
    }
}

impl BallPaint {
    #[inline(always)]
    fn at(&self, normal: V3) -> V3 {
        let n = rotate(&self.turn, normal);
        let [ground, patch, third] = self.colors;
        let color = match self.pattern {
            BallPattern::Plain => ground,
            BallPattern::Patches => {
                let nearest = CORNERS.iter().fold(0.0_f32, |best, corner| best.max(dot(n, *corner).abs()));
                // A patch reaches some 20 degrees from its corner.
                let edge = 1.0 - 0.06 * self.size;
                mix(ground, patch, smooth(edge - 0.004, edge + 0.004, nearest))
            }
            BallPattern::Stripes => {
                let bands = 2.0 * self.size * n[2];
                let place = (bands - bands.floor() - 0.5).abs();
                mix(ground, patch, smooth(0.22, 0.28, place))
            }
            BallPattern::Panels => {
                let side = usize::from(n[0] > 0.0) + usize::from(n[1] > 0.0) + usize::from(n[2] > 0.0);
                let seam = n[0].abs().min(n[1].abs()).min(n[2].abs());
                let panel = [ground, patch, ground, third][side];
                scale(panel, 0.6 + 0.4 * smooth(0.0, 0.05, seam))
            }
            BallPattern::Blots => {
                let blot =
                    Tile::shared().at([n[0] * 9.0 + n[2] * 4.0 + 40.0, n[1] * 9.0 + n[2] * 7.0 + 40.0], 4.0);
                let second = mix(ground, patch, smooth(0.15, 0.25, blot * self.size));
                mix(second, third, smooth(0.3, 0.4, -blot * self.size))
            }
        };
        if self.wear <= 0.0 {
            return color;
        }
        let dirt =
            Tile::shared().at([n[0] * 21.0 + 90.0 + n[2] * 5.0, n[1] * 21.0 + n[2] * 13.0 + 90.0], 2.0);
        let worn = self.wear * smooth(-0.3, 1.2, dirt);
        mix(color, [0.13, 0.11, 0.08], worn)
    }
}
