//! A request to one of the robot's services and its response, in CDR.

/// `unitree_api::msg::dds_::Request_`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
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
#[derive(Clone, Debug, Default, PartialEq, Eq)]
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

impl ApiRequest {
    /// CDR, little-endian, without the header.
    pub fn to_cdr(&self) -> Vec<u8> {
        let mut out = Vec::new();
        for value in [self.id, self.api_id, self.lease] {
            out.extend(value.to_le_bytes());
        }
        out.extend(self.priority.to_le_bytes());
        out.push(u8::from(self.noreply));
        put_sequence(&mut out, self.parameter.as_bytes(), true);
        put_sequence(&mut out, &self.binary, false);
        out
    }

    /// From [`Self::to_cdr`]'s bytes; `None` if they are no request.
    pub fn from_cdr(bytes: &[u8]) -> Option<Self> {
        let mut take = Take(bytes, 0);
        Some(Self {
            id: i64::from_le_bytes(take.array()?),
            api_id: i64::from_le_bytes(take.array()?),
            lease: i64::from_le_bytes(take.array()?),
            priority: i32::from_le_bytes(take.array()?),
            noreply: take.array::<1>()? != [0],
            parameter: take.text()?,
            binary: take.sequence()?.to_vec(),
        })
    }
}

impl ApiResponse {
    /// CDR, little-endian, without the header.
    pub fn to_cdr(&self) -> Vec<u8> {
        let mut out = Vec::new();
        for value in [self.id, self.api_id] {
            out.extend(value.to_le_bytes());
        }
        out.extend(self.code.to_le_bytes());
        put_sequence(&mut out, self.data.as_bytes(), true);
        put_sequence(&mut out, &self.binary, false);
        out
    }

    /// From [`Self::to_cdr`]'s bytes; `None` if they are no response.
    pub fn from_cdr(bytes: &[u8]) -> Option<Self> {
        let mut take = Take(bytes, 0);
        Some(Self {
            id: i64::from_le_bytes(take.array()?),
            api_id: i64::from_le_bytes(take.array()?),
            code: i32::from_le_bytes(take.array()?),
            data: take.text()?,
            binary: take.sequence()?.to_vec(),
        })
    }
}

/// A length of four bytes, then the bytes; a text has a zero at its end, which counts.
fn put_sequence(out: &mut Vec<u8>, bytes: &[u8], text: bool) {
    out.resize(out.len().next_multiple_of(4), 0);
    let length = u32::try_from(bytes.len() + usize::from(text)).unwrap_or(u32::MAX);
    out.extend(length.to_le_bytes());
    out.extend(bytes);
    if text {
        out.push(0);
    }
}

/// Reads on from a place.
struct Take<'a>(&'a [u8], usize);

impl<'a> Take<'a> {
    fn bytes(&mut self, length: usize) -> Option<&'a [u8]> {
        let end = self.1.checked_add(length)?;
        let found = self.0.get(self.1..end)?;
        self.1 = end;
        Some(found)
    }
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.1 = self.1.next_multiple_of(N);
        self.bytes(N)?.try_into().ok()
    }
    fn sequence(&mut self) -> Option<&'a [u8]> {
        let length = u32::from_le_bytes(self.array()?);
        self.bytes(length as usize)
    }
    fn text(&mut self) -> Option<String> {
        let bytes = self.sequence()?;
        String::from_utf8(bytes.strip_suffix(&[0]).unwrap_or(bytes).to_vec()).ok()
    }
}

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
