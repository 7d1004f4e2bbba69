//! A moment of the scene.

use super::VERSION;

/// Bytes before the bodies.
const HEAD: usize = 72;
/// Bytes of a body.
const BODY: usize = 20;
/// Bytes of what is believed.
const BELIEF: usize = 20;
/// Bytes of a force.
const FORCE: usize = 7;
/// Marks the force of the robot on the ball.
const ON_BALL: u8 = 255;
/// Kind of the message.
const KIND: u8 = 1;

/// Place and orientation of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Body {
    /// Origin `[m]`.
    pub pos: [f64; 3],
    /// Orientation w, x, y, z.
    pub quat: [f64; 4],
}

/// A contact force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Force {
    /// Number of the body; `None`: on the ball.
    pub body: Option<u8>,
    /// The force `[N]`.
    pub newton: [f64; 3],
}

/// Where the robot believes the ball to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belief {
    /// Center `[m]`.
    pub pos: [f32; 3],
    /// Standard deviation of x and of y `[m]`.
    pub deviation_m: f32,
    /// Age of what was seen last `[s]`.
    pub age_s: f32,
}

/// Yes or no.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Bit 0: time stands still.
    pub paused: bool,
    /// Bit 1: balls come by themselves.
    pub auto: bool,
    /// Bit 2: the robot lies on the ground.
    pub fallen: bool,
    /// Bit 3: slower than asked.
    pub late: bool,
    /// Bit 4: the robot has touched this ball.
    pub touched: bool,
    /// Bit 5: the robot is busy with a kick.
    pub kicking: bool,
    /// Bit 6: a hand holds the ball.
    pub held: bool,
    /// Bit 7: the robot takes its first pose before every kick.
    pub fresh: bool,
    /// Bit 8: the ball is in the camera's image.
    pub in_view: bool,
}

/// The bit of a frame that says what is believed.
const BELIEVES: u16 = 1 << 9;

impl Flags {
    fn bits(self) -> u16 {
        let Self { paused, auto, fallen, late, touched, kicking, held, fresh, in_view } = self;
        let all = [paused, auto, fallen, late, touched, kicking, held, fresh, in_view];
        all.iter().enumerate().fold(0, |bits, (k, on)| bits | u16::from(*on) << k)
    }

    fn from_bits(bits: u16) -> Self {
        let on = |k: u16| bits >> k & 1 == 1;
        Self {
            paused: on(0),
            auto: on(1),
            fallen: on(2),
            late: on(3),
            touched: on(4),
            kicking: on(5),
            held: on(6),
            fresh: on(7),
            in_view: on(8),
        }
    }
}

/// A moment of the scene.
///
/// | byte | what |
/// |---|---|
/// | 0, 1 | [`VERSION`], kind 1 |
/// | 2 | u16: [`Flags`]; bit 9: a belief follows at the end |
/// | 4 | u32: number of the control step |
/// | 8 | f64: time `[s]` |
/// | 16, 20 | f32: course of time asked for, and kept |
/// | 24 | 3 f32: ball `[m]` |
/// | 36 | f32: its speed `[m/s]` |
/// | 40 | 4 i16: its orientation w, x, y, z times 32767 |
/// | 48 | 3 f32: goal x, y `[m]`, direction of the shot `[rad]` |
/// | 60, 61 | u8: engine, viewers |
/// | 62 | i16: clip, -1 for the one that suits the ball |
/// | 64 .. 67 | u8: bodies, bodies of the reference, forces, reward terms |
/// | 68 | f32: time that a control step takes `[ms]` |
/// | 72 | bodies: 3 f32 and 4 i16 each; then the reference's bodies |
/// | | forces: u8 body, 255 for the ball, and 3 i16 `[N]` each |
/// | | reward terms: f32 each |
/// | | belief: 3 f32 `[m]`, deviation `[m]`, age `[s]` |
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Yes or no.
    pub flags: Flags,
    /// Control steps since the scene began.
    pub step: u32,
    /// Time of the scene `[s]`.
    pub time_s: f64,
    /// Course of time: asked for, and kept.
    pub rate: [f32; 2],
    /// The ball.
    pub ball: Body,
    /// Its speed `[m/s]`.
    pub ball_speed: f32,
    /// Goal center (x, y) `[m]` and the direction in which balls pass into it `[rad]`.
    pub goal: [f32; 3],
    /// 0 built-in, 1 MuJoCo.
    pub engine: u8,
    /// Open pages.
    pub viewers: u8,
    /// The clip that was chosen.
    pub clip: Option<u16>,
    /// Time that a control step takes `[ms]`.
    pub cost_ms: f32,
    /// Bodies, model order.
    pub bodies: Vec<Body>,
    /// The reference's bodies, model order; may be empty.
    pub ghost: Vec<Body>,
    /// Contact forces.
    pub forces: Vec<Force>,
    /// Reward terms of the step.
    pub rewards: Vec<f32>,
    /// Where the robot estimates the ball, if it is not given the true position.
    pub belief: Option<Belief>,
}

fn put_body(out: &mut Vec<u8>, body: &Body) {
    for x in body.pos {
        out.extend((x as f32).to_le_bytes());
    }
    put_quat(out, &body.quat);
}

fn put_quat(out: &mut Vec<u8>, quat: &[f64; 4]) {
    for x in quat {
        out.extend(((x * 32767.0).round() as i16).to_le_bytes());
    }
}

impl Frame {
    /// The message. Lists are cut to 255 entries.
    pub fn encode(&self) -> Vec<u8> {
        let count = |n: usize| n.min(255);
        let counts = [self.bodies.len(), self.ghost.len(), self.forces.len(), self.rewards.len()].map(count);
        let [bodies, ghost, forces, rewards] = counts;
        let lists = BODY * (bodies + ghost) + FORCE * forces + 4 * rewards;
        let mut out = Vec::with_capacity(HEAD + lists + BELIEF);
        out.extend([VERSION, KIND]);
        let believes = if self.belief.is_some() { BELIEVES } else { 0 };
        out.extend((self.flags.bits() | believes).to_le_bytes());
        out.extend(self.step.to_le_bytes());
        out.extend(self.time_s.to_le_bytes());
        for x in self.rate {
            out.extend(x.to_le_bytes());
        }
        for x in self.ball.pos {
            out.extend((x as f32).to_le_bytes());
        }
        out.extend(self.ball_speed.to_le_bytes());
        put_quat(&mut out, &self.ball.quat);
        for x in self.goal {
            out.extend(x.to_le_bytes());
        }
        out.extend([self.engine, self.viewers]);
        out.extend(self.clip.map_or(-1, |c| i16::try_from(c).unwrap_or(i16::MAX)).to_le_bytes());
        out.extend(counts.map(|n| n as u8));
        out.extend(self.cost_ms.to_le_bytes());
        for body in self.bodies[..bodies].iter().chain(&self.ghost[..ghost]) {
            put_body(&mut out, body);
        }
        for force in &self.forces[..forces] {
            out.push(force.body.unwrap_or(ON_BALL));
            for x in force.newton {
                out.extend((x.round() as i16).to_le_bytes());
            }
        }
        for x in &self.rewards[..rewards] {
            out.extend(x.to_le_bytes());
        }
        if let Some(Belief { pos: [x, y, z], deviation_m, age_s }) = self.belief {
            for x in [x, y, z, deviation_m, age_s] {
                out.extend(x.to_le_bytes());
            }
        }
        out
    }

    /// Reads a message; `None` if it is no frame of this version.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let mut r = Reader { bytes, at: 0 };
        if r.take::<2>()? != [VERSION, KIND] {
            return None;
        }
        let bits = u16::from_le_bytes(r.take()?);
        let flags = Flags::from_bits(bits);
        let step = u32::from_le_bytes(r.take()?);
        let time_s = f64::from_le_bytes(r.take()?);
        let rate = [r.f32()?, r.f32()?];
        let pos = r.point()?;
        let ball_speed = r.f32()?;
        let ball = Body { pos, quat: r.quat()? };
        let goal = [r.f32()?, r.f32()?, r.f32()?];
        let [engine, viewers] = r.take()?;
        let clip = u16::try_from(i16::from_le_bytes(r.take()?)).ok();
        let [bodies, ghost, forces, rewards] = r.take::<4>()?.map(usize::from);
        let cost_ms = r.f32()?;
        let mut body = |_| Some(Body { pos: r.point()?, quat: r.quat()? });
        let bodies = (0..bodies).map(&mut body).collect::<Option<Vec<_>>>()?;
        let ghost = (0..ghost).map(&mut body).collect::<Option<Vec<_>>>()?;
        let force = |_| {
            let [body] = r.take()?;
            let newton = [r.i16()?, r.i16()?, r.i16()?];
            Some(Force { body: (body != ON_BALL).then_some(body), newton })
        };
        let forces = (0..forces).map(force).collect::<Option<Vec<_>>>()?;
        let rewards = (0..rewards).map(|_| r.f32()).collect::<Option<Vec<_>>>()?;
        let belief = if bits & BELIEVES == 0 {
            None
        } else {
            let pos = [r.f32()?, r.f32()?, r.f32()?];
            Some(Belief { pos, deviation_m: r.f32()?, age_s: r.f32()? })
        };
        (r.at == bytes.len()).then_some(Self {
            flags,
            step,
            time_s,
            rate,
            ball,
            ball_speed,
            goal,
            engine,
            viewers,
            clip,
            cost_ms,
            bodies,
            ghost,
            forces,
            rewards,
            belief,
        })
    }
}

/// Takes numbers from the front.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let part = self.bytes.get(self.at..self.at + N)?;
        self.at += N;
        part.try_into().ok()
    }
    fn f32(&mut self) -> Option<f32> {
        Some(f32::from_le_bytes(self.take()?))
    }
    fn i16(&mut self) -> Option<f64> {
        Some(f64::from(i16::from_le_bytes(self.take()?)))
    }
    fn point(&mut self) -> Option<[f64; 3]> {
        Some([f64::from(self.f32()?), f64::from(self.f32()?), f64::from(self.f32()?)])
    }
    fn quat(&mut self) -> Option<[f64; 4]> {
        Some([self.i16()?, self.i16()?, self.i16()?, self.i16()?].map(|x| x / 32767.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn frame() -> Frame {
        Frame {
            flags: Flags { paused: true, held: true, ..Flags::default() },
            step: 258,
            time_s: 5.16,
            rate: [0.5, 0.25],
            ball: Body { pos: [1.0, -2.0, 0.125], quat: [1.0, 0.0, 0.0, -1.0] },
            ball_speed: 4.0,
            goal: [5.0, 0.5, 0.0],
            engine: 1,
            viewers: 3,
            clip: None,
            cost_ms: 1.5,
            bodies: vec![Body { pos: [0.0, 0.0, 0.75], quat: [1.0, 0.0, 0.0, 0.0] }],
            ghost: Vec::new(),
            forces: vec![Force { body: None, newton: [-1.0, 2.0, 300.0] }],
            rewards: vec![-0.5],
            belief: Some(Belief { pos: [1.0, -2.0, 0.125], deviation_m: 0.25, age_s: 0.5 }),
        }
    }

    #[test]
    fn every_number_is_where_the_table_says() {
        let bytes = frame().encode();
        assert_eq!(bytes.len(), 72 + 20 + 7 + 4 + 20);
        // Bits 0, 6 and 9; step 258 = 0x0102.
        assert_eq!(bytes[..8], [2, 1, 0b0100_0001, 2, 2, 1, 0, 0]);
        assert_eq!(bytes[16..24], [0, 0, 0, 0x3F, 0, 0, 0x80, 0x3E]);
        assert_eq!(bytes[28..32], [0, 0, 0, 0xC0], "y of the ball is -2");
        assert_eq!(bytes[40..48], [0xFF, 0x7F, 0, 0, 0, 0, 0x01, 0x80], "1 and -1 of 32767");
        assert_eq!(bytes[60..68], [1, 3, 0xFF, 0xFF, 1, 0, 1, 1]);
        assert_eq!(bytes[80..84], [0, 0, 0x40, 0x3F], "the body is 0.75 m high");
        // On the ball: -1, 2 and 300 = 0x012C N.
        assert_eq!(bytes[92..99], [255, 0xFF, 0xFF, 2, 0, 0x2C, 1]);
        assert_eq!(bytes[99..103], [0, 0, 0, 0xBF]);
        // What is believed: 1 m ahead, deviation 0.25 m, 0.5 s old.
        assert_eq!(bytes[103..107], [0, 0, 0x80, 0x3F]);
        assert_eq!(bytes[115..], [0, 0, 0x80, 0x3E, 0, 0, 0, 0x3F]);
        assert_eq!(Frame { belief: None, ..frame() }.encode().len(), 72 + 20 + 7 + 4);
        assert_eq!(Frame::decode(&bytes), Some(frame()));
    }

    #[test]
    fn a_frame_that_is_cut_or_longer_is_none() {
        let bytes = frame().encode();
        assert!((0..bytes.len()).all(|n| Frame::decode(&bytes[..n]).is_none()));
        assert_eq!(Frame::decode(&[bytes, vec![0]].concat()), None);
    }

    proptest! {
        #[test]
        fn no_bytes_break_the_reader(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let mut bytes = bytes;
            let _ = Frame::decode(&bytes);
            for (k, x) in [VERSION, KIND].into_iter().enumerate().take(bytes.len()) {
                bytes[k] = x;
            }
            let _ = Frame::decode(&bytes);
        }
    }
}
