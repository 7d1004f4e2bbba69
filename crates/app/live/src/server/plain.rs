//! Connections whose writes raise no signal.
//!
//! To write several parts at once (`writev`) to a visitor that is gone raises SIGPIPE, which ends the program and the training that it shows.
//! To write one part (`send`) does not.

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::task::{Context, Poll};

use axum::serve::Listener;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};

/// A connection that takes one part at a time: it leaves out what would write several.
pub(super) struct Plain(TcpStream);

impl AsyncRead for Plain {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.0).poll_read(context, buffer)
    }
}

impl AsyncWrite for Plain {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.0).poll_write(context, bytes)
    }
    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.0).poll_flush(context)
    }
    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.0).poll_shutdown(context)
    }
}

/// Accepts such connections.
pub(super) struct PlainListener(pub TcpListener);

impl Listener for PlainListener {
    type Io = Plain;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Plain, SocketAddr) {
        let (stream, address) = Listener::accept(&mut self.0).await;
        (Plain(stream), address)
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.0.local_addr()
    }
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    #[test]
    fn a_connection_takes_one_part_at_a_time() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().build().expect("a runtime");
        runtime.block_on(async {
            let free = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
            let mut listener = PlainListener(TcpListener::bind(free).await.expect("a free port"));
            let address = listener.local_addr().expect("an address");
            let _visitor = std::net::TcpStream::connect(address).expect("comes in");
            let (stream, _) = listener.accept().await;
            assert!(!stream.is_write_vectored());
        });
    }
}
