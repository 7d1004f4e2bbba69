//! Which places of the workspace the kicks cover, and its holes.

use std::fmt;

use paid_eval::shooting::Grid;
use paid_motion::KickLeg;
use serde::Serialize;

use super::Kick;

/// A ball within this of a kick's place is covered: the distance at which the paper recorded its kicks `[m]`.
pub const REACH_M: f64 = 0.3;
/// Side of the squares in which holes are looked for `[m]`.
const FINE_M: f64 = 0.05;
/// Smaller holes are none `[m^2]`: four squares of the evaluation's grid would be 0.25.
const SMALLEST_M2: f64 = 0.01;
/// A ball less to the side than this is straight ahead `[m]`.
const STRAIGHT_M: f64 = 0.1;

/// A ball place of the grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// Where `[m]`.
    pub place: [f64; 2],
    /// The kick that takes it: the one whose place is nearest, by its number.
    pub kick: usize,
    /// Distance from that place `[m]`.
    pub distance_m: f64,
}

/// A connected part of the workspace that no kick covers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hole {
    /// Its center: the point of it with the most of it within reach, of equals the nearest to its middle `[m]`.
    pub center: [f64; 2],
    /// Its area `[m^2]`.
    pub area_m2: f64,
}

/// A kick that the set lacks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NextKick {
    /// Where its ball lies, from where the robot begins (ahead, left) `[m]`.
    pub ball: [f64; 2],
    /// The foot on the ball's side; `None` where the ball is straight ahead.
    pub leg: Option<KickLeg>,
    /// Name of the kick whose place is nearest.
    pub nearest: String,
    /// How far that is from the ball `[m]`.
    pub nearest_m: f64,
    /// A kick whose mirror image covers the ball, by its name.
    pub mirror_of: Option<String>,
}

impl fmt::Display for NextKick {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y] = self.ball;
        let side = match self.leg {
            None => "straight ahead".to_owned(),
            Some(leg) => format!("{:.2} m to the {leg}", y.abs()),
        };
        let foot = self.leg.map_or_else(|| "either".to_owned(), |leg| format!("the {leg}"));
        write!(
            f,
            "a kick with {foot} foot at a ball {x:.2} m ahead of the robot's start and {side}; the nearest kick of the set, \
             {}, is {:.0} cm away",
            self.nearest,
            100.0 * self.nearest_m
        )?;
        match &self.mirror_of {
            Some(name) => write!(f, ". The mirror image of {name} would fill it"),
            None => Ok(()),
        }
    }
}

/// What kicks cover.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// The workspace.
    pub grid: Grid,
    /// A ball within this of a kick's place is covered `[m]`.
    pub reach_m: f64,
    /// Share of the workspace's area that is covered.
    pub covered: f64,
    /// Every place of the grid, near to far, right to left.
    pub cells: Vec<Cell>,
    /// Largest first.
    pub holes: Vec<Hole>,
    /// The kick that would fill the largest hole; `None` without one.
    pub next: Option<NextKick>,
}

impl Coverage {
    /// How much is covered, as a sentence.
    pub fn share(&self) -> String {
        let Self { grid, reach_m, covered, holes, .. } = self;
        format!(
            "{:.0}% of the balls {} to {} m ahead and {} m to either side are within {:.0} cm of a kick's ball; {} holes",
            100.0 * covered,
            grid.x[0],
            grid.x[1],
            grid.y[1],
            100.0 * reach_m,
            holes.len()
        )
    }

    /// Which kick to record next, as a sentence.
    pub fn advice(&self) -> String {
        match &self.next {
            Some(next) => format!("record next: {next}"),
            None => "record next: nothing; the workspace has no holes".to_owned(),
        }
    }
}

/// Whether a distance is within reach; squares that lie just on the edge are, whatever the rounding.
fn within(distance_m: f64) -> bool {
    distance_m <= REACH_M + 1e-9
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The nearest kick, the first of equals, and its distance.
fn nearest(kicks: &[Kick], place: [f64; 2]) -> (usize, f64) {
    kicks.iter().enumerate().fold((0, f64::INFINITY), |best, (i, kick)| {
        let d = distance(kick.place, place);
        if d < best.1 { (i, d) } else { best }
    })
}

impl Coverage {
    /// How at least one kick covers a grid.
    pub(super) fn of(kicks: &[Kick], grid: Grid) -> Self {
        let places = grid.places(grid.x).into_iter().flat_map(|x| {
            let row = grid.places(grid.y);
            row.into_iter().map(move |y| [x, y])
        });
        let cells = places.map(|place| {
            let (kick, distance_m) = nearest(kicks, place);
            Cell { place, kick, distance_m }
        });
        let cells = cells.collect();
        let fine = Fine::new(kicks, grid);
        let holes = fine.holes();
        let next = holes.first().map(|hole| {
            let [x, y] = hole.center;
            let (kick, nearest_m) = nearest(kicks, hole.center);
            let mirrored = |kick: &&Kick| within(distance([kick.place[0], -kick.place[1]], hole.center));
            NextKick {
                ball: [x, y],
                leg: (y.abs() >= STRAIGHT_M).then_some(if y > 0.0 { KickLeg::Left } else { KickLeg::Right }),
                nearest: kicks[kick].name.clone(),
                nearest_m,
                mirror_of: kicks.iter().find(mirrored).map(|kick| kick.name.clone()),
            }
        });
        Self { grid, reach_m: REACH_M, covered: fine.covered(), cells, holes, next }
    }
}

/// The workspace in small squares, each covered or not.
struct Fine {
    first: [f64; 2],
    size: [usize; 2],
    open: Vec<bool>,
}

impl Fine {
    fn new(kicks: &[Kick], grid: Grid) -> Self {
        let size = [grid.x, grid.y].map(|[from, to]| ((to - from) / FINE_M).round().max(0.0) as usize + 1);
        let mut fine = Self { first: [grid.x[0], grid.y[0]], size, open: Vec::new() };
        fine.open = (0..size[0] * size[1]).map(|i| !within(nearest(kicks, fine.place(i)).1)).collect();
        fine
    }

    fn place(&self, i: usize) -> [f64; 2] {
        let steps = [i / self.size[1], i % self.size[1]];
        [0, 1].map(|k| self.first[k] + FINE_M * steps[k] as f64)
    }

    fn covered(&self) -> f64 {
        self.open.iter().filter(|open| !**open).count() as f64 / self.open.len().max(1) as f64
    }

    /// The connected open parts, largest first.
    fn holes(&self) -> Vec<Hole> {
        let mut left = self.open.clone();
        let mut holes = Vec::new();
        for start in 0..left.len() {
            if !std::mem::take(&mut left[start]) {
                continue;
            }
            let (mut part, mut done) = (vec![start], 0);
            while let Some(&i) = part.get(done) {
                done += 1;
                let (row, column) = (i / self.size[1], i % self.size[1]);
                let beside = [
                    (row > 0).then(|| i - self.size[1]),
                    (row + 1 < self.size[0]).then(|| i + self.size[1]),
                    (column > 0).then(|| i - 1),
                    (column + 1 < self.size[1]).then(|| i + 1),
                ];
                part.extend(beside.into_iter().flatten().filter(|&j| std::mem::take(&mut left[j])));
            }
            holes.push(self.hole(&part));
        }
        holes.retain(|hole| hole.area_m2 >= SMALLEST_M2);
        holes.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2));
        holes
    }

    fn hole(&self, part: &[usize]) -> Hole {
        let places: Vec<[f64; 2]> = part.iter().map(|&i| self.place(i)).collect();
        let middle = [0, 1].map(|k| places.iter().map(|p| p[k]).sum::<f64>() / places.len() as f64);
        let mut center = (0, f64::INFINITY, middle);
        for &place in &places {
            let filled = places.iter().filter(|p| within(distance(**p, place))).count();
            let off = distance(place, middle);
            if filled > center.0 || (filled == center.0 && off < center.1) {
                center = (filled, off, place);
            }
        }
        Hole { center: center.2, area_m2: FINE_M * FINE_M * places.len() as f64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kick(name: &str, place: [f64; 2]) -> Kick {
        Kick {
            name: name.to_owned(),
            leg: KickLeg::Right,
            place,
            strike_phase: 0.5,
            peak_foot_speed: 3.0,
            path: vec![[0.0; 2], place],
            foot_speed: vec![0.0, 3.0],
        }
    }

    /// Two meters ahead and four across, with kicks every 0.4 m except for those within 0.55 m of `without`.
    fn lattice(without: [f64; 2]) -> Vec<Kick> {
        let steps = |n: u32| (0..=n).map(|i| 0.4 * f64::from(i));
        let all = steps(5).flat_map(|x| steps(10).map(move |y| [x, y - 2.0]));
        all.filter(|p| distance(*p, without) > 0.55).map(|p| kick("k", p)).collect()
    }

    const WIDE: Grid = Grid { x: [0.0, 2.0], y: [-2.0, 2.0], step: 0.25 };

    #[test]
    fn the_center_of_a_hole_in_a_lattice_is_where_the_kicks_are_missing() {
        // Kicks 0.4 m apart leave no point farther than 0.28 m; without the nearest ones there is one hole.
        let full = Coverage::of(&lattice([9.0, 9.0]), WIDE);
        assert_eq!((full.covered, &full.holes, &full.next), (1.0, &vec![], &None));
        assert_eq!(full.advice(), "record next: nothing; the workspace has no holes");
        assert!(
            full.share()
                .starts_with("100% of the balls 0 to 2 m ahead and 2 m to either side are within 30 cm")
        );
        let found = Coverage::of(&lattice([1.2, -0.8]), WIDE);
        assert_eq!(found.holes.len(), 1);
        let next = found.next.expect("a hole");
        assert!(distance(next.ball, [1.2, -0.8]) < 1e-9, "{next:?}");
        assert_eq!(next.leg, Some(KickLeg::Right));
        assert!((next.nearest_m - 0.32_f64.sqrt()).abs() < 1e-9, "the diagonal of two squares: {next:?}");
        assert!(
            next.to_string().ends_with("k, is 57 cm away. The mirror image of k would fill it"),
            "{next}"
        );
    }

    #[test]
    fn a_hole_is_told_in_words() {
        let grid = Grid { x: [0.5, 2.0], y: [-1.0, 1.0], step: 0.25 };
        // One kick far to the right: the rest of the workspace is one hole.
        let one = Coverage::of(&[kick("far", [1.25, -3.0])], grid);
        assert_eq!((one.covered, one.holes.len(), one.cells.len()), (0.0, 1, 63));
        let next = one.next.expect("a hole");
        assert_eq!((next.leg, next.mirror_of.as_deref()), (None, None));
        assert_eq!(
            next.to_string(),
            "a kick with either foot at a ball 1.25 m ahead of the robot's start and straight ahead; the nearest kick of \
             the set, far, is 300 cm away"
        );
        // 31 x 41 squares of 5 cm.
        assert!((one.holes[0].area_m2 - 31.0 * 41.0 * 0.0025).abs() < 1e-9);
    }

    #[test]
    fn a_cell_goes_to_the_nearest_kick_and_the_largest_hole_comes_first() {
        let grid = Grid { x: [0.0, 1.0], y: [-1.0, 1.0], step: 0.5 };
        // Kicks along y = 0.2 part the workspace; its right part is the larger one.
        let wall: Vec<Kick> = (0..5).map(|i| kick(&format!("w{i}"), [0.25 * f64::from(i), 0.2])).collect();
        let coverage = Coverage::of(&wall, grid);
        assert_eq!(coverage.holes.len(), 2);
        assert!(coverage.holes[0].center[1] < 0.0 && coverage.holes[1].center[1] > 0.2);
        assert!(coverage.holes[0].area_m2 > coverage.holes[1].area_m2);
        let cell = coverage.cells.iter().find(|c| c.place == [0.5, 0.0]).expect("of the grid");
        assert_eq!(cell.kick, 2);
        assert!((cell.distance_m - 0.2).abs() < 1e-12);
        assert_eq!(coverage.next.expect("a hole").leg, Some(KickLeg::Right));
    }
}
