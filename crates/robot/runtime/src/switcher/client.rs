//! The runtime's side: asks who is in command, and releases the vendor's controller on request.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use super::{ApiRequest, ApiResponse, CHECK_MODE, Line, Master, RELEASE_MODE};
use crate::DeployError;
use crate::link::LinkError;

/// What the service has answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// Who is in command.
    Master(Master),
    /// The vendor's controller was released.
    Released,
    /// It was not done, with the service's number for the reason.
    Refused(i64, i32),
}

/// Asks the motion switcher.
pub struct SwitcherClient<L> {
    line: L,
    next: i64,
    /// Requests without an answer, oldest first.
    open: Vec<i64>,
}

/// Requests that may be without an answer before the oldest is given up.
const OPEN: usize = 8;

impl<L: Line> SwitcherClient<L> {
    /// A client whose requests are numbered by the clock, so that two programs do not take each other's answers.
    pub fn new(line: L) -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self { line, next: now.as_nanos() as i64 & (i64::MAX >> 1), open: Vec::new() }
    }

    /// The line, to keep asking on it.
    pub fn into_line(self) -> L {
        self.line
    }

    fn ask(&mut self, api_id: i64) -> Result<(), LinkError> {
        let request =
            ApiRequest { id: self.next, api_id, parameter: "{}".to_owned(), ..ApiRequest::default() };
        if self.open.len() == OPEN {
            self.open.remove(0);
        }
        self.open.push(self.next);
        self.next += 1;
        self.line.send(request.to_cdr())
    }

    /// Asks who is in command.
    ///
    /// # Errors
    /// If the network is broken.
    pub fn check(&mut self) -> Result<(), LinkError> {
        self.ask(CHECK_MODE)
    }

    /// Asks to release the vendor's controller. The robot goes limp then.
    ///
    /// # Errors
    /// If the network is broken.
    pub fn release(&mut self) -> Result<(), LinkError> {
        self.ask(RELEASE_MODE)
    }

    /// The next answer to a request of this client, if one has come. Answers to others are passed over.
    ///
    /// # Errors
    /// If the network is broken.
    pub fn reply(&mut self) -> Result<Option<Reply>, LinkError> {
        while let Some(bytes) = self.line.receive()? {
            let Some(response) = ApiResponse::from_cdr(&bytes) else { continue };
            let Some(at) = self.open.iter().position(|id| *id == response.id) else { continue };
            self.open.remove(at);
            let refused = Reply::Refused(response.api_id, response.code);
            return Ok(Some(match response.api_id {
                _ if response.code != 0 => refused,
                RELEASE_MODE => Reply::Released,
                CHECK_MODE => serde_json::from_str(&response.data).map_or(refused, Reply::Master),
                _ => continue,
            }));
        }
        Ok(None)
    }
}

/// How long to ask, and how often.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// Until the first answer. Programs find each other after some seconds.
    pub answer: Duration,
    /// From the first release to a robot that reports it is released.
    pub release: Duration,
    /// Between two requests.
    pub every: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        let seconds = Duration::from_secs;
        Self { answer: seconds(20), release: seconds(10), every: Duration::from_millis(500) }
    }
}

/// Asks until the vendor's controller is released. If it is in command, `release` has it released; otherwise that is the end.
///
/// # Errors
/// If `stop` is set, the motion switcher does not answer, the vendor's controller is in command and is not to be released or stays in
/// command, or the network is broken.
pub fn await_release<L: Line>(
    client: &mut SwitcherClient<L>,
    release: bool,
    patience: Patience,
    stop: &AtomicBool,
    mut told: impl FnMut(&str),
) -> Result<(), DeployError> {
    let refused = |message: String| Err(DeployError::Refused(message));
    let (mut until, mut releasing, mut last) = (Instant::now() + patience.answer, false, None);
    loop {
        client.check()?;
        let next = Instant::now() + patience.every;
        while Instant::now() < next {
            if stop.load(Ordering::Relaxed) {
                return Err(DeployError::Stopped);
            }
            match client.reply()? {
                Some(Reply::Master(master)) if master.name.is_empty() => {
                    told("the vendor's controller is released");
                    return Ok(());
                }
                Some(Reply::Master(master)) if !release => {
                    return refused(format!(
                        "the vendor's controller '{}' is in command: release it with the remote, or hang the robot on the gantry and \
                         start with --release (it goes limp then)",
                        master.name
                    ));
                }
                Some(Reply::Master(master)) => {
                    if !releasing {
                        told(&format!("releasing the vendor's controller '{}'", master.name));
                        (releasing, until) = (true, Instant::now() + patience.release);
                    }
                    last = Some(format!("'{}' is still in command", master.name));
                    client.release()?;
                    break;
                }
                Some(Reply::Refused(api, code)) => last = Some(format!("request {api} got error {code}")),
                Some(Reply::Released) => {}
                None => std::thread::sleep(Duration::from_millis(5).min(patience.every)),
            }
        }
        if Instant::now() >= until {
            return refused(match last {
                Some(last) => format!("the vendor's controller was not released: {last}"),
                None => format!(
                    "no answer on {} within {:.0} s: is the robot on, is this its interface and domain? A simulator without motion \
                     switcher needs --no-switcher",
                    super::SWITCHER_TOPICS[0],
                    patience.answer.as_secs_f64()
                ),
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use super::super::SwitcherService;
    use super::*;

    /// A robot at the other end, which is busy for its first requests to release.
    struct Robot {
        service: SwitcherService,
        answers: VecDeque<Vec<u8>>,
        busy: usize,
        deaf: bool,
        releases: usize,
    }

    impl Robot {
        fn new(master: &str) -> Self {
            let service = SwitcherService::new(master);
            Self { service, answers: VecDeque::new(), busy: 0, deaf: false, releases: 0 }
        }
    }

    impl Line for &mut Robot {
        fn send(&mut self, bytes: Vec<u8>) -> Result<(), LinkError> {
            let request = ApiRequest::from_cdr(&bytes).expect("a request");
            self.releases += usize::from(request.api_id == RELEASE_MODE);
            if self.deaf {
                return Ok(());
            }
            if request.api_id == RELEASE_MODE && self.busy > 0 {
                self.busy -= 1;
                let ApiRequest { id, api_id, .. } = request;
                self.answers
                    .push_back(ApiResponse { id, api_id, code: 7002, ..ApiResponse::default() }.to_cdr());
                return Ok(());
            }
            // Somebody else's answer comes first.
            let other = ApiResponse { id: request.id - 1000, api_id: CHECK_MODE, ..ApiResponse::default() };
            self.answers.push_back(other.to_cdr());
            self.answers.extend(self.service.answer(&request).map(|answer| answer.to_cdr()));
            Ok(())
        }
        fn receive(&mut self) -> Result<Option<Vec<u8>>, LinkError> {
            Ok(self.answers.pop_front())
        }
    }

    /// It is not stopped.
    static ON: AtomicBool = AtomicBool::new(false);

    const SHORT: Patience = Patience {
        answer: Duration::from_millis(30),
        release: Duration::from_secs(5),
        every: Duration::from_millis(1),
    };

    #[test]
    fn a_vendor_in_command_is_released_on_the_explicit_flag_only() {
        let mut robot = Robot::new("ai");
        let error = await_release(&mut SwitcherClient::new(&mut robot), false, SHORT, &ON, |_| {});
        let error = error.expect_err("in command").to_string();
        assert!(error.starts_with("refused to start: the vendor's controller 'ai' is in command"), "{error}");
        assert_eq!(robot.releases, 0);

        let mut said = String::new();
        robot.busy = 2;
        let released =
            await_release(&mut SwitcherClient::new(&mut robot), true, SHORT, &ON, |line| said += line);
        released.expect("released");
        assert_eq!(said, "releasing the vendor's controller 'ai'the vendor's controller is released");
        assert_eq!((robot.service.master(), robot.releases), ("", 3));
    }

    #[test]
    fn a_released_robot_is_asked_and_not_released_again() {
        let mut robot = Robot::new("");
        await_release(&mut SwitcherClient::new(&mut robot), true, SHORT, &ON, |_| {}).expect("released");
        assert_eq!(robot.releases, 0);
    }

    #[test]
    fn an_answer_without_the_form_is_one() {
        struct Short(SwitcherService, VecDeque<Vec<u8>>);
        impl Line for Short {
            fn send(&mut self, bytes: Vec<u8>) -> Result<(), LinkError> {
                let request = ApiRequest::from_cdr(&bytes).expect("a request");
                let mut answer = self.0.answer(&request).expect("an answer");
                // As a service on the vendor's C++ SDK sends it.
                answer.data = r#"{"name":""}"#.to_owned();
                self.1.push_back(answer.to_cdr());
                Ok(())
            }
            fn receive(&mut self) -> Result<Option<Vec<u8>>, LinkError> {
                Ok(self.1.pop_front())
            }
        }
        let robot = Short(SwitcherService::new(""), VecDeque::new());
        let mut client = SwitcherClient::new(robot);
        await_release(&mut client, false, SHORT, &ON, |_| {}).expect("released");
    }

    #[test]
    fn no_answer_is_no_released_robot() {
        let mut robot = Robot { deaf: true, ..Robot::new("") };
        let error = await_release(&mut SwitcherClient::new(&mut robot), true, SHORT, &ON, |_| {});
        let error = error.expect_err("silence").to_string();
        assert!(error.contains("no answer on rt/api/motion_switcher/request"), "{error}");
    }

    #[test]
    fn stopped_without_an_answer_it_says_so_and_releases_nothing() {
        let mut robot = Robot { deaf: true, ..Robot::new("ai") };
        let patience = Patience { answer: Duration::from_secs(600), ..SHORT };
        let stop = AtomicBool::new(true);
        let error = await_release(&mut SwitcherClient::new(&mut robot), true, patience, &stop, |_| {});
        let error = error.expect_err("stopped");
        assert!(matches!(error, DeployError::Stopped) && error.to_string().starts_with("stopped"), "{error}");
        assert_eq!(robot.releases, 0);
    }
}
