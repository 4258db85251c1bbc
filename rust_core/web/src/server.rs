//! The server's thread: accepts connections within limits, and serves each as a task.

use std::io;
use std::net::{IpAddr, SocketAddr, TcpListener as StdListener};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use rcs_process::join_within;
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::{oneshot, Semaphore};
use tokio::task::yield_now;
use tokio::time::{sleep, timeout};

use crate::access::Access;
use crate::connections::{Connections, Slot};
use crate::limits::Limits;
use crate::operator::Operator;
use crate::pages::Pages;
use crate::requests::{self, Site, MOST_REQUESTS};

/// Most bytes of a request's headers.
const MOST_HEADER_BYTES: usize = 16 << 10;
/// Most connections that wait to be accepted.
const BACKLOG: i32 = 1024;
/// Time until a connection is accepted after that failed: usually the descriptors are used up.
const RETRY_AFTER: Duration = Duration::from_millis(200);
const END_PATIENCE: Duration = Duration::from_millis(500);
/// Threads for requests that wait.
const WORKERS: usize = 2;

/// A running server; dropping it closes all connections.
pub struct Server {
    address: SocketAddr,
    pages: Pages,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Listens at an address, and serves the pages on a thread.
    ///
    /// # Errors
    /// The address cannot be listened at, or the thread cannot be started.
    pub fn start(
        address: SocketAddr,
        access: Access,
        operator: Arc<dyn Operator>,
        pages: Pages,
        limits: Limits,
    ) -> io::Result<Self> {
        let listener = StdListener::bind(address)?;
        // Again: of more than std's 128 that come at a time, some would wait for a second.
        rustix::net::listen(&listener, BACKLOG)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let runtime = Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .max_blocking_threads(WORKERS)
            .thread_name("web-worker")
            .build()?;
        let workers = Arc::new(Semaphore::new(MOST_REQUESTS));
        let site = Arc::new(Site { access, operator, pages: pages.clone(), limits, workers });
        let (end, is_ended) = oneshot::channel();
        let serving = move || serve(&runtime, listener, &site, is_ended);
        let thread = std::thread::Builder::new().name("web".to_owned()).spawn(serving)?;
        Ok(Self { address, pages, end: Some(end), thread: Some(thread) })
    }

    /// The address that the server listens at.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        drop(self.end.take());
        self.pages.images().end();
        if let Some(thread) = self.thread.take() {
            // One that waits for a worker ends with the process.
            join_within(thread, END_PATIENCE);
        }
    }
}

fn serve(runtime: &Runtime, listener: StdListener, site: &Arc<Site>, is_ended: oneshot::Receiver<()>) {
    let accepting = async {
        let listener = match TcpListener::from_std(listener) {
            Ok(listener) => listener,
            Err(error) => return log::error!("the page's server cannot accept connections: {error}"),
        };
        tokio::select! {
            () = accept_all(&listener, site) => {}
            // Fails when the server is dropped, which is the end, too.
            _ = is_ended => {}
        }
    };
    runtime.block_on(accepting);
}

async fn accept_all(listener: &TcpListener, site: &Arc<Site>) {
    let connections = Connections::new(site.limits.connections);
    loop {
        match listener.accept().await {
            Ok((stream, peer)) => {
                let peer = peer.ip();
                connections.serve(peer, |slot| serve_connection(stream, peer, Arc::clone(site), slot));
                // So that it is read before others displace it.
                yield_now().await;
            }
            Err(error) => {
                log::warn!("the page's server cannot accept a connection: {error}; it goes on");
                sleep(RETRY_AFTER).await;
            }
        }
    }
}

/// Serves one request; a WebSocket goes on as a task of its own, with the connection's slot.
async fn serve_connection(stream: TcpStream, peer: IpAddr, site: Arc<Site>, slot: Arc<Slot>) {
    // Only delays small messages if it fails.
    let _ = stream.set_nodelay(true);
    let service = service_fn(|mut request: hyper::Request<hyper::body::Incoming>| {
        request.extensions_mut().insert(Arc::clone(&slot));
        requests::answer(Arc::clone(&site), peer, request)
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(site.limits.headers)
        .max_buf_size(MOST_HEADER_BYTES)
        // Nothing is lost when an idle connection is closed that a request is sent on.
        .keep_alive(false)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    // A client that leaves, or sends no HTTP, concerns nobody else.
    let _ = timeout(site.limits.request, connection).await;
}
