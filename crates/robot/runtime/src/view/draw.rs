//! Lines and cells, 80 columns and 24 rows.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::widgets::Widget;

use super::View;
use crate::live::LiveStatus;
use crate::motors::G1_MOTORS;
use crate::runtime::{JointStatus, State};

/// Rows of each half of the joint table.
const HALF: usize = G1_MOTORS.len().div_ceil(2);
/// Where the second half begins.
const SECOND: usize = 39;

impl Widget for &View {
    fn render(self, area: Rect, buffer: &mut Buffer) {
        let mut row = 0;
        let mut line = |text: &str, style: Style| {
            if row < area.height {
                buffer.set_stringn(area.x, area.y + row, text, usize::from(area.width), style);
            }
            row += 1;
        };
        let plain = Style::new();
        let Some(status) = &self.status else {
            line("state     no status yet", plain);
            return;
        };
        line(&state(status), state_style(status));
        line(&format!("last      {}", self.last), plain);
        let (commands, alarming) = in_command(status);
        line(&format!("command   {commands}"), if alarming { alarm() } else { plain });
        line(&rates(status), plain);
        line(&body(status), plain);
        line(&ball(status), plain);
        line(&hottest(status), plain);
        line("keys      u: stand up (L2+Up)  k: kicks (R1+X)  b: damping (L2+B)  q: quit", plain);
        let head = cells("joint", ["angle", "target", "Nm", "deg"].map(str::to_owned));
        line(&format!("{head} {head}"), Style::new().add_modifier(Modifier::BOLD));
        for k in 0..HALF {
            let mut text = joint(k, &status.runtime.joints[k]);
            if let Some(other) = status.runtime.joints.get(k + HALF) {
                text = format!("{text:<SECOND$} {}", joint(k + HALF, other));
            }
            line(&text, plain);
        }
    }
}

fn alarm() -> Style {
    Style::new().fg(Color::Red).add_modifier(Modifier::BOLD)
}

fn state_style(status: &LiveStatus) -> Style {
    if status.runtime.state == State::Damping { alarm() } else { Style::new().add_modifier(Modifier::BOLD) }
}

fn state(status: &LiveStatus) -> String {
    let s = &status.runtime;
    let policy = if s.policy { " (policy)" } else { "" };
    let waiting = if s.state == State::Ready && !s.waiting.is_empty() {
        format!(", waits for {}", s.waiting)
    } else {
        String::new()
    };
    let dry = if status.dry_run { "  DRY RUN" } else { "" };
    format!("state     {}{policy}{waiting}  {:.1} s  {} kicks{dry}", s.state, s.at_us as f64 * 1e-6, s.kicks)
}

/// Who is in command, and whether that is bad.
fn in_command(status: &LiveStatus) -> (String, bool) {
    let s = &status.runtime;
    let (who, bad) = match (s.others_command, s.vendor_commands) {
        (true, _) => ("another program, too", true),
        (false, Some(true)) => ("the vendor's controller", true),
        (false, Some(false)) => ("this program (vendor released)", false),
        (false, None) => ("this program (vendor unknown)", false),
    };
    let remote = if s.remote { "on" } else { "OFF" };
    (format!("{who}  remote {remote}  mode_machine {}", s.mode_machine), bad)
}

fn rates(status: &LiveStatus) -> String {
    let [states, commands] = status.rates_hz;
    format!(
        "rates     states {states:.0}/s  commands {commands:.0}/s  longest step {:.2} ms  late by {:.2} ms",
        status.longest_step_us as f64 * 1e-3,
        status.latest_command_us as f64 * 1e-3
    )
}

fn age(seconds: f64) -> String {
    match seconds {
        s if !s.is_finite() => "never".to_owned(),
        s if s < 1.0 => format!("{:.0} ms ago", 1e3 * s),
        s => format!("{s:.1} s ago"),
    }
}

/// A number with this many decimals, and no minus before a zero.
fn number(x: f64, digits: usize) -> String {
    let text = format!("{x:.digits$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.bytes().all(|byte| matches!(byte, b'0' | b'.')) => zero.to_owned(),
        _ => text,
    }
}

/// A value to the left, or to the right if it is negative.
fn sideways(left: f64, unit: &str) -> String {
    format!("{:.2} {unit} {}", left.abs(), if left < 0.0 { "right" } else { "left" })
}

fn body(status: &LiveStatus) -> String {
    let s = &status.runtime;
    let place = s.odometry_m.map_or("no odometry".to_owned(), |place| {
        let [x, y, z] = place.map(|x| number(x, 2));
        format!("place {x} {y} {z} m {}", age(s.ages_s[1]))
    });
    format!("body      {}  tilt {:.2} rad  {place}", age(s.ages_s[0]), s.tilt_rad)
}

fn ball(status: &LiveStatus) -> String {
    let s = &status.runtime;
    let ball = s.ball_m.map_or("no ball".to_owned(), |[ahead, left]| {
        format!("{} m ahead, {}, seen {}", number(ahead, 2), sideways(left, "m"), age(s.ages_s[2]))
    });
    let goal = s.goal_rad.map_or("no goal".to_owned(), |angle| format!("goal {}", sideways(angle, "rad")));
    format!("ball      {ball}  {goal}")
}

fn hottest(status: &LiveStatus) -> String {
    let [(winding, at), (casing, on)] = status.runtime.hottest;
    let name = |j: usize| short(G1_MOTORS.get(j).copied().unwrap_or("?"));
    let battery = status.runtime.battery.map_or(String::new(), |percent| format!("  battery {percent:.0}%"));
    format!("hottest   winding {winding} ({})  casing {casing} ({}){battery}", name(at), name(on))
}

/// `left_hip_pitch_joint` is `L hip pitch`.
fn short(joint: &str) -> String {
    joint.trim_end_matches("_joint").replace("left_", "L ").replace("right_", "R ").replace('_', " ")
}

fn joint(j: usize, joint: &JointStatus) -> String {
    let JointStatus { pos_rad, target_rad, torque_nm, temperature_c: [winding, _], .. } = joint;
    let figures = [
        number(f64::from(*pos_rad), 2),
        number(f64::from(*target_rad), 2),
        number(f64::from(*torque_nm), 0),
        winding.to_string(),
    ];
    cells(&short(G1_MOTORS[j]), figures)
}

/// A row of one half of the table, 39 columns.
fn cells(name: &str, [angle, target, torque, winding]: [String; 4]) -> String {
    format!("{name:<16}{angle:>7}{target:>7}{torque:>5}{winding:>4}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::Told;
    use crate::runtime::{Event, Status};
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    fn status() -> LiveStatus {
        let mut joints = [JointStatus::default(); G1_MOTORS.len()];
        joints[3] = JointStatus {
            pos_rad: 0.31,
            target_rad: 0.3,
            vel_rad_s: 0.0,
            torque_nm: -12.4,
            temperature_c: [51, 44],
        };
        joints[28].pos_rad = -1.25;
        joints[28].torque_nm = -0.3;
        let runtime = Status {
            at_us: 12_340_000,
            state: State::Ready,
            policy: true,
            kicks: 3,
            waiting: "a ball within reach",
            states: 6000,
            ages_s: [0.002, 0.01, 0.3],
            tilt_rad: 0.034,
            hottest: [(51, 3), (44, 3)],
            battery: Some(81.0),
            ball_m: Some([1.2, -0.1]),
            ball_deviation_m: 0.02,
            goal_rad: Some(0.05),
            mode_machine: 5,
            others_command: false,
            vendor_commands: Some(false),
            odometry_m: Some([0.5, 0.25, 0.74]),
            goal_m: Some([5.0, 0.0]),
            base_quat: [1.0, 0.0, 0.0, 0.0],
            joints,
            remote: true,
        };
        LiveStatus {
            runtime,
            rates_hz: [500.0, 499.8],
            longest_step_us: 140,
            latest_command_us: 220,
            dry_run: false,
        }
    }

    fn drawn(view: &View) -> (Vec<String>, Buffer) {
        let mut terminal = Terminal::new(TestBackend::new(80, 24)).expect("terminal");
        terminal.draw(|frame| frame.render_widget(view, frame.area())).expect("draw");
        let buffer = terminal.backend().buffer().clone();
        let row = |y| (0..80).map(|x| buffer[(x, y)].symbol()).collect::<String>().trim_end().to_owned();
        ((0..24).map(row).collect(), buffer)
    }

    #[test]
    fn every_figure_stands_in_its_cells() {
        let mut view = View::default();
        view.take(Told::Status(&status()));
        let reason = "still for 0.5 s".to_owned();
        view.take(Told::Event(&Event { at_us: 9_500_000, from: State::Settle, to: State::Ready, reason }));
        let (rows, buffer) = drawn(&view);
        assert_eq!(
            rows[..9],
            [
                "state     ready (policy), waits for a ball within reach  12.3 s  3 kicks",
                "last      9.50 s  settle -> ready: still for 0.5 s",
                "command   this program (vendor released)  remote on  mode_machine 5",
                "rates     states 500/s  commands 500/s  longest step 0.14 ms  late by 0.22 ms",
                "body      2 ms ago  tilt 0.03 rad  place 0.50 0.25 0.74 m 10 ms ago",
                "ball      1.20 m ahead, 0.10 m right, seen 300 ms ago  goal 0.05 rad left",
                "hottest   winding 51 (L knee)  casing 44 (L knee)  battery 81%",
                "keys      u: stand up (L2+Up)  k: kicks (R1+X)  b: damping (L2+B)  q: quit",
                "joint             angle target   Nm deg joint             angle target   Nm deg",
            ]
        );
        assert_eq!(
            rows[12],
            "L knee             0.31   0.30  -12  51 L elbow            0.00   0.00    0   0"
        );
        assert_eq!(
            rows[22],
            "waist roll         0.00   0.00    0   0 R wrist yaw       -1.25   0.00    0   0"
        );
        assert_eq!(rows[23], "waist pitch        0.00   0.00    0   0");
        assert_eq!(buffer[(0, 0)].fg, Color::Reset);
    }

    #[test]
    fn what_must_not_be_is_red() {
        let mut view = View::default();
        let mut status = status();
        status.runtime.vendor_commands = Some(true);
        status.runtime.state = State::Damping;
        status.runtime.remote = false;
        status.runtime.ages_s[1] = f64::INFINITY;
        status.runtime.odometry_m = None;
        view.take(Told::Status(&status));
        let (rows, buffer) = drawn(&view);
        assert_eq!(
            (buffer[(0, 0)].fg, buffer[(0, 2)].fg, buffer[(0, 3)].fg),
            (Color::Red, Color::Red, Color::Reset)
        );
        assert_eq!(rows[2], "command   the vendor's controller  remote OFF  mode_machine 5");
        assert_eq!(rows[4], "body      2 ms ago  tilt 0.03 rad  no odometry");
    }

    #[test]
    fn a_ball_that_was_seen_long_ago_and_a_goal_fit_into_the_line() {
        let mut view = View::default();
        let mut status = status();
        status.runtime.ages_s[2] = 3725.04;
        status.runtime.ball_m = Some([-10.004, -10.25]);
        status.runtime.goal_rad = Some(-2.9);
        status.runtime.odometry_m = Some([-0.001, 0.25, 0.74]);
        view.take(Told::Status(&status));
        let (rows, _) = drawn(&view);
        assert_eq!(
            rows[5],
            "ball      -10.00 m ahead, 10.25 m right, seen 3725.0 s ago  goal 2.90 rad right"
        );
        assert!(rows[4].contains("place 0.00 0.25 0.74 m"), "{}", rows[4]);
    }

    #[test]
    fn a_small_terminal_shows_what_fits() {
        let mut view = View::default();
        view.take(Told::Status(&status()));
        let mut terminal = Terminal::new(TestBackend::new(20, 2)).expect("terminal");
        terminal.draw(|frame| frame.render_widget(&view, frame.area())).expect("draw");
        terminal.backend().assert_buffer_lines([
            ratatui::text::Line::styled("state     ready (pol", Modifier::BOLD),
            ratatui::text::Line::from("last                "),
        ]);
    }
}
