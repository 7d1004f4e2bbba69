//! The robot's side: answers as the vendor's service does.

use serde::{Deserialize, Serialize};

use super::{ApiRequest, ApiResponse, CHECK_MODE, Line, RELEASE_MODE, SELECT_MODE};
use crate::link::LinkError;

/// Arguments that are none.
const BAD_PARAMETER: i32 = 7001;
/// A controller that the robot does not have.
const UNKNOWN_MODE: i32 = 7004;
/// A number that the service does not know.
const NOT_IMPLEMENTED: i32 = 3203;
/// The vendor's controllers that the virtual robot knows.
const MODES: [&str; 3] = ["ai", "normal", "advanced"];

/// Who is in command, as the vendor's service reports it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Master {
    /// Form of the robot; "0" is the usual one. Not every service sends it.
    #[serde(default)]
    pub form: String,
    /// The vendor's controller; empty: it is released.
    pub name: String,
}

/// The service of a virtual robot.
#[derive(Clone, Debug, Default)]
pub struct SwitcherService {
    master: String,
}

impl SwitcherService {
    /// A robot with this controller in command; empty: released.
    pub fn new(master: &str) -> Self {
        Self { master: master.to_owned() }
    }

    /// The vendor's controller that is in command; empty: none.
    pub fn master(&self) -> &str {
        &self.master
    }

    /// What the service answers; nothing if no answer is wanted.
    pub fn answer(&mut self, request: &ApiRequest) -> Option<ApiResponse> {
        let (code, data) = match request.api_id {
            CHECK_MODE => {
                let master = Master { form: "0".to_owned(), name: self.master.clone() };
                (0, serde_json::to_string(&master).unwrap_or_default())
            }
            SELECT_MODE => (self.select(&request.parameter), String::new()),
            RELEASE_MODE => {
                self.master.clear();
                (0, String::new())
            }
            _ => (NOT_IMPLEMENTED, String::new()),
        };
        let ApiRequest { id, api_id, noreply, .. } = *request;
        (!noreply).then_some(ApiResponse { id, api_id, code, data, binary: Vec::new() })
    }

    fn select(&mut self, parameter: &str) -> i32 {
        let arguments: Result<serde_json::Value, _> = serde_json::from_str(parameter);
        let Some(name) = arguments.ok().and_then(|a| Some(a.get("name")?.as_str()?.to_owned())) else {
            return BAD_PARAMETER;
        };
        if !MODES.contains(&name.as_str()) {
            return UNKNOWN_MODE;
        }
        self.master = name;
        0
    }

    /// Answers what has come.
    ///
    /// # Errors
    /// If the network is broken.
    pub fn serve(&mut self, line: &mut (impl Line + ?Sized)) -> Result<(), LinkError> {
        while let Some(bytes) = line.receive()? {
            if let Some(response) = ApiRequest::from_cdr(&bytes).and_then(|request| self.answer(&request)) {
                line.send(response.to_cdr())?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_says_who_is_in_command_and_releases() {
        let mut service = SwitcherService::new("ai");
        let mut ask = |api_id, parameter: &str| {
            let request =
                ApiRequest { id: 7, api_id, parameter: parameter.to_owned(), ..ApiRequest::default() };
            let answer = service.answer(&request).expect("an answer");
            assert_eq!((answer.id, answer.api_id), (7, api_id));
            (answer.code, answer.data)
        };
        assert_eq!(ask(CHECK_MODE, "{}"), (0, r#"{"form":"0","name":"ai"}"#.to_owned()));
        assert_eq!(ask(RELEASE_MODE, "{}").0, 0);
        assert_eq!(ask(CHECK_MODE, "{}"), (0, r#"{"form":"0","name":""}"#.to_owned()));
        assert_eq!(ask(SELECT_MODE, r#"{"name":"dance"}"#).0, 7004);
        assert_eq!(ask(SELECT_MODE, "dance").0, 7001);
        assert_eq!(ask(SELECT_MODE, r#"{"name":"normal"}"#).0, 0);
        assert_eq!(ask(CHECK_MODE, "{}").1, r#"{"form":"0","name":"normal"}"#);
        assert_eq!(ask(4711, "").0, 3203);
    }

    #[test]
    fn who_wants_no_answer_gets_none() {
        let request = ApiRequest { api_id: RELEASE_MODE, noreply: true, ..ApiRequest::default() };
        let mut service = SwitcherService::new("ai");
        assert_eq!(service.answer(&request), None);
        assert_eq!(service.master(), "");
    }
}
