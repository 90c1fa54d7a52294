//! The world's end of a serial line that a test speaks for, byte by byte if it wants: tells a controller at the other end
//! what a recording holds.

use crate::rig::Told;
use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, Sender, Session};
use tactus_common::limits::PAYLOAD_BYTES_MAX;
use tactus_common::link::{self, CONTROLLER, SMALL_BYTES, WORLD, priority, subject};
use tactus_common::message::{
    Command, DigestReport, Event, Hello, Message, PlanAnswer, RolloutResult, SensorFrame, Setup, TactileSlice,
};
use tactus_common::reading::JointCommands;
use tactus_common::slcan::{self, Line, Parser};

/// For an answer of the controller.
const PATIENCE: Duration = Duration::from_secs(60);

/// A message of the controller that matters here.
#[derive(Clone, Debug, PartialEq)]
pub enum Heard {
    /// Joint commands.
    Command(JointCommands),
    /// Something happened.
    Event(Event),
    /// The digest.
    Digest(DigestReport),
    /// It waits for a mission.
    Hello,
}

/// The world's end.
pub struct SerialWorld {
    port: UnixStream,
    parser: Parser,
    sender: Sender<5>,
    command: Session<SMALL_BYTES>,
    event: Session<SMALL_BYTES>,
    digest: Session<SMALL_BYTES>,
    hello: Session<SMALL_BYTES>,
}

impl SerialWorld {
    /// Joins the line at this socket.
    ///
    /// # Panics
    /// If nobody listens there.
    pub fn join(socket: &Path) -> Self {
        let subjects = [
            subject::<Setup>(),
            subject::<SensorFrame>(),
            subject::<TactileSlice>(),
            subject::<PlanAnswer>(),
            subject::<RolloutResult>(),
        ];
        Self {
            port: UnixStream::connect(socket).expect("the emulator listens"),
            parser: Parser::new(),
            sender: Sender::new(WORLD, subjects),
            command: Session::new(subject::<Command>(), CONTROLLER, 0),
            event: Session::new(subject::<Event>(), CONTROLLER, 0),
            digest: Session::new(subject::<DigestReport>(), CONTROLLER, 0),
            hello: Session::new(subject::<Hello>(), CONTROLLER, 0),
        }
    }

    /// Puts bytes on the line as they are.
    ///
    /// # Panics
    /// If the line is gone.
    pub fn write(&mut self, bytes: &[u8]) {
        self.port.write_all(bytes).expect("the line is there");
    }

    /// Sends a frame.
    ///
    /// # Panics
    /// As [`SerialWorld::write`].
    pub fn send_frame(&mut self, frame: &CanFrame) {
        self.write(&slcan::encode(frame).expect("CAN 2.0"));
    }

    fn send<M: Message>(&mut self, message: &M) {
        let mut buffer = [0; PAYLOAD_BYTES_MAX];
        let bytes = link::encode(message, &mut buffer).expect("the largest message fits");
        let frames = self.sender.send(subject::<M>(), priority::<M>(), bytes, Mtu::Classic).expect("a subject");
        let lines: Vec<u8> = frames.flat_map(|frame| slcan::encode(&frame).expect("CAN 2.0")).collect();
        self.write(&lines);
    }

    /// One tick, up to the command that ends it.
    ///
    /// # Panics
    /// If no command comes.
    pub fn tell(&mut self, told: &Told) -> JointCommands {
        told.setup.iter().for_each(|m| self.send(m));
        told.plan.iter().for_each(|m| self.send(m));
        told.rollout.iter().for_each(|m| self.send(m));
        told.image.iter().for_each(|m| self.send(m));
        let sensors = told.sensors.expect("a tick has readings");
        self.send(&sensors);
        let tick = sensors.unpack().tick;
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE {
            for heard in self.listen(Duration::from_secs(1)) {
                match heard {
                    Heard::Command(command) if command.tick == tick => return command,
                    Heard::Command(_) | Heard::Event(_) | Heard::Digest(_) | Heard::Hello => {}
                }
            }
        }
        panic!("tick {tick}: no command from the controller");
    }

    /// What arrives first within this time.
    ///
    /// # Panics
    /// If the line is gone, or what arrives does not decode.
    pub fn listen(&mut self, within: Duration) -> Vec<Heard> {
        self.port.set_read_timeout(Some(within)).expect("more than no time");
        let mut bytes = [0; 4_096];
        let count = match self.port.read(&mut bytes) {
            Ok(0) => panic!("the line is gone"),
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(error) => panic!("the line: {error}"),
        };
        let lines: Vec<Line> = bytes[..count].iter().filter_map(|&byte| self.parser.feed(byte)).collect();
        lines.iter().filter_map(|line| if let Line::Frame(frame) = line { self.hear(frame) } else { None }).collect()
    }

    /// Everything that arrives in this time.
    ///
    /// # Panics
    /// As [`SerialWorld::listen`].
    pub fn listen_for(&mut self, time: Duration) -> Vec<Heard> {
        let begun = Instant::now();
        let mut heard = Vec::new();
        while let Some(left) = time.checked_sub(begun.elapsed()).filter(|left| !left.is_zero()) {
            heard.extend(self.listen(left));
        }
        heard
    }

    /// All bytes up to the end of the line, of which there is one, as text.
    ///
    /// # Panics
    /// If the line does not end.
    pub fn rest(&mut self) -> String {
        self.port.set_read_timeout(Some(PATIENCE)).expect("more than no time");
        let mut bytes = Vec::new();
        match self.port.read_to_end(&mut bytes) {
            Err(error) if error.kind() != ErrorKind::ConnectionReset => panic!("the line: {error}"),
            Ok(_) | Err(_) => String::from_utf8_lossy(&bytes).replace('\r', "\n"),
        }
    }

    fn hear(&mut self, frame: &CanFrame) -> Option<Heard> {
        let header = Header::of(frame).expect("the controller sends messages");
        let data = frame.data();
        if let Ok(Some(whole)) = self.command.accept(&header, data, 0) {
            let command: Command = link::decode(whole.payload).expect("a command");
            return Some(Heard::Command(command.unpack().expect("hand modes that exist")));
        }
        if let Ok(Some(whole)) = self.event.accept(&header, data, 0) {
            return Some(Heard::Event(link::decode(whole.payload).expect("an event")));
        }
        if let Ok(Some(whole)) = self.digest.accept(&header, data, 0) {
            return Some(Heard::Digest(link::decode(whole.payload).expect("a digest")));
        }
        let hello = self.hello.accept(&header, data, 0).ok().flatten()?;
        link::decode::<Hello>(hello.payload).ok().map(|_| Heard::Hello)
    }
}
