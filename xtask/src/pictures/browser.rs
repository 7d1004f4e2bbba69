//! Screenshots by a headless Chromium, over the pipe of its DevTools protocol.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use paid_files::FileError;

use super::Error;

/// Names under which Chromium is installed.
pub const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// The first of [`NAMES`] on the `PATH`.
pub fn find() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    NAMES.iter().flat_map(|name| folders.iter().map(move |f| f.join(name))).find(|p| p.is_file())
}

/// A browser with one page.
pub struct Browser {
    process: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    session: String,
    calls: u32,
}

impl Browser {
    /// Starts `program` with its profile in `folder` and a page of `width` by `height` pixels, drawn `scale` times as large.
    pub fn start(
        program: &Path,
        folder: &Path,
        [width, height]: [u32; 2],
        scale: f64,
    ) -> Result<Self, Error> {
        // The browser reads commands from descriptor 3 and answers on descriptor 4. A shell puts its pipes there.
        let mut process = Command::new("sh")
            .args(["-c", r#"exec "$0" "$@" 3<&0 4>&1 >/dev/null 2>&1"#])
            .arg(program)
            .args([
                "--headless=new",
                "--no-sandbox",
                "--remote-debugging-pipe",
                "--no-first-run",
                "--hide-scrollbars",
            ])
            .args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"])
            .arg([OsStr::new("--user-data-dir="), folder.join("profile").as_os_str()].join(OsStr::new("")))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(FileError::at(program))?;
        let (Some(input), Some(output)) = (process.stdin.take(), process.stdout.take()) else {
            unreachable!("both are piped");
        };
        let output = BufReader::new(output);
        let mut browser = Self { process, input, output, session: String::new(), calls: 0 };
        let target = browser.call("Target.createTarget", r#"{"url":"about:blank"}"#)?;
        let target = text(&target, "targetId")?.to_owned();
        let attach = format!(r#"{{"targetId":"{target}","flatten":true}}"#);
        let session = browser.call("Target.attachToTarget", &attach)?;
        browser.session = format!(r#","sessionId":"{}""#, text(&session, "sessionId")?);
        let size =
            format!(r#"{{"width":{width},"height":{height},"deviceScaleFactor":{scale},"mobile":false}}"#);
        browser.call("Emulation.setDeviceMetricsOverride", &size)?;
        Ok(browser)
    }

    /// Calls a method with parameters in JSON; the answer in JSON.
    fn call(&mut self, method: &str, params: &str) -> Result<String, Error> {
        self.calls += 1;
        let start = format!(r#"{{"id":{}"#, self.calls);
        let message = format!("{start},\"method\":\"{method}\",\"params\":{params}{}}}\0", self.session);
        let lost = |_| Error::Browser("it ended early".to_owned());
        self.input.write_all(message.as_bytes()).and_then(|()| self.input.flush()).map_err(lost)?;
        loop {
            let mut answer = Vec::new();
            if self.output.read_until(0, &mut answer).map_err(lost)? == 0 {
                return Err(Error::Browser("it ended early".to_owned()));
            }
            let answer = String::from_utf8_lossy(&answer).trim_end_matches('\0').to_owned();
            if answer.starts_with(&format!("{start},")) {
                if answer.contains(r#""error":{"code""#) {
                    return Err(Error::Browser(format!("{method} was answered by {answer}")));
                }
                return Ok(answer);
            }
        }
    }

    /// Goes to an address.
    pub fn open(&mut self, url: &str) -> Result<(), Error> {
        self.call("Page.navigate", &format!(r#"{{"url":"{url}"}}"#)).map(|_| ())
    }

    /// Waits until a JavaScript condition without double quotes is true.
    pub fn wait(&mut self, condition: &str, longest: Duration) -> Result<(), Error> {
        let start = Instant::now();
        let expression = format!(r#"{{"expression":"Boolean({condition})","returnByValue":true}}"#);
        while !self.call("Runtime.evaluate", &expression)?.contains(r#""value":true"#) {
            if start.elapsed() > longest {
                return Err(Error::Browser(format!(
                    "the page did not reach '{condition}' within {} s",
                    longest.as_secs()
                )));
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        Ok(())
    }

    /// What the page shows, as PNG.
    pub fn screenshot(&mut self) -> Result<Vec<u8>, Error> {
        let answer = self.call("Page.captureScreenshot", r#"{"format":"png"}"#)?;
        base64(text(&answer, "data")?)
            .ok_or_else(|| Error::Browser("its screenshot is not base64".to_owned()))
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The text of a key in JSON, for texts without escapes.
fn text<'a>(json: &'a str, key: &str) -> Result<&'a str, Error> {
    let found = json.split_once(&format!(r#""{key}":""#)).and_then(|(_, rest)| rest.split_once('"'));
    found.map(|(text, _)| text).ok_or_else(|| Error::Browser(format!("its answer has no '{key}'")))
}

/// The bytes of a base64 text.
fn base64(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0_u32, 0);
    for c in text.bytes().filter(|c| *c != b'=') {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = (bits << 6) | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_read() {
        assert_eq!(base64("aGVsbG8=").as_deref(), Some(&b"hello"[..]));
        assert_eq!(base64("/+8A").as_deref(), Some(&[255, 239, 0][..]));
        assert_eq!(base64("a b"), None);
    }

    #[test]
    fn a_key_s_text_is_found() {
        assert_eq!(text(r#"{"a":"x","data":"yz"}"#, "data").ok(), Some("yz"));
        assert!(text("{}", "data").is_err());
    }
}
