//! Physical parameters of an episode: nominal, or drawn from the preset's ranges.

use paid_lanes::rng::Rng;
use paid_physics::{EnvParams, Material, MotorScale};

use crate::episode::reset::{StartContext, draw};
use crate::preset::Range;
use crate::scene::contact_kind::draw_kind;

/// A factor that changes nothing.
const NONE: Range = [1.0, 1.0];

impl StartContext<'_> {
    /// Factors of gains and masses, where the preset has them.
    fn scales(&self, params: &mut EnvParams, rng: &mut Rng) {
        let ranges = &self.config.preset.randomization;
        if ranges.gain_scale != NONE {
            params.gain_scale = [draw(ranges.gain_scale, rng), draw(ranges.gain_scale, rng)];
        }
        if ranges.link_mass_scale != NONE || ranges.base_mass_scale != NONE {
            params.mass_scale = (0..self.config.bodies).map(|_| draw(ranges.link_mass_scale, rng)).collect();
            params.mass_scale[0] = draw(ranges.base_mass_scale, rng);
        }
        if ranges.armature_scale != NONE || ranges.joint_friction_scale != NONE {
            let mut motor = |_| MotorScale {
                armature: draw(ranges.armature_scale, rng),
                friction: draw(ranges.joint_friction_scale, rng),
                ..MotorScale::ONE
            };
            params.motor_scale = (0..self.config.joints()).map(&mut motor).collect();
        }
    }

    /// Delays of actions and observations [control steps].
    pub(crate) fn delays(&self, rng: &mut Rng) -> [f64; 2] {
        let preset = &self.config.preset;
        let ranges = &preset.randomization;
        if !self.randomize || !ranges.delays() {
            return [preset.action_delay_s / self.config.dt_s, 0.0];
        }
        [ranges.action_delay_s, ranges.observation_delay_s].map(|r| draw(r, rng) / self.config.dt_s)
    }

    /// Physical parameters: nominal, or drawn from the preset's ranges.
    pub(crate) fn params(&self, rng: &mut Rng) -> (EnvParams, Vec<f64>) {
        let preset = &self.config.preset;
        let ranges = &preset.randomization;
        let mut params = EnvParams {
            robot: preset.robot_material,
            ball: preset.ball_params,
            kind: preset.contact_kind,
            ..EnvParams::default()
        };
        let mut offsets = vec![0.0; self.config.joints()];
        if !self.randomize {
            return (params, offsets);
        }
        if let (true, paid_physics::Terrain::Rough { cell_m, size, .. }) =
            (ranges.terrain_offset, &preset.scene.terrain)
        {
            let side = cell_m * *size as f64;
            params.terrain_offset = [rng.uniform(0.0, side), rng.uniform(0.0, side)];
        }
        if ranges.robot {
            let static_friction = draw(ranges.static_friction, rng);
            params.robot = Material {
                static_friction,
                dynamic_friction: draw(ranges.dynamic_friction, rng).min(static_friction),
                restitution: draw(ranges.restitution, rng),
            };
            params.base_com_offset =
                [ranges.base_com_x_m, ranges.base_com_yz_m, ranges.base_com_yz_m].map(|r| draw(r, rng));
            for offset in &mut offsets {
                *offset = draw(ranges.joint_default_rad, rng);
            }
        }
        if ranges.ball {
            let static_friction = draw(ranges.ball_static_friction, rng);
            params.ball.mass_kg = draw(ranges.ball_mass_kg, rng);
            params.ball.material = Material {
                static_friction,
                dynamic_friction: draw(ranges.ball_dynamic_friction, rng).min(static_friction),
                restitution: draw(ranges.ball_restitution, rng),
            };
            params.ball.linear_damping = draw(ranges.ball_linear_damping, rng);
            params.ball.angular_damping = draw(ranges.ball_angular_damping, rng);
        }
        if !ranges.surfaces.is_empty() {
            let surface = &ranges.surfaces[self.env as usize % ranges.surfaces.len()];
            surface.perturbed(ranges.surface_deviation, rng).apply(&mut params.ball);
        }
        self.scales(&mut params, rng);
        if ranges.kinds() {
            params.kind = draw_kind(ranges, &preset.scene, &params, rng);
        }
        let variants = &self.config.variants;
        if !variants.is_empty() {
            variants[rng.below(variants.len())].apply(&mut params);
        }
        (params, offsets)
    }
}
