//! Shows one page to browsers on this machine: HTTP/1.1 on the loopback interface, one connection after the other.

use anyhow::Context;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::time::Duration;

/// Longest request that is read, bytes.
const REQUEST_MAX: u64 = 16 << 10;
/// A browser that says nothing for so long is left alone.
const PATIENCE: Duration = Duration::from_secs(2);

/// A page at a port of this machine.
pub struct Server {
    listener: TcpListener,
    page: String,
}

impl Server {
    /// Opens the port; 0 takes a free one.
    ///
    /// # Errors
    /// The port is taken, or not allowed.
    pub fn open(port: u16, page: String) -> anyhow::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).with_context(|| format!("--serve {port}"))?;
        Ok(Self { listener, page })
    }

    /// Where the page is.
    ///
    /// # Errors
    /// The operating system does not say.
    pub fn address(&self) -> anyhow::Result<String> {
        Ok(format!("http://{}/", self.listener.local_addr()?))
    }

    /// Answers requests until the program is ended; what goes wrong with one of them concerns no other.
    ///
    /// # Errors
    /// The port is lost.
    pub fn run(&self) -> anyhow::Result<()> {
        loop {
            self.answer_next()?;
        }
    }

    /// Answers one request.
    fn answer_next(&self) -> anyhow::Result<()> {
        let (stream, _) = self.listener.accept().context("--serve")?;
        // A browser that goes away in the middle has what it wanted.
        let _ = self.answer(stream);
        Ok(())
    }

    fn answer(&self, mut stream: TcpStream) -> std::io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let request = read_request(&stream)?;
        let (status, kind, body) = match request.split(' ').collect::<Vec<_>>()[..] {
            ["GET" | "HEAD", "/", _] => ("200 OK", "text/html; charset=utf-8", self.page.as_bytes()),
            ["GET" | "HEAD", ..] => ("404 Not Found", "text/plain", "only / is here\n".as_bytes()),
            _ => ("405 Method Not Allowed", "text/plain", "only GET is known\n".as_bytes()),
        };
        let length = body.len();
        let head = format!(
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n"
        );
        stream.write_all(head.as_bytes())?;
        if !request.starts_with("HEAD ") {
            stream.write_all(body)?;
        }
        stream.flush()
    }
}

/// The request line; the headers are read and forgotten.
fn read_request(stream: &TcpStream) -> std::io::Result<String> {
    let mut lines = BufReader::new(stream.take(REQUEST_MAX)).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    for line in lines {
        if line?.is_empty() {
            break;
        }
    }
    Ok(request)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(request: &str) -> String {
        let server = Server::open(0, "<p>a page</p>".into()).unwrap();
        let mut stream = TcpStream::connect(server.listener.local_addr().unwrap()).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        server.answer_next().unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    #[test]
    fn the_page_is_at_the_root_and_nothing_else_is_anywhere() {
        let answer = asked("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
        assert!(answer.starts_with("HTTP/1.1 200 OK\r\n") && answer.ends_with("\r\n\r\n<p>a page</p>"), "{answer}");
        assert!(asked("HEAD / HTTP/1.1\r\n\r\n").ends_with("\r\n\r\n"));
        assert!(asked("GET /../secret HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 404"));
        assert!(asked("POST / HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 405"));
        assert!(asked("nonsense\r\n\r\n").starts_with("HTTP/1.1 405"));
    }

    #[test]
    fn only_this_machine_is_answered_and_a_taken_port_is_named() {
        let server = Server::open(0, String::new()).unwrap();
        let address = server.listener.local_addr().unwrap();
        assert!(address.ip().is_loopback());
        let refused = Server::open(address.port(), String::new()).err().map(|e| format!("{e:#}")).unwrap_or_default();
        assert!(refused.starts_with(&format!("--serve {}: ", address.port())), "{refused}");
    }
}
