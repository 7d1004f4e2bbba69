//! Footage in Rerun: as a file, or in a viewer that runs or can be started.

mod log;
mod shapes;

use std::fs;
use std::net::{TcpStream, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::time::Duration;

use re_sdk::{RecordingStream, RecordingStreamBuilder, SpawnError, SpawnOptions};

use super::{Footage, Shows};
use crate::{EvalError, Setting};

/// The viewer's usual address.
const USUAL: &str = "rerun+http://127.0.0.1:9876/proxy";
/// How long a viewer may take to answer.
const ANSWER: Duration = Duration::from_secs(2);
/// How long a viewer, perhaps one just started, may take for everything.
const DELIVERY: Duration = Duration::from_secs(60);

/// Where a recording goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// To a file `.rrd`.
    File(PathBuf),
    /// To a viewer on this machine, which is started if none runs.
    Live,
    /// To a viewer that runs elsewhere.
    Viewer(String),
}

impl Target {
    /// Understands a file name, `live` or a viewer's address.
    ///
    /// # Errors
    /// Anything but a file `.rrd`, `live` or a viewer's address.
    pub fn new(wanted: &str) -> Result<Self, EvalError> {
        let is_file = Path::new(wanted).extension().is_some_and(|e| e.eq_ignore_ascii_case("rrd"));
        match wanted {
            "live" => Ok(Self::Live),
            _ if address(wanted).is_some() => Ok(Self::Viewer(wanted.to_owned())),
            _ if is_file && !wanted.contains("://") => Ok(Self::File(PathBuf::from(wanted))),
            _ => Err(EvalError::Option {
                option: Setting::Recording,
                expected: format!("FILE.rrd, live or an address such as {USUAL}"),
                found: format!("'{wanted}'"),
            }),
        }
    }

    /// Sends the footage and says where to.
    ///
    /// # Errors
    /// A file that cannot be written, a viewer that does not answer.
    pub fn send(&self, footage: &Footage, shows: Shows) -> Result<String, EvalError> {
        match self {
            Self::File(path) => {
                write(path, footage, shows)
                    .map_err(|message| EvalError::Recording { path: path.clone(), message })?;
                Ok(path.display().to_string())
            }
            Self::Live => {
                if !answers(USUAL) {
                    start_viewer()?;
                }
                deliver(USUAL, footage, shows)
            }
            Self::Viewer(url) => {
                if !answers(url) {
                    return Err(EvalError::Viewer {
                        address: url.clone(),
                        message: "expected a viewer that listens, found none; start one with `rerun`, or record to a file .rrd"
                            .to_owned(),
                    });
                }
                deliver(url, footage, shows)
            }
        }
    }
}

/// Host and port of a viewer's address.
fn address(url: &str) -> Option<&str> {
    let rest = url.strip_prefix("rerun+http://").or_else(|| url.strip_prefix("rerun+https://"))?;
    let (host, path) = rest.split_once('/')?;
    let port = host.rsplit_once(':')?.1;
    (path == "proxy" && port.parse::<u16>().is_ok()).then_some(host)
}

fn answers(url: &str) -> bool {
    let places = address(url).and_then(|host| host.to_socket_addrs().ok());
    places.is_some_and(|mut all| all.any(|place| TcpStream::connect_timeout(&place, ANSWER).is_ok()))
}

fn start_viewer() -> Result<(), EvalError> {
    re_sdk::spawn(&SpawnOptions::default()).map(|_| ()).map_err(|error| {
        let why = match error {
            SpawnError::ExecutableNotFoundInPath { .. } => "no program `rerun` on the PATH".to_owned(),
            other => other.to_string(),
        };
        EvalError::Viewer {
            address: USUAL.to_owned(),
            message: format!(
                "expected a viewer that listens, or one to start, found {why}; install Rerun's viewer, or record to a file .rrd"
            ),
        }
    })
}

fn builder(footage: &Footage) -> RecordingStreamBuilder {
    RecordingStreamBuilder::new("paid")
        .recording_name(footage.name.clone())
        .enabled(true)
        .with_blueprint(log::arrangement(footage))
}

/// Logs everything and waits until it has arrived.
fn fill(rec: &RecordingStream, footage: &Footage, shows: Shows) -> Result<(), String> {
    rec.set_log_time_enabled(false);
    log::footage(rec, footage, shows).map_err(|error| error.to_string())?;
    rec.flush_with_timeout(DELIVERY).map_err(|error| error.to_string())
}

fn deliver(url: &str, footage: &Footage, shows: Shows) -> Result<String, EvalError> {
    let stream = builder(footage).connect_grpc_opts(url).map_err(|error| error.to_string());
    stream
        .and_then(|rec| fill(&rec, footage, shows))
        .map_err(|message| EvalError::Viewer { address: url.to_owned(), message })?;
    Ok(format!("the viewer at {url}"))
}

/// Writes a file under a temporary name, then renames it.
fn write(path: &Path, footage: &Footage, shows: Shows) -> Result<(), String> {
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        fs::create_dir_all(folder).map_err(|error| error.to_string())?;
    }
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(".part");
    let temporary = PathBuf::from(temporary);
    let written = builder(footage).save(&temporary).map_err(|error| error.to_string()).and_then(|rec| {
        // The end of the file is written when the stream is dropped.
        fill(&rec, footage, shows)
    });
    let renamed = written.and_then(|()| fs::rename(&temporary, path).map_err(|error| error.to_string()));
    if renamed.is_err() {
        // Nothing more can be done if the leftover cannot be removed either.
        let _ = fs::remove_file(&temporary);
    }
    renamed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_told_apart_and_others_are_refused() {
        let of = |text: &str| Target::new(text).map_err(|error| error.to_string());
        assert_eq!(of("a/kick.rrd"), Ok(Target::File("a/kick.rrd".into())));
        assert_eq!(of("live"), Ok(Target::Live));
        assert_eq!(of(USUAL), Ok(Target::Viewer(USUAL.to_owned())));
        for wrong in
            ["kick.gif", "lively", "rerun+http://host/proxy", "rerun+http://host:9876/other", "http://a.rrd"]
        {
            let error = of(wrong).expect_err(wrong);
            assert!(error.contains("expected FILE.rrd, live or") && error.contains(wrong), "{error}");
        }
    }
}
