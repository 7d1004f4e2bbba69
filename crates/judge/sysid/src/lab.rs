//! The experiments in the batched engine: one ball per SIMD lane.

use paid_lanes::{Isa, IsaVisitor, Real};
use paid_physics::{BallParams, Engine, EnvParams, LaneState, SceneConfig, Simulator, Terrain};

use crate::SysidError;
use crate::stand_in::stand_in;

/// How a ball begins, on flat ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// Released at rest.
    Drop {
        /// Height of its lowest point `[m]`.
        height_m: f64,
    },
    /// On the ground, moving along x.
    Roll {
        /// Speed of its center `[m/s]`.
        speed: f64,
        /// Distance shown at the start `[m]`.
        offset_m: f64,
        /// 1 rolls, 0 slides, between both shares.
        spin: f64,
    },
}

/// One ball to be followed.
#[derive(Clone, Copy, Debug)]
pub struct Launch<'a> {
    /// The ball.
    pub ball: BallParams,
    /// How it begins.
    pub start: Start,
    /// When it is looked at `[s]`, from 0, increasing.
    pub times: &'a [f64],
}

/// Something that can follow many balls.
pub trait Lab {
    /// Height of the lowest point (drops) or distance (rolls) `[m]` at the launch's times, for every launch.
    fn run(&mut self, launches: &[Launch<'_>]) -> Vec<Vec<f64>>;
    /// Balls followed so far.
    fn rollouts(&self) -> u64;
}

/// The built-in engine with the lane type `V`. Its robot is a stand-in that is never stepped.
pub struct EngineLab<V: Real> {
    engine: Engine<V>,
    lane: LaneState,
    /// Height of the ball's center and its distance after every physics step of the current launches.
    trace: Vec<[V; 2]>,
    rollouts: u64,
}

/// The built-in engine with the lane type of an instruction set. The ground is flat whatever `scene.terrain` says.
///
/// # Errors
/// If the engine refuses the scene.
pub fn engine_lab(isa: Isa, scene: &SceneConfig) -> Result<Box<dyn Lab>, SysidError> {
    struct Open<'a>(&'a SceneConfig);
    impl IsaVisitor for Open<'_> {
        type Output = Result<Box<dyn Lab>, SysidError>;
        fn visit<V: Real<Scalar = f32>>(self) -> Self::Output {
            Ok(Box::new(EngineLab::<V>::new(self.0)?))
        }
    }
    isa.dispatch(Open(scene))
}

impl<V: Real> EngineLab<V> {
    /// A group of lanes in `scene`, made flat.
    ///
    /// # Errors
    /// If the engine refuses the scene.
    pub fn new(scene: &SceneConfig) -> Result<Self, SysidError> {
        let scene = SceneConfig { terrain: Terrain::Plane, ball: true, ..scene.clone() };
        let (model, spec) = stand_in();
        let engine = Engine::new(&model, spec, &scene, 1)?;
        let lane = engine.save_lane(0, 0);
        Ok(Self { engine, lane, trace: Vec::new(), rollouts: 0 })
    }

    fn launch(&mut self, lane: usize, launch: &Launch<'_>) {
        let radius = launch.ball.radius_m;
        let state = &mut self.lane;
        match launch.start {
            Start::Drop { height_m } => {
                state.ball_pos = [0.0, 0.0, radius + height_m];
                // The engine's velocities are half a step behind its positions; so the fall follows the parabola exactly.
                let scene = self.engine.scene();
                state.ball_vel = [0.0, 0.0, -0.5 * scene.gravity * scene.physics_dt_s];
                state.ball_ang_vel = [0.0; 3];
            }
            Start::Roll { speed, spin, .. } => {
                state.ball_pos = [0.0, 0.0, radius];
                state.ball_vel = [speed, 0.0, 0.0];
                state.ball_ang_vel = [0.0, spin * speed / radius, 0.0];
            }
        }
        self.engine.set_params(0, lane, &EnvParams { ball: launch.ball, ..EnvParams::default() });
        self.engine.reset_lane(0, lane, &self.lane);
    }

    fn record(&mut self) {
        let pos = &self.engine.state(0).ball.pos.0;
        self.trace.push([pos[2], pos[0]]);
    }

    fn read(&self, lane: usize, launch: &Launch<'_>, dt: f64) -> Vec<f64> {
        let (which, offset) = match launch.start {
            Start::Drop { .. } => (0, -launch.ball.radius_m),
            Start::Roll { offset_m, .. } => (1, offset_m),
        };
        let at = |i: usize| self.trace[i.min(self.trace.len() - 1)][which].lane(lane);
        let value = |t: &f64| {
            let step = (t / dt).max(0.0);
            let i = step as usize;
            let (a, b) = (at(i), at(i + 1));
            (b - a).mul_add(step - i as f64, a) + offset
        };
        launch.times.iter().map(value).collect()
    }
}

impl<V: Real> Lab for EngineLab<V> {
    fn run(&mut self, launches: &[Launch<'_>]) -> Vec<Vec<f64>> {
        let dt = self.engine.scene().physics_dt_s;
        let mut out = Vec::with_capacity(launches.len());
        for chunk in launches.chunks(V::LANES) {
            // Lanes to spare follow the last launch again.
            let Some(last) = chunk.last() else { continue };
            for lane in 0..V::LANES {
                self.launch(lane, chunk.get(lane).unwrap_or(last));
            }
            let end = chunk.iter().filter_map(|l| l.times.last()).copied().fold(0.0, f64::max);
            let steps = (end / dt).ceil() as usize + 1;
            self.trace.clear();
            self.engine.step_balls(0, 0);
            self.record();
            for _ in 0..steps {
                self.engine.step_balls(0, 1);
                self.record();
            }
            out.extend(chunk.iter().enumerate().map(|(lane, launch)| self.read(lane, launch, dt)));
        }
        self.rollouts += launches.len() as u64;
        out
    }

    fn rollouts(&self) -> u64 {
        self.rollouts
    }
}

#[cfg(test)]
mod tests {
    use paid_lanes::F32Array;

    use super::*;
    use crate::options::with_parameters;

    const G: f64 = 9.81;

    fn times() -> Vec<f64> {
        (0..=20).map(|i| 0.1 * f64::from(i)).collect()
    }

    /// Ground coefficients of 1 by multiplication: the ball's own hold.
    fn scene() -> SceneConfig {
        let ground = paid_physics::Material { static_friction: 1.0, dynamic_friction: 1.0, restitution: 1.0 };
        let rule = paid_physics::Combine::Multiply;
        let base = SceneConfig::default();
        SceneConfig { ground, ground_friction_combine: rule, ground_restitution_combine: rule, ..base }
    }

    #[test]
    fn a_drop_follows_the_parabola_and_returns_to_the_square_of_the_restitution() {
        let times = times();
        let ball = with_parameters(&BallParams::default(), &[0.5, 0.5, 0.7, 0.0, 0.0]);
        let launch = Launch { ball, start: Start::Drop { height_m: 1.5 }, times: &times };
        let found = &EngineLab::<f64>::new(&scene()).expect("scene").run(&[launch])[0];
        let impact = (2.0 * 1.5 / G).sqrt();
        for (t, h) in times.iter().zip(found) {
            let up = t - impact;
            let exact =
                if up < 0.0 { 1.5 - 0.5 * G * t * t } else { 0.7 * G * impact * up - 0.5 * G * up * up };
            // To the second impact.
            if up < 2.0 * 0.7 * impact {
                assert!((h - exact).abs() < 0.005, "at {t}: {h}, expected {exact}");
            }
        }
    }

    #[test]
    fn a_rolling_ball_slows_by_the_dampings_alone() {
        let times = times();
        let k = 2.0 / 3.0;
        for (linear, angular) in [(0.01, 4.28), (0.5, 1.0)] {
            let ball = with_parameters(&BallParams::default(), &[0.9, 0.1, 0.7, linear, angular]);
            let start = Start::Roll { speed: 2.0, offset_m: 0.3, spin: 1.0 };
            let found = &EngineLab::<f64>::new(&scene()).expect("scene").run(&[Launch {
                ball,
                start,
                times: &times,
            }])[0];
            let rate = (linear + k * angular) / (1.0 + k);
            for (t, d) in times.iter().zip(found) {
                let exact = 0.3 + 2.0 / rate * (1.0 - (-rate * t).exp());
                // Half a physics step of damping: 0.5%.
                assert!((d - exact).abs() < 0.008 * exact, "at {t}: {d}, expected {exact}");
            }
        }
    }

    #[test]
    fn every_launch_has_its_own_ball_start_and_times_whatever_the_batch() {
        let (long, short) = (times(), vec![0.0, 0.033, 0.05]);
        let launches: Vec<Launch<'_>> = (0..11)
            .map(|i| {
                let x = 0.05 * f64::from(i);
                let ball = with_parameters(&BallParams::default(), &[0.8, 0.3, 0.3 + x, x, 1.0 + x]);
                let start = if i % 2 == 0 {
                    Start::Drop { height_m: 1.0 + x }
                } else {
                    Start::Roll { speed: 1.0 + x, offset_m: x, spin: 1.0 }
                };
                Launch { ball, start, times: if i % 3 == 0 { &short } else { &long } }
            })
            .collect();
        let mut lab = EngineLab::<F32Array<8>>::new(&scene()).expect("scene");
        let together = lab.run(&launches);
        assert_eq!((together.len(), lab.rollouts()), (11, 11));
        for (launch, found) in launches.iter().zip(&together) {
            assert_eq!(found.len(), launch.times.len());
            assert_eq!(&lab.run(&[*launch])[0], found);
        }
    }
}
