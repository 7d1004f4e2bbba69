//! `--live`: the page in the browser.

use std::net::SocketAddr;
use std::process::ExitCode;

use paid_eval::subject::Subject;
use paid_live::{LiveError, MatchPage, PlayOptions, ServeOptions, TrainingPage, play};
use paid_terminal::flag;

use crate::failure::Failure;

/// Arguments of the page.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Browser page")]
pub struct LiveArgs {
    /// Serve a page to play or watch in a browser, and print its address.
    #[arg(long)]
    pub live: bool,
    /// Port of the page; 0 for a free one [default: 4747, or a free one if taken].
    #[arg(long, hide_short_help = true, value_name = "PORT", requires = "live")]
    port: Option<u16>,
    /// Also serve other machines, such as a phone, at this address of this machine.
    ///
    /// For example 192.168.1.5:4747. The printed address contains a token.
    #[arg(long, value_name = "IP:PORT", requires = "live", conflicts_with = "port")]
    listen: Option<SocketAddr>,
}

impl LiveArgs {
    /// The page of a training run, if it was asked for. If it cannot be served, one warning is printed and training continues.
    pub fn training(&self) -> Option<TrainingPage> {
        if !self.live {
            return None;
        }
        let failed =
            |error: &LiveError| eprintln!("--live: the page cannot be served, training continues: {error}");
        match TrainingPage::start(&self.options(), failed) {
            Ok(page) => {
                // Standard output may be lines of JSON.
                eprintln!("{}  <- open this in a browser to watch the training", page.url());
                Some(page)
            }
            Err(error) => {
                failed(&error);
                None
            }
        }
    }

    /// The page of matches, if it was asked for.
    pub fn matches(&self, subject: &Subject) -> Result<Option<MatchPage>, Failure> {
        if !self.live {
            return Ok(None);
        }
        let page = MatchPage::start(subject, &self.options()).map_err(Failure::input)?;
        // Standard output is the report's.
        eprintln!("{}  <- open this in a browser to watch; the matches wait for it", page.url());
        Ok(Some(page))
    }

    /// Where it is served.
    pub fn options(&self) -> ServeOptions {
        ServeOptions { port: self.port, listen: self.listen }
    }

    /// Serves the page until the program is stopped, and prints a summary.
    pub fn serve(&self, subject: &Subject, clip: Option<u16>) -> Result<ExitCode, Failure> {
        let stop = flag()?;
        let options = PlayOptions { serve: self.options(), clip, ..PlayOptions::default() };
        let ready = |url: &str| {
            println!("{url}  <- open this in a browser, then drag the ball");
            println!("{} in {}; Ctrl-C ends it", subject.name, subject.setup.engine.name());
        };
        let summary = play(subject, &options, &stop, ready).map_err(Failure::input)?;
        println!(
            "{} goals of {} shots in {} control steps; {} messages dropped, {} requests refused",
            summary.goals, summary.shots, summary.steps, summary.dropped, summary.refused
        );
        Ok(ExitCode::SUCCESS)
    }
}
