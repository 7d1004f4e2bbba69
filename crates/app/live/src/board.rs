//! Score, shots and the heat map of the workspace.

use std::collections::VecDeque;

use paid_eval::shooting::Grid;
use serde::Serialize;

use crate::game::GOAL_HALF_WIDTH_M;

/// Shots that the page lists.
const LISTED: usize = 40;

/// The outcome of a shot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Through the goal's mouth.
    Goal,
    /// Past a post.
    Wide,
    /// Over the bar.
    Over,
    /// Came to rest before the goal, or rolled back.
    Short,
    /// The robot did not touch the ball.
    NoContact,
}

impl Outcome {
    /// What a protocol says of a shot, which knows no bar, and how far it missed the mouth `[m]`. `lateral_m`: where the ball passed the
    /// goal plane, left of the goal's middle `[m]`.
    pub fn judged(goal: bool, contact: bool, lateral_m: Option<f64>) -> (Self, Option<f64>) {
        let outcome = match (goal, contact, lateral_m) {
            (true, ..) => Self::Goal,
            (_, false, _) => Self::NoContact,
            (.., Some(_)) => Self::Wide,
            (.., None) => Self::Short,
        };
        (outcome, lateral_m.map(|lateral| (lateral.abs() - GOAL_HALF_WIDTH_M).max(0.0)))
    }
}

/// A shot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shot {
    /// Its number, from 1.
    pub number: usize,
    /// Its outcome.
    pub outcome: Outcome,
    /// Speed of the ball at the goal plane, or the fastest that it was if it did not get there `[m/s]`.
    pub speed_m_s: f64,
    /// Where it passed the plane, left of the goal's middle `[m]`; `None` if it did not.
    pub lateral_m: Option<f64>,
    /// How far it missed the mouth `[m]`; 0 for a goal, `None` if it did not get to the plane.
    pub miss_m: Option<f64>,
    /// Ball place in the robot's axes when the kick began `[m]`.
    pub ball: [f64; 2],
    /// True if it rolled then.
    pub rolling: bool,
    /// Name of the clip.
    pub clip: String,
    /// `built-in` or `MuJoCo`.
    pub engine: &'static str,
    /// Name of the ball and ground; empty: the scene's.
    pub surface: &'static str,
}

/// A place of the workspace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Cell {
    /// Shots from there.
    pub shots: u32,
    /// Goals of these.
    pub goals: u32,
}

/// Everything that is counted.
#[derive(Clone, Debug, Serialize)]
pub struct Board {
    kind: &'static str,
    /// Shots in all.
    pub shots: usize,
    /// Goals of these.
    pub goals: usize,
    /// Falls of the robot.
    pub falls: usize,
    /// The last shots, newest first.
    pub last: VecDeque<Shot>,
    /// Places of the workspace, row by row from near to far, each from right to left.
    pub cells: Vec<Cell>,
    /// Number of the ball and ground, as in [`crate::Command::Surface`].
    pub surface: u8,
    /// Number and words of the last message.
    pub notice: (usize, String),
    /// Counts the changes.
    #[serde(skip)]
    pub revision: usize,
}

/// Rows and columns of the workspace.
pub(crate) fn size(grid: &Grid) -> [usize; 2] {
    [grid.places(grid.x).len(), grid.places(grid.y).len()]
}

/// The place of the workspace whose middle is nearest; `None` outside.
fn cell_of(grid: &Grid, ball: [f64; 2]) -> Option<usize> {
    let [rows, columns] = size(grid);
    let index = |x: f64, low: f64, count: usize| {
        let i = ((x - low) / grid.step).round();
        (i >= 0.0 && (i as usize) < count).then_some(i as usize)
    };
    Some(index(ball[0], grid.x[0], rows)? * columns + index(ball[1], grid.y[0], columns)?)
}

impl Default for Board {
    /// Nothing yet.
    fn default() -> Self {
        let [rows, columns] = size(&Grid::EFFECTIVE);
        Self {
            kind: "board",
            shots: 0,
            goals: 0,
            falls: 0,
            last: VecDeque::new(),
            cells: vec![Cell::default(); rows * columns],
            surface: 0,
            notice: (0, String::new()),
            revision: 0,
        }
    }
}

impl Board {
    /// Counts a shot and numbers it.
    pub fn count(&mut self, mut shot: Shot) {
        self.revision += 1;
        self.shots += 1;
        shot.number = self.shots;
        let goal = shot.outcome == Outcome::Goal;
        self.goals += usize::from(goal);
        if let Some(cell) = cell_of(&Grid::EFFECTIVE, shot.ball) {
            self.cells[cell].shots += 1;
            self.cells[cell].goals += u32::from(goal);
        }
        self.last.push_front(shot);
        self.last.truncate(LISTED);
    }

    /// Says something to the visitors.
    pub fn say(&mut self, words: impl Into<String>) {
        self.revision += 1;
        self.notice = (self.notice.0 + 1, words.into());
    }

    /// Starts again.
    pub fn clear(&mut self) {
        *self = Self {
            surface: self.surface,
            notice: self.notice.clone(),
            revision: self.revision + 1,
            ..Self::default()
        };
    }

    /// Counts a fall.
    pub fn fell(&mut self) {
        self.revision += 1;
        self.falls += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shot(outcome: Outcome, ball: [f64; 2]) -> Shot {
        Shot {
            number: 0,
            outcome,
            speed_m_s: 4.0,
            lateral_m: None,
            miss_m: None,
            ball,
            rolling: false,
            clip: "kick".into(),
            engine: "built-in",
            surface: "",
        }
    }

    #[test]
    fn a_shot_counts_in_the_cell_whose_middle_is_nearest() {
        let mut board = Board::default();
        assert_eq!(board.cells.len(), 7 * 9);
        // Row 2 is 1.0 m ahead, column 5 is 0.25 m to the left.
        board.count(shot(Outcome::Goal, [1.1, 0.2]));
        board.count(shot(Outcome::Wide, [0.9, 0.3]));
        board.count(shot(Outcome::Goal, [2.2, 0.0]));
        assert_eq!(board.cells[2 * 9 + 5], Cell { shots: 2, goals: 1 });
        let counted: u32 = board.cells.iter().map(|c| c.shots).sum();
        assert_eq!((board.shots, board.goals, counted), (3, 2, 2), "the third lay outside");
        assert_eq!(board.last[0].number, 3, "newest first");
    }

    #[test]
    fn a_cleared_board_keeps_its_ground_and_the_number_of_its_last_message() {
        let mut board = Board { surface: 9, ..Board::default() };
        board.say("hello");
        board.count(shot(Outcome::Goal, [1.0, 0.0]));
        board.clear();
        assert_eq!((board.shots, board.cells[22].shots, board.notice.0, board.surface), (0, 0, 1, 9));
    }
}
