//! A service that the node offers.

use crate::header::Header;
use crate::node::Inner;
use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::sync::{Arc, Weak};

/// A request of more bytes is not answered.
const MAX_REQUEST_LEN: u32 = 64 << 20;

/// Gets the request's bytes, returns the response's or a text that says why there is none.
pub(crate) type ServiceHandler = Box<dyn Fn(&[u8]) -> Result<Vec<u8>, String> + Send + Sync>;

pub(crate) struct ServiceState {
    pub(crate) name: String,
    pub(crate) type_name: String,
    pub(crate) md5sum: String,
    pub(crate) handler: ServiceHandler,
}

impl ServiceState {
    /// Serves a client, whose header was read, until it is satisfied.
    pub(crate) fn serve(&self, node_name: &str, mut stream: TcpStream, request: &Header) -> io::Result<()> {
        let theirs = request.get("md5sum").unwrap_or("*");
        if theirs != self.md5sum && theirs != "*" {
            let reason = format!("md5sum is {theirs} there and {} here", self.md5sum);
            return Header::new([("error", reason.as_str())]).write(&mut stream);
        }
        let answer = Header::new([
            ("callerid", node_name),
            ("md5sum", &self.md5sum),
            ("service", &self.name),
            ("type", &self.type_name),
        ]);
        answer.write(&mut stream)?;
        if request.is_set("probe") {
            return Ok(());
        }
        // A persistent client may be silent for as long as it likes.
        stream.set_read_timeout(None)?;
        loop {
            let mut len = [0; 4];
            stream.read_exact(&mut len)?;
            let len = u32::from_le_bytes(len);
            if len > MAX_REQUEST_LEN {
                return Err(io::ErrorKind::InvalidData.into());
            }
            let mut bytes = Vec::new();
            (&mut stream).take(u64::from(len)).read_to_end(&mut bytes)?;
            if bytes.len() != len as usize {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            let (success, body) = match (self.handler)(&bytes) {
                Ok(body) => (1, body),
                Err(text) => (0, text.into_bytes()),
            };
            let mut out = vec![success];
            out.extend_from_slice(&u32::try_from(body.len()).unwrap_or(u32::MAX).to_le_bytes());
            out.extend_from_slice(&body);
            stream.write_all(&out)?;
            if !request.is_set("persistent") {
                return Ok(());
            }
        }
    }
}

/// Offers a service until it is dropped.
pub struct ServiceServer {
    pub(crate) service: Arc<ServiceState>,
    pub(crate) node: Weak<Inner>,
}

impl ServiceServer {
    /// The service's whole name.
    pub fn name(&self) -> &str {
        &self.service.name
    }
}

impl Drop for ServiceServer {
    fn drop(&mut self) {
        if let Some(node) = self.node.upgrade() {
            node.remove_service(&self.service);
        }
    }
}
