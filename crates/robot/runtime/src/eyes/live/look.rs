//! The thread that looks for the ball.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use super::SILENT_NS;
use super::camera::Camera;
use super::teller::Teller;
use crate::eyes::link::Joints;
use crate::eyes::{BallEyes, Desk, TorsoFix};
use crate::runtime::Phase;

/// Time between two reports without an image `[ns]`.
const REPORT_NS: u64 = 20_000_000;

/// The thread that looks for the ball.
pub(super) struct Look {
    pub camera: Camera,
    pub eyes: BallEyes,
    pub joints: Receiver<Joints>,
    pub fixes: Receiver<TorsoFix>,
    pub motors: Vec<usize>,
    pub phase: Arc<Phase>,
    pub desk: Arc<Desk>,
    pub teller: Teller,
}

impl Look {
    pub fn run(mut self, stop: &AtomicBool) {
        let (mut reported_ns, mut looked_ns) = (0, 0);
        while !stop.load(Ordering::Acquire) {
            match self.fixes.recv_timeout(Duration::from_millis(2)) {
                Ok(fix) => {
                    self.torso(&fix);
                    while let Ok(fix) = self.fixes.try_recv() {
                        self.torso(&fix);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                // The thread that follows the torso has ended: without it there is nothing to believe.
                Err(RecvTimeoutError::Disconnected) => return,
            }
            while let Ok(joints) = self.joints.try_recv() {
                let angles = self.motors.iter().map(|&m| f64::from(joints.angles[m])).collect();
                if let Err(error) = self.eyes.joints(joints.at_ns, angles) {
                    self.teller.tell(error.to_string());
                }
            }
            if let Err(line) = self.camera.read(&self.desk) {
                self.teller.tell(format!("camera: {line}"));
            }
            let now_ns = self.desk.now_ns();
            let looked = self.look(now_ns);
            if looked {
                looked_ns = now_ns;
            } else if now_ns > looked_ns + SILENT_NS {
                self.teller.tell(self.camera.silent());
                looked_ns = now_ns;
            }
            if looked || now_ns > reported_ns + REPORT_NS {
                reported_ns = now_ns;
                let held_ns = self.desk.now_ns();
                match self.eyes.report(held_ns, &self.phase) {
                    Ok(report) => {
                        self.desk.report.put((held_ns, report));
                    }
                    Err(error) => self.teller.tell(error.to_string()),
                }
            }
        }
    }

    fn torso(&mut self, fix: &TorsoFix) {
        if let Err(error) = self.eyes.torso(fix) {
            self.teller.tell(error.to_string());
        }
    }

    /// Looks at the newest image, if there is one.
    fn look(&mut self, now_ns: u64) -> bool {
        let Some(mut picture) = self.camera.joiner.take(now_ns) else { return false };
        picture.captured_ns = self.camera.captured_ns(picture.captured_ns, now_ns);
        match self.eyes.picture(picture, now_ns, &self.phase) {
            Ok(None) => self.teller.well("camera: images arriving"),
            Ok(Some(fault)) => self.teller.tell(format!("camera: {fault}")),
            Err(error) => self.teller.tell(error.to_string()),
        }
        true
    }
}
