//! Exact save and restore of a shard.
//!
//! Little-endian bytes: the numbers of the lanes widen to `f64` and come back exactly.

use paid_lanes::Real;
use paid_physics::{EnvParams, LaneState, Material, Simulator};

use crate::words::{Reader, Writer};
use crate::{EndCause, InitialState, KickEvent, Task, TaskMetrics};

/// First bytes of a snapshot; the last is the version.
const MAGIC: &[u8; 8] = b"paidtsk\x03";

fn write_material(w: &mut Writer, m: &Material) {
    w.all(&[m.static_friction, m.dynamic_friction, m.restitution]);
}

fn read_material(r: &mut Reader<'_>) -> Result<Material, String> {
    let [static_friction, dynamic_friction, restitution] = r.array()?;
    Ok(Material { static_friction, dynamic_friction, restitution })
}

fn write_params(w: &mut Writer, p: &EnvParams) {
    write_material(w, &p.robot);
    w.all(&p.base_com_offset);
    w.list(&p.mass_scale);
    w.all(&p.gain_scale);
    w.all(&[p.ball.mass_kg, p.ball.radius_m, p.ball.inertia_factor]);
    write_material(w, &p.ball.material);
    w.all(&[p.ball.linear_damping, p.ball.angular_damping]);
    w.all(&p.terrain_offset);
}

fn read_params(r: &mut Reader<'_>) -> Result<EnvParams, String> {
    let robot = read_material(r)?;
    let base_com_offset = r.array()?;
    let mass_scale = r.list()?;
    let gain_scale = r.array()?;
    let [mass_kg, radius_m, inertia_factor] = r.array()?;
    let material = read_material(r)?;
    let [linear_damping, angular_damping] = r.array()?;
    Ok(EnvParams {
        robot,
        base_com_offset,
        mass_scale,
        gain_scale,
        ball: paid_physics::BallParams {
            mass_kg,
            radius_m,
            inertia_factor,
            material,
            linear_damping,
            angular_damping,
        },
        terrain_offset: r.array()?,
    })
}

fn write_state(w: &mut Writer, s: &LaneState) {
    w.all(&s.base_pos);
    w.all(&s.base_quat);
    w.all(&s.base_lin_vel);
    w.all(&s.base_ang_vel);
    w.list(&s.joint_pos);
    w.list(&s.joint_vel);
    w.all(&s.ball_pos);
    w.all(&s.ball_vel);
    w.all(&s.ball_ang_vel);
    w.list(&s.warm_start);
}

fn read_state(r: &mut Reader<'_>) -> Result<LaneState, String> {
    Ok(LaneState {
        base_pos: r.array()?,
        base_quat: r.array()?,
        base_lin_vel: r.array()?,
        base_ang_vel: r.array()?,
        joint_pos: r.list()?,
        joint_vel: r.list()?,
        ball_pos: r.array()?,
        ball_vel: r.array()?,
        ball_ang_vel: r.array()?,
        warm_start: r.list()?,
    })
}

fn write_kick(w: &mut Writer, kick: Option<&KickEvent>) {
    w.u64(u64::from(kick.is_some()));
    let Some(kick) = kick else { return };
    w.u64(u64::from(kick.step));
    w.u64(kick.foot as u64);
    w.u64(u64::from(kick.correct));
    w.f64(kick.body.map_or(-1.0, |b| b as f64));
    w.all(&kick.foot_vel);
    w.u64(u64::from(kick.ball_vel_after.is_some()));
    w.all(&kick.ball_vel_after.unwrap_or_default());
}

fn read_kick(r: &mut Reader<'_>) -> Result<Option<KickEvent>, String> {
    if r.u64()? == 0 {
        return Ok(None);
    }
    let (step, foot, correct) = (r.u32()?, r.usize()?, r.u64()? == 1);
    let body = r.f64()?;
    let foot_vel = r.array()?;
    let known = r.u64()? == 1;
    let after = r.array()?;
    Ok(Some(KickEvent {
        step,
        foot,
        correct,
        body: (body >= 0.0).then_some(body as usize),
        foot_vel,
        ball_vel_after: known.then_some(after),
    }))
}

fn write_forced(w: &mut Writer, forced: Option<&InitialState>) {
    w.u64(u64::from(forced.is_some()));
    let Some(f) = forced else { return };
    w.u64(f.motion as u64);
    w.u64(f.frame as u64);
    for place in [f.ball_xy, f.goal_xy] {
        w.u64(u64::from(place.is_some()));
        w.all(&place.unwrap_or_default());
    }
    w.all(&f.ball_velocity);
    w.all(&f.displacement);
    w.u64(u64::from(f.noise));
}

fn read_forced(r: &mut Reader<'_>) -> Result<Option<InitialState>, String> {
    if r.u64()? == 0 {
        return Ok(None);
    }
    let (motion, frame) = (r.usize()?, r.usize()?);
    let mut places = [None; 2];
    for place in &mut places {
        let known = r.u64()? == 1;
        let xy = r.array()?;
        *place = known.then_some(xy);
    }
    Ok(Some(InitialState {
        motion,
        frame,
        ball_xy: places[0],
        goal_xy: places[1],
        ball_velocity: r.array()?,
        displacement: r.array()?,
        noise: r.u64()? == 1,
    }))
}

fn cause_from(code: u64) -> Result<Option<EndCause>, String> {
    match code {
        0 => Ok(None),
        n => EndCause::ALL
            .get(n as usize - 1)
            .copied()
            .map(Some)
            .ok_or_else(|| format!("task snapshot: {n} is no cause of an episode's end")),
    }
}

fn metric_numbers(m: &mut TaskMetrics) -> (Vec<&mut f64>, Vec<&mut u64>) {
    let mut sums: Vec<&mut f64> = m.reward_terms.iter_mut().collect();
    sums.extend(m.tracking.iter_mut());
    sums.extend([&mut m.kick_foot_peak_sum, &mut m.reference_foot_peak_sum, &mut m.episode_return_sum]);
    sums.extend([&mut m.kick.ball_speed_sum, &mut m.kick.ball_cosine_sum]);
    let mut counts = vec![&mut m.steps, &mut m.episodes, &mut m.episode_steps];
    counts.extend(m.ends.iter_mut());
    counts.extend([&mut m.kick.episodes, &mut m.kick.contacts, &mut m.kick.correct_foot]);
    counts.extend([&mut m.kick.goals, &mut m.kick.on_target]);
    (sums, counts)
}

impl<V: Real, S: Simulator<V>> Task<V, S> {
    pub(crate) fn save_bytes(&self) -> Vec<u8> {
        let mut w = Writer(MAGIC.to_vec());
        for size in [self.envs.len(), V::LANES, self.config.joints(), self.library.len(), self.library.bins()]
        {
            w.u64(size as u64);
        }
        w.u64(self.seed);
        w.u64(self.observations);
        w.f64(f64::from(self.sampler.spread));
        for x in self.sampler.failures.iter().chain(&self.sampler.probabilities).chain(&self.failures) {
            w.f64(f64::from(*x));
        }
        let mut metrics = self.metrics.clone();
        let (sums, counts) = metric_numbers(&mut metrics);
        for x in sums {
            w.f64(*x);
        }
        for n in counts {
            w.u64(*n);
        }
        for value in self.sums.terms.iter().chain(&self.sums.tracking) {
            for lane in 0..V::LANES {
                w.f64(value.lane(lane));
            }
        }
        for (index, env) in self.envs.iter().enumerate() {
            w.u64(u64::from(env.id));
            w.u64(env.motion as u64);
            w.u64(env.frame as u64);
            w.u64(u64::from(env.step));
            w.u64(u64::from(env.push_in));
            w.u64(env.reset_rng.position());
            w.u64(env.push_rng.position());
            w.u64(env.ended.map_or(0, |c| c as u64 + 1));
            write_kick(&mut w, env.kick.as_ref());
            write_forced(&mut w, env.forced.as_ref());
            write_params(&mut w, &env.params);
            write_state(&mut w, &self.sim.save_lane(index / V::LANES, index % V::LANES));
        }
        for group in &self.groups {
            for field in group.clone().fields() {
                for lane in 0..V::LANES {
                    w.f64(field.lane(lane));
                }
            }
        }
        w.0
    }

    pub(crate) fn restore_bytes(&mut self, bytes: &[u8]) -> Result<(), String> {
        if !bytes.starts_with(MAGIC) {
            return Err("task snapshot: it does not begin as one of this version should".into());
        }
        let mut r = Reader::new(bytes, MAGIC.len());
        r.expect("environments", self.envs.len())?;
        r.expect("lanes", V::LANES)?;
        r.expect("joints", self.config.joints())?;
        r.expect("motions", self.library.len())?;
        r.expect("phase bins", self.library.bins())?;
        let seed = r.u64()?;
        if seed != self.seed {
            return Err(format!("task snapshot: seed: expected {}, found {seed}", self.seed));
        }
        self.observations = r.u64()?;
        self.sampler.spread = r.f64()? as f32;
        let sampler = &mut self.sampler;
        for x in sampler.failures.iter_mut().chain(&mut sampler.probabilities).chain(&mut self.failures) {
            *x = r.f64()? as f32;
        }
        let (sums, counts) = metric_numbers(&mut self.metrics);
        for x in sums {
            *x = r.f64()?;
        }
        for n in counts {
            *n = r.u64()?;
        }
        for value in self.sums.terms.iter_mut().chain(&mut self.sums.tracking) {
            for lane in 0..V::LANES {
                value.set_lane(lane, r.f64()?);
            }
        }
        for index in 0..self.envs.len() {
            self.restore_env(index, &mut r)?;
        }
        for group in 0..self.groups.len() {
            for field in self.groups[group].fields() {
                for lane in 0..V::LANES {
                    field.set_lane(lane, r.f64()?);
                }
            }
            self.sim.refresh(group);
            self.gather_reference(group);
        }
        if r.left() == 0 { Ok(()) } else { Err(format!("task snapshot: {} bytes are left over", r.left())) }
    }

    fn restore_env(&mut self, index: usize, r: &mut Reader<'_>) -> Result<(), String> {
        let env = &mut self.envs[index];
        r.expect("environment number", env.id as usize)?;
        env.motion = r.usize()?;
        env.frame = r.usize()?;
        let facts = self.library.facts().get(env.motion);
        if facts.is_none_or(|f| env.frame == 0 || env.frame > f.frames) {
            return Err(format!("task snapshot: motion {} has no frame {}", env.motion, env.frame));
        }
        env.step = r.u32()?;
        env.push_in = r.u32()?;
        env.reset_rng.seek(r.u64()?);
        env.push_rng.seek(r.u64()?);
        env.ended = cause_from(r.u64()?)?;
        env.kick = read_kick(r)?;
        env.forced = read_forced(r)?;
        env.params = read_params(r)?;
        let state = read_state(r)?;
        if state.joint_pos.len() != self.config.joints() || state.joint_vel.len() != self.config.joints() {
            return Err("task snapshot: a state has another number of joints".into());
        }
        let (group, lane) = (index / V::LANES, index % V::LANES);
        self.sim.set_params(group, lane, &self.envs[index].params);
        self.sim.reset_lane(group, lane, &state);
        Ok(())
    }
}
