//! The vendor's controller of a virtual robot: in command until it is released over the motion switcher's topics.

use paid_runtime::switcher::{Line, SwitcherService};
use paid_runtime::wire::{LowCmd, MotorCmd};
use paid_runtime::{Inlet, Limits, Link, LinkError, Outlet, Packet, Player};

/// A robot's end of the link with the vendor's controller in it. While that is in command it holds the standing pose, and commands from the
/// network do nothing. Released, the robot goes limp until another program commands it.
pub struct VendorLink {
    out: Box<dyn Outlet>,
    inlet: VendorInlet,
}

struct VendorInlet {
    from: Box<dyn Inlet>,
    line: Box<dyn Line>,
    service: SwitcherService,
    standing: LowCmd,
    /// Commands of the vendor's that this round of receiving has given.
    given: bool,
    commanded: bool,
}

impl VendorLink {
    /// Puts the vendor's controller between robot and network. `line` carries the switcher's requests.
    pub fn new(link: impl Link, line: Box<dyn Line>, service: SwitcherService, player: &Player) -> Self {
        let (out, from) = link.split();
        let standing = standing(player, &Limits::default());
        Self { out, inlet: VendorInlet { from, line, service, standing, given: false, commanded: false } }
    }
}

/// What holds the standing pose: the runtime's own standing gains.
fn standing(player: &Player, limits: &Limits) -> LowCmd {
    let mut command = LowCmd { mode_machine: player.mode_machine, ..LowCmd::default() };
    for (j, &motor) in player.motors.iter().enumerate() {
        let kp = (limits.stand_stiffness * player.control.stiffness[j]).min(limits.stand_stiffness_most);
        command.motors[motor] = MotorCmd {
            mode: 1,
            q: player.control.default_pos[j] as f32,
            kp: kp as f32,
            kd: (limits.stand_damping * player.control.damping[j]) as f32,
            ..MotorCmd::default()
        };
    }
    command.sealed()
}

impl Inlet for VendorInlet {
    fn receive(&mut self) -> Result<Option<Packet>, LinkError> {
        self.service.serve(&mut *self.line)?;
        let vendor = !self.service.master().is_empty();
        while let Some(packet) = self.from.receive()? {
            if !(vendor && matches!(packet, Packet::LowCmd(_))) {
                return Ok(Some(packet));
            }
        }
        // The last packet of the round is the vendor's: its command, or once the one that lets go.
        if !self.given && (vendor || self.commanded) {
            (self.given, self.commanded) = (true, vendor);
            let command = if vendor { self.standing.clone() } else { LowCmd::default().sealed() };
            return Ok(Some(Packet::LowCmd(command.to_cdr())));
        }
        self.given = false;
        Ok(None)
    }
}

impl Outlet for VendorLink {
    fn send(&mut self, packet: Packet) -> Result<(), LinkError> {
        self.out.send(packet)
    }
    fn command(&mut self, command: &LowCmd) -> Result<(), LinkError> {
        self.out.command(command)
    }
}

impl Inlet for VendorLink {
    fn receive(&mut self) -> Result<Option<Packet>, LinkError> {
        self.inlet.receive()
    }
}

impl Link for VendorLink {
    fn split(self) -> (Box<dyn Outlet>, Box<dyn Inlet>) {
        (self.out, Box::new(self.inlet))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use paid_runtime::switcher::{ApiRequest, RELEASE_MODE};
    use paid_runtime::{ChannelLink, PlayerSpec};

    /// A line on which one request comes after this many looks.
    struct Later(usize);

    impl Line for Later {
        fn send(&mut self, _bytes: Vec<u8>) -> Result<(), LinkError> {
            Ok(())
        }
        fn receive(&mut self) -> Result<Option<Vec<u8>>, LinkError> {
            self.0 = self.0.wrapping_sub(1);
            let request = ApiRequest { api_id: RELEASE_MODE, ..ApiRequest::default() };
            Ok((self.0 == 0).then(|| request.to_cdr()))
        }
    }

    #[test]
    fn commands_from_the_network_do_nothing_before_the_release() {
        let policy = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
        let player = Player::load(&PlayerSpec { policy, motions: None, sets: Vec::new() }).expect("policy");
        let (robot, mut runtime) = ChannelLink::pair();
        // A round of receiving is two looks while the vendor commands: its command, then nothing.
        let mut link = VendorLink::new(robot, Box::new(Later(5)), SwitcherService::new("ai"), &player);
        let mut round = || {
            runtime.send(Packet::LowCmd(LowCmd::damping(5, 29, 3.0).to_cdr())).expect("send");
            let mut commands = Vec::new();
            while let Some(packet) = link.receive().expect("link") {
                let Packet::LowCmd(bytes) = packet else { continue };
                let command = LowCmd::from_cdr(&bytes).expect("command");
                assert_eq!(command.crc, command.expected_crc());
                commands.push((command.motors[4].mode, command.motors[4].kp));
            }
            commands
        };
        // Ankle pitch: ten times the policy's 28.5 N m/rad.
        let vendor = round();
        assert!(matches!(vendor[..], [(1, kp)] if (280.0..=300.0).contains(&kp)), "{vendor:?}");
        assert_eq!(round(), vendor);
        // The release comes with the fifth look: the runtime's command, and once the vendor's that lets go.
        assert_eq!(round(), [(1, 0.0), (0, 0.0)]);
        assert_eq!(round(), [(1, 0.0)]);
    }
}
