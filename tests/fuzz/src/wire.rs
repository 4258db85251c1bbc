//! What other nodes and the master send beside messages: connection headers, HTTP, XML-RPC.

use rcs_ros::fuzzing;

use crate::first_byte;

/// A connection header with its length.
pub(crate) fn tcpros_header(data: &[u8]) {
    if let Some(written) = fuzzing::tcpros_header(data) {
        assert_eq!(fuzzing::tcpros_header(&written), Some(written));
    }
}

/// An HTTP message; the first byte chooses between call and answer, and how many bytes come at a time.
pub(crate) fn http(data: &[u8]) {
    let (choice, bytes) = first_byte(data);
    let (is_call, piece_bytes) = (choice & 1 == 0, usize::from(choice >> 1));
    // Pieces of a byte each: a long head is parsed anew with each of them.
    let piece_bytes = piece_bytes.max(bytes.len() / 200);
    let body = fuzzing::http_body(bytes, piece_bytes, is_call);
    assert!(body.as_ref().is_none_or(|body| body.len() <= bytes.len()));
    // What is complete in pieces is the same as a whole. The reverse does not hold: a head may begin like another one.
    if body.is_some() {
        assert_eq!(fuzzing::http_body(bytes, usize::MAX, is_call), body);
    }
}

/// A call and an answer.
pub(crate) fn xmlrpc(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    if let Some(written) = fuzzing::xmlrpc_call(&text) {
        assert_eq!(fuzzing::xmlrpc_call(&written), Some(written));
    }
    if let Some(written) = fuzzing::xmlrpc_answer(&text) {
        assert_eq!(fuzzing::xmlrpc_answer(&written), Some(written));
    }
}
