use super::*;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use std::fs::File;
use std::io::{Read, Write};
use std::os::unix::net::UnixListener;

const SOON: Duration = Duration::from_secs(5);

fn frame(id: u32, data: &[u8]) -> CanFrame {
    CanFrame::new(id, data, Mtu::Classic).unwrap()
}

/// A place for a socket that no other test uses.
fn socket(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("tactus-slcan-{}-{name}", std::process::id()));
    let _ = std::fs::remove_file(&path);
    path
}

/// A bus and the adapter's end of its socket, the opening commands taken.
fn joined(name: &str) -> (SlcanBus, UnixStream, UnixListener) {
    let path = socket(name);
    let listener = UnixListener::bind(&path).unwrap();
    let bus = SlcanBus::open(&path).unwrap();
    let mut adapter = listener.accept().unwrap().0;
    assert_eq!(take(&mut adapter, 7), b"C\rS8\rO\r");
    (bus, adapter, listener)
}

fn take(from: &mut impl Read, count: usize) -> Vec<u8> {
    let mut bytes = vec![0; count];
    from.read_exact(&mut bytes).unwrap();
    bytes
}

#[test]
fn frames_pass_both_ways_over_a_socket() {
    let (mut bus, mut adapter, _listener) = joined("both-ways");
    bus.send(frame(0x123, &[1, 2])).unwrap();
    assert_eq!(take(&mut adapter, 15), b"T0000012320102\r");
    assert_eq!(bus.receive(), None);
    assert!(!bus.wait(Duration::from_millis(1)));
    adapter.write_all(b"\r\r\rT00000").unwrap();
    assert!(!bus.wait(Duration::from_millis(1)), "half a line is no frame");
    adapter.write_all(b"4561AB\rt7770\r").unwrap();
    assert!(bus.wait(SOON));
    assert_eq!(bus.receive().unwrap().frame, frame(0x456, &[0xab]));
    assert_eq!(bus.receive().unwrap().frame, CanFrame::classic_base(0x777, []));
    assert_eq!(bus.receive(), None);
    let stats = bus.stats();
    assert_eq!((stats.sent, stats.received, stats.errors, stats.foreign, stats.downs), (1, 2, 0, 0, 0));
}

#[test]
fn frames_pass_both_ways_over_a_pseudo_terminal_byte_for_byte() {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let name = ptsname(&master, Vec::new()).unwrap();
    let mut bus = SlcanBus::open(Path::new(name.to_str().unwrap())).unwrap();
    let mut adapter = File::from(master);
    // A terminal that is not raw would give back CR as LF, echo, and keep lines to itself.
    assert_eq!(take(&mut adapter, 7), b"C\rS8\rO\r");
    bus.send(frame(0x1abc_def0, &[0x0d, 0x0a, 0x03, 0x04, 0x11, 0x13, 0x7f, 0xff])).unwrap();
    assert_eq!(take(&mut adapter, 27), b"T1ABCDEF080D0A030411137FFF\r");
    adapter.write_all(b"\rT000000010\r").unwrap();
    assert!(bus.wait(SOON));
    assert_eq!(bus.receive().unwrap().frame, frame(1, &[]));
}

#[test]
fn text_and_noise_are_counted_and_the_next_line_is_whole() {
    let (mut bus, mut adapter, _listener) = joined("noise");
    adapter.write_all(b"#stopped at x.rs:1\rT12\r\x07\xff\xfe\x00\rT0000000711\rT000000071EE\r").unwrap();
    assert!(bus.wait(SOON));
    assert_eq!(bus.receive().unwrap().frame, frame(7, &[0xee]));
    assert_eq!((bus.stats().foreign, bus.stats().errors), (4, 1));
}

#[test]
fn can_fd_frames_are_refused() {
    let (mut bus, _adapter, _listener) = joined("fd");
    let fd = CanFrame::new(1, &[0; 12], Mtu::Fd).unwrap();
    assert_eq!(bus.send(fd).unwrap_err().reason, Refusal::Format);
    assert_eq!(bus.mtu(), Mtu::Classic);
}

#[test]
fn a_line_that_takes_nothing_fills_up_and_loses_no_line_that_it_took() {
    let (mut bus, mut adapter, _listener) = joined("full");
    let taken = (0..100_000_u32).take_while(|&n| bus.send(frame(n, &n.to_le_bytes())).is_ok()).count() as u32;
    assert!((2_000..90_000).contains(&taken), "{taken}");
    assert_eq!(bus.send(frame(0, &[0; 8])).unwrap_err().reason, Refusal::Full);
    let reader = std::thread::spawn(move || {
        for n in 0..taken {
            let line = take(&mut adapter, 19);
            assert_eq!(line[..], slcan::encode(&frame(n, &n.to_le_bytes())).unwrap()[..], "line {n}");
        }
        adapter
    });
    while !reader.is_finished() {
        bus.wait(Duration::from_millis(1));
    }
    let _adapter = reader.join().unwrap();
    bus.send(frame(0, &[])).unwrap();
}

#[test]
fn two_threads_do_not_mix_their_lines() {
    let (mut bus, adapter, _listener) = joined("threads");
    let mut other = bus.sender().unwrap();
    let reader = std::thread::spawn(move || {
        let mut parser = Parser::new();
        let lines = std::io::BufReader::new(adapter).bytes().filter_map(|byte| parser.feed(byte.unwrap()));
        lines.take(2_000).filter(|line| matches!(line, Line::Frame(_))).count()
    });
    let writer = std::thread::spawn(move || (0..1_000).for_each(|n| other.send(frame(n, &[2; 8])).unwrap()));
    (0..1_000).for_each(|n| bus.send(frame(n, &[1; 3])).unwrap());
    writer.join().unwrap();
    while !reader.is_finished() {
        bus.wait(Duration::from_millis(1));
    }
    assert_eq!(reader.join().unwrap(), 2_000);
    assert_eq!(bus.stats().sent, 2_000);
}

#[test]
fn a_peer_that_goes_is_noticed_and_one_that_comes_back_is_found() {
    let (mut bus, adapter, listener) = joined("back");
    drop((adapter, listener));
    assert!(!bus.wait(Duration::from_millis(1)));
    assert_eq!(bus.send(frame(1, &[])).unwrap_err().reason, Refusal::Down);
    assert!(!bus.wait(Duration::from_millis(1)));
    assert_eq!(bus.stats().downs, 1);
    let path = bus.path.clone();
    std::fs::remove_file(&path).unwrap();
    let listener = UnixListener::bind(&path).unwrap();
    let adapter = std::thread::spawn(move || {
        let mut adapter = listener.accept().unwrap().0;
        assert_eq!(take(&mut adapter, 7), b"C\rS8\rO\r", "the channel is opened anew");
        adapter.write_all(b"T000000010\r").unwrap();
        adapter
    });
    assert!(bus.wait(SOON));
    assert_eq!(bus.receive().unwrap().frame, frame(1, &[]));
    bus.send(frame(2, &[])).unwrap();
    assert_eq!(take(&mut adapter.join().unwrap(), 11), b"T000000020\r");
}

#[test]
fn what_is_no_serial_line_is_refused_with_its_name() {
    for (path, reason) in [("/nonexistent/tty", "No such file"), ("/dev/null", "expected a serial port")] {
        let error = SlcanBus::open(Path::new(path)).unwrap_err().to_string();
        assert!(error.contains(path) && error.contains(reason), "{error}");
    }
    let path = socket("deserted");
    drop(UnixListener::bind(&path).unwrap());
    let error = SlcanBus::open(&path).unwrap_err().to_string();
    assert!(error.contains("nobody listens"), "{error}");
}
