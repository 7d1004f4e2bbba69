//! `paid robot run --live`: a page that shows what the runtime knows about its robot, and that can stop it.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use paid_eval::metrics::shooting::fallen;
use paid_lanes::{Quat, Vec3};
use paid_live::{Body, Flags, Frame, Pose2, WatchPage};
use paid_robot::kinematics::forward;
use paid_robot_program::{PlayerArgs, Teller};
use paid_runtime::{LiveStatus, Player, State, Status, Told};

use super::watch::{anchor, believed, in_view, serve};
use crate::live::LiveArgs;

/// Where a ball or goal of unknown position is drawn: out of sight, below the ground `[m]`.
const BURIED_M: f64 = -9.0;

/// The page of a runtime.
pub struct Mirror {
    page: WatchPage,
    player: Arc<Player>,
    pictures: u32,
    lay: bool,
}

impl Mirror {
    /// Serves the page and says its address, if it was asked for. The page's stop sets `stop`, from the server's thread: [`Mirror::tell`] may
    /// wait for a terminal.
    pub fn open(
        live: &LiveArgs,
        args: &PlayerArgs,
        player: &Arc<Player>,
        stop: &Arc<AtomicBool>,
    ) -> Result<Option<Teller>, paid_terminal::Failure> {
        if !live.live {
            return Ok(None);
        }
        let shown = ["the robot", "The robot is damped, and the program ends"];
        let page = serve(live, args, player, shown, "what the robot's sensors report", stop)
            .map_err(paid_terminal::Failure::input)?;
        // Standard output may be lines of JSON.
        eprintln!("{}  <- open this in a browser to watch", page.url());
        let mut mirror = Self { page, player: Arc::clone(player), pictures: 0, lay: false };
        Ok(Some(Box::new(move |told| mirror.tell(told))))
    }

    /// Shows an event or status. A page that fails does not end the run.
    fn tell(&mut self, told: Told<'_>) {
        match told {
            Told::Event(event) => {
                let _ = self.page.say(format!("{} -> {}: {}", event.from, event.to, event.reason));
            }
            Told::Status(LiveStatus { runtime, .. }) => {
                let frame = self.frame(runtime);
                if frame.flags.fallen && !self.lay {
                    let _ = self.page.fell();
                }
                self.lay = frame.flags.fallen;
                self.page.show(frame);
            }
        }
    }

    /// The robot as the runtime has it: place by odometry, posture by its joints, ball and goal by its belief.
    fn frame(&mut self, status: &Status) -> Frame {
        self.pictures += 1;
        let (model, spec) = (&self.player.model, &self.player.spec);
        let base = status.odometry_m.unwrap_or([0.0, 0.0, spec.nominal_height_m]);
        let quat = Quat(status.base_quat);
        let joints: Vec<f64> = status.joints.iter().map(|joint| f64::from(joint.pos_rad)).collect();
        let poses = forward(model, Vec3(base), quat, &joints);
        let torso = &poses[anchor(&self.player)];
        let axes = Pose2 { xy: [torso.pos.x(), torso.pos.y()], heading: torso.rot().yaw() };
        let radius = self.player.play.ball_params.radius_m;
        let belief = believed(status, &axes, radius);
        let ball = belief.map_or([base[0], base[1], BURIED_M], |belief| belief.pos.map(f64::from));
        // The goal is drawn beyond the horizon until its position is known.
        let [gx, gy] = status.goal_m.unwrap_or([base[0] + 1e3, base[1]]);
        Frame {
            flags: Flags {
                fallen: fallen(base[2], quat.to_mat().0[2][2], spec.nominal_height_m),
                kicking: status.state == State::Kick,
                in_view: in_view(belief.as_ref()),
                ..Flags::default()
            },
            step: self.pictures,
            time_s: status.at_us as f64 * 1e-6,
            rate: [1.0; 2],
            ball: Body { pos: ball, quat: [1.0, 0.0, 0.0, 0.0] },
            goal: [gx as f32, gy as f32, (gy - base[1]).atan2(gx - base[0]) as f32],
            engine: 0,
            bodies: poses.iter().map(|pose| Body { pos: pose.pos.0, quat: pose.quat.0 }).collect(),
            belief,
            ..Frame::default()
        }
    }
}
