//! Accepts connections and serves their requests.

use super::stream::GuardedStream;
use axum::Router;
use axum::body::Body;
use axum::http::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use rustls::ServerConfig;
use std::collections::BTreeMap;
use std::future::Future;
use std::net::IpAddr;
use std::pin::pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio_rustls::TlsAcceptor;
use tower::ServiceExt;

/// Maximum number of simultaneous connections: a browser opens six.
const CONNECTIONS_MAX: usize = 256;
/// Maximum number of simultaneous connections of one other machine.
const CONNECTIONS_OF_ONE_MAX: usize = 32;
/// Time limit for the head of a request, from the beginning of the wait for it; also the time for which an idle connection stays open.
const HEAD_PATIENCE: Duration = Duration::from_secs(10);
/// Time for the handshake of an encrypted connection.
const HANDSHAKE_PATIENCE: Duration = Duration::from_secs(5);
/// Time that a peer may let an answer wait.
const WRITE_PATIENCE: Duration = Duration::from_secs(20);
/// Maximum size of the head of a request, in bytes.
const HEAD_MAX_BYTES: usize = 32 << 10;
/// Maximum number of headers of a request.
const HEADERS_MAX: usize = 64;
/// Pause after the system refused to accept a connection, for example because it has no free file descriptors.
const REFUSED_PAUSE: Duration = Duration::from_millis(50);

/// The address of this machine to which a connection was made: an extension of every request.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Endpoint(pub(crate) IpAddr);

/// Open connections by the address of their peer.
#[derive(Default)]
struct Census(Mutex<BTreeMap<IpAddr, usize>>);

/// The permit of one connection; when it is dropped, the connection no longer counts.
struct ConnectionPlace {
    census: Arc<Census>,
    peer: IpAddr,
}

impl Census {
    /// Returns a permit for a connection of `peer`; `None` if a limit is reached.
    fn admit(self: &Arc<Census>, peer: IpAddr) -> Option<ConnectionPlace> {
        let mut open = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let own = open.get(&peer).copied().unwrap_or(0);
        let total: usize = open.values().sum();
        if total >= CONNECTIONS_MAX || (!peer.is_loopback() && own >= CONNECTIONS_OF_ONE_MAX) {
            return None;
        }
        open.insert(peer, own + 1);
        Some(ConnectionPlace { census: Arc::clone(self), peer })
    }
}

impl Drop for ConnectionPlace {
    fn drop(&mut self) {
        let mut open = self.census.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(count) = open.get_mut(&self.peer) {
            *count -= 1;
            if *count == 0 {
                open.remove(&self.peer);
            }
        }
    }
}

/// Serves `router` on connections to `listener`, encrypted by `tls`, until `stop`; requests under way then have `patience` to end.
pub(crate) async fn serve_connections(
    listener: TcpListener,
    router: Router,
    tls: Option<Arc<ServerConfig>>,
    stop: impl Future<Output = ()>,
    patience: Duration,
) {
    let census = Arc::new(Census::default());
    let acceptor = tls.map(TlsAcceptor::from);
    // Dropped at the end: connections under way then end, and `closed` resolves when all have.
    let (stopping, stopped) = watch::channel(());
    let mut stop = pin!(stop);
    loop {
        let accepted = tokio::select! {
            () = &mut stop => break,
            accepted = listener.accept() => accepted,
        };
        let Ok((stream, peer)) = accepted else {
            tokio::time::sleep(REFUSED_PAUSE).await;
            continue;
        };
        let Some(place) = census.admit(peer.ip()) else {
            tokio::spawn(turn_away(stream, acceptor.is_some()));
            continue;
        };
        // Answers consist of small pieces that should be sent at once.
        stream.set_nodelay(true).unwrap_or_default();
        let (router, acceptor, stopped) = (router.clone(), acceptor.clone(), stopped.clone());
        tokio::spawn(async move {
            let endpoint = Endpoint(stream.local_addr().map_or(peer.ip(), |address| address.ip()));
            let stream = GuardedStream::new(stream, WRITE_PATIENCE, place);
            match acceptor {
                None => serve_one(stream, endpoint, router, stopped).await,
                Some(acceptor) => {
                    if let Ok(Ok(stream)) = tokio::time::timeout(HANDSHAKE_PATIENCE, acceptor.accept(stream)).await {
                        serve_one(stream, endpoint, router, stopped).await;
                    }
                }
            }
        });
    }
    drop(listener);
    drop(stopped);
    stopping.send_replace(());
    tokio::time::timeout(patience, stopping.closed()).await.ok();
}

/// Answers that the server has no capacity for the connection, if the peer can read that.
async fn turn_away(mut stream: TcpStream, encrypted: bool) {
    if encrypted {
        return;
    }
    let body = "{\"error\":\"too many connections are open\",\"help\":\"close some, or try again later\"}";
    let answer = format!(
        "HTTP/1.1 503 Service Unavailable\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\
         X-Content-Type-Options: nosniff\r\nRetry-After: 5\r\nConnection: close\r\n\r\n{body}",
        body.len()
    );
    let written = stream.write_all(answer.as_bytes());
    // The result does not depend on whether the peer reads it.
    tokio::time::timeout(Duration::from_secs(1), written).await.ok();
}

/// Serves the requests of one connection.
async fn serve_one(
    stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
    endpoint: Endpoint,
    router: Router,
    mut stopped: watch::Receiver<()>,
) {
    let service = service_fn(move |request: Request<Incoming>| {
        let mut request = request.map(Body::new);
        request.extensions_mut().insert(endpoint);
        router.clone().oneshot(request)
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_PATIENCE)
        .max_buf_size(HEAD_MAX_BYTES)
        .max_headers(HEADERS_MAX)
        .serve_connection(TokioIo::new(stream), service)
        .with_upgrades();
    let mut connection = pin!(connection);
    tokio::select! {
        // The error concerns this connection only, and its peer notices it.
        _ = connection.as_mut() => {}
        _ = stopped.changed() => {
            connection.as_mut().graceful_shutdown();
            connection.await.ok();
        }
    }
}
