//! The node's TCPROS port: every subscriber and every service client connects here and says in its header what it wants.

use crate::header::Header;
use crate::node::Inner;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::sync::{Arc, Weak};
use std::time::Duration;

const HEADER_TIMEOUT: Duration = Duration::from_secs(10);

/// Accepts connections until the node is gone or closed.
pub(crate) fn run(listener: &TcpListener, node: &Weak<Inner>) {
    for stream in listener.incoming() {
        let Some(node) = node.upgrade().filter(|node| !node.is_closed()) else {
            return;
        };
        match stream {
            Ok(stream) => {
                let spawned =
                    std::thread::Builder::new().name("ros-connection".to_owned()).spawn(move || serve(&node, stream));
                if let Err(error) = spawned {
                    log::error!("cannot serve a connection: {error}");
                }
            }
            // Too many open files, for one. It may pass.
            Err(error) => {
                log::error!("cannot accept a connection: {error}");
                std::thread::sleep(Duration::from_millis(100));
            }
        }
    }
}

/// Makes [`run`] look whether the node is closed.
pub(crate) fn wake(port: u16) {
    // If nobody listens any more, that is as good.
    let _ = TcpStream::connect_timeout(&(Ipv4Addr::LOCALHOST, port).into(), Duration::from_millis(200));
}

fn serve(node: &Arc<Inner>, mut stream: TcpStream) {
    let prepared = stream.set_nodelay(true).and_then(|()| stream.set_read_timeout(Some(HEADER_TIMEOUT)));
    // A port scan, or the call of `wake`: nobody to tell.
    let (Ok(()), Ok(request)) = (prepared, Header::read(&mut stream)) else {
        return;
    };
    let node_name = node.name().to_owned();
    if let Some(name) = request.get("service") {
        match node.service(name) {
            Some(service) => {
                if let Err(error) = service.serve(&node_name, stream, &request) {
                    log::debug!("service {name}: {error}");
                }
            }
            None => refuse(stream, &format!("{node_name} offers no service {name}")),
        }
    } else if let Some(topic) = request.get("topic") {
        match node.publication(topic) {
            Some(publication) => publication.serve(&node_name, stream, &request),
            None => refuse(stream, &format!("{node_name} does not publish {topic}")),
        }
    } else {
        refuse(stream, "connection header names neither a topic nor a service");
    }
}

fn refuse(mut stream: TcpStream, reason: &str) {
    // It may be gone already.
    let _ = Header::new([("error", reason)]).write(&mut stream);
}
