//! A request to one of the robot's services and its response, in CDR.

use byteorder::LittleEndian;
use serde::{Deserialize, Serialize};

/// `unitree_api::msg::dds_::Request_`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ApiRequest {
    /// Number of the request; the response repeats it.
    pub id: i64,
    /// What is asked for.
    pub api_id: i64,
    /// Number of the lease; 0 for none.
    pub lease: i64,
    /// Priority.
    pub priority: i32,
    /// True: no response is wanted.
    pub noreply: bool,
    /// Arguments as JSON.
    pub parameter: String,
    /// Further bytes.
    pub binary: Vec<u8>,
}

/// `unitree_api::msg::dds_::Response_`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ApiResponse {
    /// Number of the request.
    pub id: i64,
    /// What was asked for.
    pub api_id: i64,
    /// 0: it was done.
    pub code: i32,
    /// The answer as JSON.
    pub data: String,
    /// Further bytes.
    pub binary: Vec<u8>,
}

macro_rules! as_cdr {
    ($Message:ident) => {
        impl $Message {
            /// CDR, little-endian, without the header.
            ///
            /// # Panics
            /// Never: numbers, texts and bytes can always be written.
            pub fn to_cdr(&self) -> Vec<u8> {
                cdr_encoding::to_vec::<_, LittleEndian>(self).expect("numbers, texts and bytes")
            }

            /// From [`Self::to_cdr`]'s bytes; `None` if they are no such message.
            pub fn from_cdr(bytes: &[u8]) -> Option<Self> {
                cdr_encoding::from_bytes::<_, LittleEndian>(bytes).ok().map(|(message, _)| message)
            }
        }
    };
}
as_cdr!(ApiRequest);
as_cdr!(ApiResponse);

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn fields_lie_where_cdr_puts_them() {
        let request = ApiRequest { id: 1, api_id: 1001, parameter: "{}".to_owned(), ..ApiRequest::default() };
        let bytes = request.to_cdr();
        // Three numbers of 8 bytes, the priority, the flag and 3 bytes of padding; then 4 bytes of length, "{}" and its zero, 1 of padding.
        assert_eq!(bytes.len(), 3 * 8 + 4 + 4 + (4 + 3 + 1) + 4);
        assert_eq!(bytes[8..16], 1001_i64.to_le_bytes());
        assert_eq!(bytes[32..39], *b"\x03\0\0\0{}\0");
        assert_eq!(ApiRequest::from_cdr(&bytes), Some(request));
        let response = ApiResponse { id: 1, api_id: 1001, code: 7002, ..ApiResponse::default() };
        let bytes = response.to_cdr();
        assert_eq!((bytes.len(), &bytes[16..18]), (20 + 4 + 1 + 3 + 4, &[0x5A, 0x1B][..]));
        assert_eq!(ApiResponse::from_cdr(&bytes), Some(response));
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..80)) {
            if let Some(request) = ApiRequest::from_cdr(&bytes) {
                prop_assert_eq!(ApiRequest::from_cdr(&request.to_cdr()), Some(request));
            }
            if let Some(response) = ApiResponse::from_cdr(&bytes) {
                prop_assert_eq!(ApiResponse::from_cdr(&response.to_cdr()), Some(response));
            }
        }
    }
}
