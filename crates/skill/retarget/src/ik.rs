//! Inverse kinematics of the whole robot: weighted poses of bodies, joints within bounds.

use paid_lanes::{Quat, Vec3};
use paid_motion::rotation_log;
use paid_robot::{BodyPose, RobotModel, kinematics};

use crate::{BoxedSystem, Goal, RetargetError, Table};

/// Pose of the whole robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Base position, world `[m]`.
    pub base_pos: [f64; 3],
    /// Base orientation, unit, w, x, y, z.
    pub base_quat: [f64; 4],
    /// Joint angles, model order `[rad]`.
    pub joints: Vec<f64>,
}

/// When a solve ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveLimits {
    /// Most steps.
    pub steps: usize,
    /// A step that lowers the weighted sum of squares by less than this share is the last.
    pub share: f64,
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// Steps: linear systems solved.
    pub steps: usize,
    /// Weighted sum of squared errors.
    pub cost: f64,
}

/// A body with a goal.
#[derive(Clone, Debug)]
struct Part {
    body: usize,
    point: Vec3<f64>,
    weights: [[f64; 2]; 2],
    /// Joints between base and body.
    chain: Vec<usize>,
}

/// Finds poses for a robot and a table. Variables are the base's place, its turn in world axes and all joints.
#[derive(Clone, Debug)]
pub struct Solver<'a> {
    model: &'a RobotModel,
    parts: Vec<Part>,
    /// Range of every joint `[rad]`: the robot's, narrowed by the table.
    pub range: Vec<[f64; 2]>,
    system: BoxedSystem,
    low: Vec<f64>,
    high: Vec<f64>,
}

/// Variables of the base.
const BASE: usize = 6;
/// Longest chain of joints that is handled.
const LONGEST: usize = 40;
/// Bounds of the Levenberg-Marquardt damping, which begins at the least. That is no rounding guard: a robot never fits a
/// human, and with such residuals steps without it swing to and fro about the minimum (28 solves a frame of CMU 10_01 instead of 10).
const DAMPING: [f64; 2] = [2.0, 1e8];
/// Damping up to which a small gain says something about the minimum; after refused steps it is beyond.
const FREE: f64 = 30.0;
/// How far beyond its bound an angle may be by rounding alone `[rad]`.
const ROUNDING: f64 = 1e-9;

impl<'a> Solver<'a> {
    /// For `model`, with the tasks of `table`.
    ///
    /// # Errors
    /// A body or joint of the table that the robot does not have.
    pub fn new(model: &'a RobotModel, table: &Table) -> Result<Self, RetargetError> {
        let missing = |kind, name: &str| RetargetError::Robot {
            robot: model.name.clone(),
            kind,
            name: name.to_owned(),
        };
        let mut parts = Vec::new();
        for task in &table.tasks {
            let body = model.body_index(task.body).ok_or_else(|| missing("body", task.body))?;
            let mut chain = Vec::new();
            let mut at = body;
            while let Some(parent) = model.bodies[at].parent {
                chain.push(at - 1);
                at = parent;
            }
            chain.reverse();
            chain.truncate(LONGEST);
            parts.push(Part { body, point: Vec3(task.point), weights: task.weights, chain });
        }
        let mut range: Vec<[f64; 2]> = model.joints.iter().map(|j| j.range).collect();
        for (name, [low, high]) in &table.ranges {
            let j = model.joint_index(name).ok_or_else(|| missing("joint", name))?;
            range[j] = [range[j][0].max(*low), range[j][1].min(*high)];
        }
        let n = BASE + model.joints.len();
        Ok(Self {
            model,
            parts,
            range,
            system: BoxedSystem::new(n),
            low: vec![f64::NEG_INFINITY; n],
            high: vec![f64::INFINITY; n],
        })
    }

    /// A pose that stands where the hips' goal is, joints in the middle of their ranges or at zero.
    pub fn start(&self, goals: &[Goal]) -> Pose {
        let base = self.parts.iter().position(|p| p.body == 0).and_then(|i| goals.get(i));
        Pose {
            base_pos: base.map_or([0.0; 3], |g| g.pos[1]),
            base_quat: base.map_or([1.0, 0.0, 0.0, 0.0], |g| g.quat),
            joints: self.range.iter().map(|r| 0f64.clamp(r[0], r[1])).collect(),
        }
    }

    /// Moves `pose` to the nearest minimum of the weighted errors of a stage (0 or 1), joints within `range` and, given `near`
    /// (angles and the largest distances from them), near those.
    ///
    /// Gauss-Newton steps with Levenberg-Marquardt damping, each the exact solution under the bounds; a step that raises the sum of
    /// squares is taken back and damped.
    pub fn solve(
        &mut self,
        pose: &mut Pose,
        goals: &[Goal],
        stage: usize,
        near: Option<(&[f64], &[f64])>,
        limits: SolveLimits,
    ) -> Solved {
        let mut mu = DAMPING[0];
        let mut poses = self.forward(pose);
        let mut cost = self.cost(&poses, goals, stage);
        self.fill(&poses, goals, stage);
        // One small gain is not the minimum: a step that overshoots gains little, and so do the strongly damped ones that follow
        // a refused one.
        let (mut steps, mut small_gains) = (0, 0);
        while steps < limits.steps {
            steps += 1;
            for (j, (&angle, range)) in pose.joints.iter().zip(&self.range).enumerate() {
                let (mut low, mut high) = (range[0], range[1]);
                if let Some((from, reach)) = near {
                    low = low.max((from[j] - reach[j]).min(high));
                    high = high.min((from[j] + reach[j]).max(low));
                }
                (self.low[BASE + j], self.high[BASE + j]) = (low - angle, high - angle);
            }
            let step = self.system.solve(mu, &self.low, &self.high);
            let trial = moved(pose, step);
            let trial_poses = self.forward(&trial);
            let trial_cost = self.cost(&trial_poses, goals, stage);
            if trial_cost <= cost {
                let gain = cost - trial_cost;
                (*pose, poses, cost) = (trial, trial_poses, trial_cost);
                if gain > limits.share * cost + 1e-12 {
                    small_gains = 0;
                } else if mu <= FREE {
                    small_gains += 1;
                }
                if small_gains == 2 {
                    break;
                }
                mu = (0.2 * mu).max(DAMPING[0]);
                self.fill(&poses, goals, stage);
            } else {
                // Bounds that the pose was outside of may have cost more than the step gained: take it once.
                let inside = pose.joints.iter().zip(&self.low[BASE..]).zip(&self.high[BASE..]);
                if inside.into_iter().any(|((_, &low), &high)| low > ROUNDING || high < -ROUNDING) {
                    (*pose, poses, cost) = (trial, trial_poses, trial_cost);
                    self.fill(&poses, goals, stage);
                    continue;
                }
                mu = (10.0 * mu).max(1.0);
                if mu > DAMPING[1] {
                    break;
                }
            }
        }
        Solved { steps, cost }
    }

    fn forward(&self, pose: &Pose) -> Vec<BodyPose<f64>> {
        kinematics::forward::<f64>(self.model, Vec3(pose.base_pos), Quat(pose.base_quat), &pose.joints)
    }

    fn cost(&self, poses: &[BodyPose<f64>], goals: &[Goal], stage: usize) -> f64 {
        let mut sum = 0.0;
        for (part, goal) in self.parts.iter().zip(goals) {
            let [place, turn] = part.weights[stage];
            let pose = &poses[part.body];
            if place > 0.0 {
                sum += place * place * (Vec3(goal.pos[stage]) - pose.point(part.point)).norm2();
            }
            if turn > 0.0 {
                sum += turn * turn * Vec3(rotation_log(pose.quat.0, goal.quat)).norm2();
            }
        }
        sum
    }

    /// Normal equations. The rotation error is a rotation vector; taking its derivative for the identity leaves the gradient exact.
    fn fill(&mut self, poses: &[BodyPose<f64>], goals: &[Goal], stage: usize) {
        self.system.clear();
        let n = BASE + self.model.joints.len();
        let mut columns = [[0.0; 6]; BASE + LONGEST];
        let mut index = [0; BASE + LONGEST];
        for (part, goal) in self.parts.iter().zip(goals) {
            let [place, turn] = part.weights[stage];
            let pose = &poses[part.body];
            let point = pose.point(part.point);
            let off = (Vec3(goal.pos[stage]) - point).scale(place).0;
            let log = rotation_log(pose.quat.0, goal.quat).map(|x| x * turn);
            let error = [off[0], off[1], off[2], log[0], log[1], log[2]];
            let mut put = |k: usize, variable: usize, shift: Vec3<f64>, axis: Vec3<f64>| {
                let (s, a) = (shift.scale(place).0, axis.scale(turn).0);
                (columns[k], index[k]) = ([s[0], s[1], s[2], a[0], a[1], a[2]], variable);
            };
            for k in 0..3 {
                let mut axis = Vec3::zero();
                axis.0[k] = 1.0;
                put(k, k, axis, Vec3::zero());
                put(3 + k, 3 + k, axis.cross(point - poses[0].pos), axis);
            }
            for (k, &j) in part.chain.iter().enumerate() {
                let joint = &poses[j + 1];
                let axis = joint.quat.rotate(Vec3(self.model.joints[j].axis));
                put(BASE + k, BASE + j, axis.cross(point - joint.pos), axis);
            }
            let count = BASE + part.chain.len();
            for a in 0..count {
                let (column, row) = (columns[a], index[a]);
                self.system.gradient[row] += dot6(&column, &error);
                let matrix = &mut self.system.matrix[row * n..row * n + row + 1];
                for (other, &b) in columns[..=a].iter().zip(&index[..=a]) {
                    matrix[b] += dot6(&column, other);
                }
            }
        }
    }

    /// Distance `[m]` and angle `[rad]` of every task from its goal.
    pub fn errors(&self, pose: &Pose, goals: &[Goal]) -> Vec<[f64; 2]> {
        let poses = self.forward(pose);
        let error = |(part, goal): (&Part, &Goal)| {
            let pose = &poses[part.body];
            let off = Vec3(goal.pos[1]) - pose.point(part.point);
            [off.norm(), Vec3(rotation_log(pose.quat.0, goal.quat)).norm()]
        };
        self.parts.iter().zip(goals).map(error).collect()
    }

    /// For each task whether its position counts in the second stage.
    pub fn placed(&self) -> Vec<bool> {
        self.parts.iter().map(|p| p.weights[1][0] > 0.0).collect()
    }
}

#[inline(always)]
fn dot6(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) + (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
}

fn moved(pose: &Pose, step: &[f64]) -> Pose {
    let place = Vec3(pose.base_pos) + Vec3([step[0], step[1], step[2]]);
    let turn = Vec3([step[3], step[4], step[5]]);
    let angle = turn.norm();
    let mut base_quat = pose.base_quat;
    if angle > 0.0 {
        let by = Quat::from_axis_angle(turn.scale(1.0 / angle), angle);
        base_quat = by.mul(Quat(base_quat)).normalize().0;
    }
    let joints = pose.joints.iter().zip(&step[BASE..]).map(|(q, s)| q + s).collect();
    Pose { base_pos: place.0, base_quat, joints }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn goals_of(solver: &Solver<'_>, pose: &Pose) -> Vec<Goal> {
        let poses = solver.forward(pose);
        let goal = |part: &Part| {
            let body = &poses[part.body];
            Goal { pos: [body.point(part.point).0; 2], quat: body.quat.0 }
        };
        solver.parts.iter().map(goal).collect()
    }

    #[test]
    fn the_gradient_is_that_of_the_cost() {
        let model = RobotModel::g1();
        for table in [Table::lafan_to_g1(), Table::smplx_to_g1()] {
            let mut solver = Solver::new(&model, &table).expect("a table for this robot");
            let joints: Vec<f64> = (0..29).map(|j| 0.3 * (j as f64).sin()).collect();
            let there =
                Pose { base_pos: [0.1, 0.2, 0.8], base_quat: [0.8, 0.0, 0.6, 0.0], joints: vec![0.2; 29] };
            let here = Pose { base_pos: [0.0; 3], base_quat: [1.0, 0.0, 0.0, 0.0], joints };
            let goals = goals_of(&solver, &there);
            for stage in 0..2 {
                let poses = solver.forward(&here);
                solver.fill(&poses, &goals, stage);
                for i in 0..35 {
                    let at = |h: f64| {
                        let mut step = [0.0; 35];
                        step[i] = h;
                        solver.cost(&solver.forward(&moved(&here, &step)), &goals, stage)
                    };
                    let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
                    let gradient = -2.0 * solver.system.gradient[i];
                    assert!((slope - gradient).abs() < 1e-4 * (1.0 + slope.abs()), "{i}: {slope} {gradient}");
                }
            }
        }
    }

    #[test]
    fn a_reachable_pose_is_found_again() {
        let model = RobotModel::g1();
        let mut solver = Solver::new(&model, &Table::smplx_to_g1()).expect("a table for this robot");
        let joints: Vec<f64> = solver
            .range
            .iter()
            .enumerate()
            .map(|(j, r)| (0.35 * (1.7 * j as f64).sin()).clamp(r[0] + 0.05, r[1] - 0.05))
            .collect();
        let there = Pose { base_pos: [0.3, -0.2, 0.7], base_quat: [0.8, 0.0, 0.0, 0.6], joints };
        let goals = goals_of(&solver, &there);
        let mut pose = solver.start(&goals);
        let limits = SolveLimits { steps: 100, share: 1e-12 };
        let solved = solver.solve(&mut pose, &goals, 1, None, limits);
        assert!(solved.cost < 1e-9 && solved.steps < 30, "{solved:?}");
        for (a, b) in pose.joints.iter().zip(&there.joints) {
            assert!((a - b).abs() < 1e-4, "{a} {b}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
        #[test]
        fn goals_made_of_a_pose_lead_back_to_it(
            shares in proptest::collection::vec(0.1..0.9_f64, 29),
            off in proptest::collection::vec(-0.15..0.15_f64, 29),
            place in proptest::array::uniform3(-1.0..1.0_f64),
            yaw in -3.0..3.0_f64,
        ) {
            let model = RobotModel::g1();
            let mut solver = Solver::new(&model, &Table::smplx_to_g1()).expect("a table for this robot");
            // Joints in the middle half of a reach of half a radian about zero.
            let joints: Vec<f64> = solver.range.iter().zip(&shares).map(|(r, s)| {
                let (low, high) = (r[0].max(-0.5), r[1].min(0.5));
                low + s * (high - low)
            }).collect();
            let base_quat = Quat::from_roll_pitch_yaw(0.1, 0.2, yaw).0;
            let there = Pose { base_pos: place, base_quat, joints };
            let goals = goals_of(&solver, &there);
            let mut pose = there.clone();
            for (j, q) in pose.joints.iter_mut().enumerate() {
                *q = (*q + off[j]).clamp(solver.range[j][0], solver.range[j][1]);
            }
            solver.solve(&mut pose, &goals, 1, None, SolveLimits { steps: 100, share: 1e-12 });
            for (a, b) in pose.joints.iter().zip(&there.joints) {
                prop_assert!((a - b).abs() < 1e-3, "{a} {b}");
            }
        }
    }

    #[test]
    fn bounds_hold_at_every_step() {
        let model = RobotModel::g1();
        let mut solver = Solver::new(&model, &Table::lafan_to_g1()).expect("a table for this robot");
        let there =
            Pose { base_pos: [0.0, 0.0, 0.8], base_quat: [1.0, 0.0, 0.0, 0.0], joints: vec![2.5; 29] };
        let goals = goals_of(&solver, &there);
        let mut pose = solver.start(&goals);
        let (from, reach) = (pose.joints.clone(), vec![0.2; 29]);
        let limits = SolveLimits { steps: 30, share: 1e-9 };
        solver.solve(&mut pose, &goals, 0, Some((&from, &reach)), limits);
        for (j, (q, range)) in pose.joints.iter().zip(&solver.range).enumerate() {
            assert!(*q >= range[0] - 1e-12 && *q <= range[1] + 1e-12, "{j}");
            assert!((q - from[j]).abs() <= 0.2 + 1e-12, "{j}");
        }
        assert!(pose.joints.iter().any(|q| (q - 0.2).abs() < 1e-9), "some joint is at its bound");
    }
}
