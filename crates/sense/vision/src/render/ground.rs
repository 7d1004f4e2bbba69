//! The floor.

use super::noise::Tile;
use super::vector::{V3, mix, scale, smooth};

/// What the floor is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroundKind {
    /// Grass or artificial turf: blades, patches, mown stripes.
    Turf,
    /// A gym: boards or a plain coat, shiny.
    Hall,
    /// A carpet: a fine weave.
    Carpet,
    /// Tiles or concrete plates with joints.
    Tiles,
}

impl GroundKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Turf, Self::Hall, Self::Carpet, Self::Tiles];
}

/// A line on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark {
    /// A straight line.
    Straight {
        /// A point of it `[m]`.
        point: [f32; 2],
        /// Its direction, a unit vector.
        along: [f32; 2],
        /// Half its length `[m]`.
        half_length: f32,
        /// Half its width `[m]`.
        half_width: f32,
        /// Color, linear.
        color: V3,
    },
    /// A circle's line, or a spot if `radius` is 0.
    Circle {
        /// The middle `[m]`.
        middle: [f32; 2],
        /// Radius of the line's middle `[m]`.
        radius: f32,
        /// Half the line's width, or the radius of the spot `[m]`.
        half_width: f32,
        /// Color, linear.
        color: V3,
    },
}

/// A floor at height 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    /// The material.
    pub kind: GroundKind,
    /// Two colors between which it varies, linear.
    pub colors: [V3; 2],
    /// Size of boards, tiles or mown stripes `[m]`.
    pub pattern_m: f32,
    /// Strength of the texture, 0 to 1.
    pub contrast: f32,
    /// Heading of the pattern: cosine and sine.
    pub heading: [f32; 2],
    /// Offset of the texture, so that no two floors are alike `[m]`.
    pub offset: [f32; 2],
    /// What is painted on it.
    pub marks: Vec<Mark>,
    /// Mirror of the lamps, 0 to 1.
    pub gloss: f32,
}

impl Ground {
    /// The color at a place `[m]`, the mean over `footprint` `[m]`.
    #[inline(always)]
    pub(super) fn at(&self, place: [f32; 2], footprint: f32) -> V3 {
        let tile = Tile::shared();
        let [c, s] = self.heading;
        let (x, y) = (place[0] + self.offset[0], place[1] + self.offset[1]);
        let (x, y) = (c * x + s * y, c * y - s * x);
        let noise = |cell: f32| tile.at([x / cell, y / cell], footprint / cell);
        let mut share = match self.kind {
            GroundKind::Turf => {
                let stripe = (x / self.pattern_m).floor() as i64 & 1;
                // Blades are longer than wide.
                let blades = tile.at([x / 0.004, y / 0.009], footprint / 0.005);
                0.5 + self.contrast * (0.45 * blades + 0.2 * noise(0.05) + 0.2 * (stripe as f32 - 0.5))
            }
            GroundKind::Hall => {
                let board = (y / self.pattern_m).floor();
                let tone = tile.at([board * 17.3, (x / (8.0 * self.pattern_m)).floor() * 5.7], 1.0);
                let grain = tile.at([x / 0.08, y / 0.004], footprint / 0.01);
                0.5 + self.contrast * (0.25 * tone + 0.15 * grain)
            }
            GroundKind::Carpet => 0.5 + self.contrast * (0.4 * noise(0.004) + 0.15 * noise(0.09)),
            GroundKind::Tiles => {
                let (u, v) = (x / self.pattern_m, y / self.pattern_m);
                let tone = tile.at([u.floor() * 13.1, v.floor() * 7.7], 1.0);
                0.5 + self.contrast * (0.25 * tone + 0.25 * noise(0.03))
            }
        };
        if self.kind == GroundKind::Tiles {
            let edge = |w: f32| {
                let w = w / self.pattern_m;
                (w - w.floor() - 0.5).abs()
            };
            let joint = 0.5 - 0.5 * (0.006 + footprint) / self.pattern_m;
            let thin = (0.006 / footprint).min(1.0);
            if edge(x) > joint || edge(y) > joint {
                share -= 0.5 * thin;
            }
        }
        let mut color = mix(self.colors[0], self.colors[1], share.clamp(0.0, 1.0));
        for mark in &self.marks {
            let (outside, paint) = mark.outside(place);
            if outside < footprint {
                let cover = 1.0 - smooth(-0.5 * footprint, 0.5 * footprint, outside);
                // Worn paint shows the floor in places.
                let wear = 0.85 + 0.15 * (share - 0.5);
                color = mix(color, scale(paint, 0.85 + 0.3 * share), cover * wear);
            }
        }
        color
    }
}

impl Mark {
    /// How far outside the painted part a place is (negative inside) `[m]`, and the color.
    #[inline(always)]
    fn outside(&self, place: [f32; 2]) -> (f32, V3) {
        match *self {
            Self::Straight { point, along, half_length, half_width, color } => {
                let d = [place[0] - point[0], place[1] - point[1]];
                let lengthwise = (d[0] * along[0] + d[1] * along[1]).abs() - half_length;
                let across = (d[1] * along[0] - d[0] * along[1]).abs() - half_width;
                (lengthwise.max(across), color)
            }
            Self::Circle { middle, radius, half_width, color } => {
                let d = [place[0] - middle[0], place[1] - middle[1]];
                (((d[0] * d[0] + d[1] * d[1]).sqrt() - radius).abs() - half_width, color)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_white_and_thins_out_with_distance() {
        let line = Mark::Straight {
            point: [1.0, 0.0],
            along: [0.0, 1.0],
            half_length: 5.0,
            half_width: 0.05,
            color: [1.0; 3],
        };
        let ground = Ground {
            kind: GroundKind::Carpet,
            colors: [[0.0; 3]; 2],
            pattern_m: 1.0,
            contrast: 0.0,
            heading: [1.0, 0.0],
            offset: [0.0; 2],
            marks: vec![line],
            gloss: 0.0,
        };
        assert!(ground.at([1.0, 2.0], 0.001)[0] > 0.8);
        assert_eq!(ground.at([1.2, 2.0], 0.001), [0.0; 3]);
        assert_eq!(ground.at([1.0, 6.0], 0.001), [0.0; 3]);
        // The edge is half covered.
        let edge = ground.at([1.05, 0.0], 0.02)[0];
        assert!((0.3..0.6).contains(&edge), "{edge}");
    }
}
