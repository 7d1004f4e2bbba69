//! Contact forces of a step, by body.

use crate::world::World;

/// Numbers of bodies in MuJoCo; the world is 0 and the robot's body `b` is `b + 1`.
#[derive(Clone, Debug)]
pub(crate) struct ContactReport {
    /// Net force on each robot body, world axes, the largest so far `[N]`.
    pub body: Vec<[f64; 3]>,
    /// Net force of the robot on the ball, world axes, the largest so far `[N]`.
    pub ball_robot: [f64; 3],
    /// Net force of the ground on the ball, world axes, the largest so far `[N]`.
    pub ball_ground: [f64; 3],
    /// The robot body with the largest share of `ball_robot` at that instant.
    pub touched_by: Option<usize>,
    net: Vec<[f64; 3]>,
    on_ball: Vec<[f64; 3]>,
}

fn norm(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

fn add(to: &mut [f64; 3], v: [f64; 3], sign: f64) {
    for k in 0..3 {
        to[k] += sign * v[k];
    }
}

impl ContactReport {
    /// For a robot of `bodies` bodies.
    pub(crate) fn new(bodies: usize) -> Self {
        Self {
            body: vec![[0.0; 3]; bodies],
            ball_robot: [0.0; 3],
            ball_ground: [0.0; 3],
            touched_by: None,
            net: vec![[0.0; 3]; bodies],
            on_ball: vec![[0.0; 3]; bodies],
        }
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.body.fill([0.0; 3]);
        (self.ball_robot, self.ball_ground, self.touched_by) = ([0.0; 3], [0.0; 3], None);
    }

    /// Takes in the contacts of the last physics step. `ball` is the ball's body number in MuJoCo.
    pub(crate) fn take(&mut self, world: &World, ball: Option<usize>) {
        self.net.fill([0.0; 3]);
        self.on_ball.fill([0.0; 3]);
        let bodies = self.net.len();
        let robot = |body: usize| (1..=bodies).contains(&body).then(|| body - 1);
        let (mut ball_net, mut ball_ground) = ([0.0; 3], [0.0; 3]);
        for i in 0..world.contact_count() {
            let pair = world.contact(i).geoms.map(|g| world.geom_body(g));
            let force = world.contact_force(i);
            for (me, other, sign) in [(pair[0], pair[1], -1.0), (pair[1], pair[0], 1.0)] {
                if let Some(b) = robot(me) {
                    add(&mut self.net[b], force, sign);
                } else if Some(me) == ball {
                    match robot(other) {
                        Some(b) => {
                            add(&mut self.on_ball[b], force, sign);
                            add(&mut ball_net, force, sign);
                        }
                        None => add(&mut ball_ground, force, sign),
                    }
                }
            }
        }
        for (largest, net) in self.body.iter_mut().zip(&self.net) {
            if norm(*net) > norm(*largest) {
                *largest = *net;
            }
        }
        if norm(ball_ground) > norm(self.ball_ground) {
            self.ball_ground = ball_ground;
        }
        if norm(ball_net) > norm(self.ball_robot) {
            self.ball_robot = ball_net;
            let shares = self.on_ball.iter().map(|f| norm(*f));
            self.touched_by = shares
                .enumerate()
                .fold((None, 0.0), |best, (b, f)| if f > best.1 { (Some(b), f) } else { best })
                .0;
        }
    }
}
