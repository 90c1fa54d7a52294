//! What the virtual bus costs the machine it runs on: the frames of a 40 s mission, cut, carried and put together again.
//!
//! `cargo run --release -p tactus-hil --example bus_speed`

use std::time::Instant;
use tactus_common::can::Mtu;
use tactus_common::cyphal::{Header, NodeId, Priority, Sender, Session, SubjectId};
use tactus_hil::bus::{Bus, Received};
use tactus_hil::virtual_bus::{VirtualBus, VirtualBusConfig};

const TICKS: u64 = 20_000;
const TICK_NS: u64 = 2_000_000;
const WORLD: usize = 0;
const CONTROLLER: usize = 1;

fn mission(config: VirtualBusConfig) -> (f64, VirtualBus) {
    let node = |value| NodeId::new(value).expect("below 128");
    let [sensor, tactile, command] = [10, 11, 12].map(|value| SubjectId::new(value).expect("below 8192"));
    let mut world = Sender::new(node(1), [sensor, tactile]);
    let mut controller = Sender::new(node(2), [command]);
    let mut sensors = Session::<128>::new(sensor, node(1), 40_000_000);
    let mut commands = Session::<128>::new(command, node(2), 40_000_000);
    let mut bus = VirtualBus::new(2, config);
    let start = Instant::now();
    for tick in 0..TICKS {
        bus.advance_to(tick * TICK_NS);
        let payload: [u8; 65] = std::array::from_fn(|n| (tick as usize * 31 + n * n) as u8);
        for frame in world.send(sensor, Priority::Fast, &payload, config.mtu).expect("known subject") {
            bus.endpoint(WORLD).send(frame).expect("room");
        }
        if tick % 3 == 0 {
            for frame in world.send(tactile, Priority::High, &payload[..41], config.mtu).expect("known subject") {
                bus.endpoint(WORLD).send(frame).expect("room");
            }
        }
        bus.run_until_idle();
        while let Some(Received { frame, at_ns }) = bus.endpoint(CONTROLLER).receive() {
            let header = Header::parse(frame.id()).expect("a message");
            sensors.accept(&header, frame.data(), at_ns).expect("nothing lost");
        }
        for frame in controller.send(command, Priority::Fast, &payload[..34], config.mtu).expect("known subject") {
            bus.endpoint(CONTROLLER).send(frame).expect("room");
        }
        bus.run_until_idle();
        while let Some(Received { frame, at_ns }) = bus.endpoint(WORLD).receive() {
            let header = Header::parse(frame.id()).expect("a message");
            commands.accept(&header, frame.data(), at_ns).expect("nothing lost");
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    assert_eq!((sensors.stats().transfers, commands.stats().transfers), (TICKS as u32, TICKS as u32));
    (seconds, bus)
}

fn main() {
    for config in [VirtualBusConfig::FD, VirtualBusConfig::CLASSIC] {
        let mut seconds: Vec<f64> = (0..9).map(|_| mission(config).0).collect();
        seconds.sort_by(f64::total_cmp);
        let stats = mission(config).1.stats();
        let name = if config.mtu == Mtu::Fd { "CAN FD " } else { "CAN 2.0" };
        println!(
            "{name} {TICKS} ticks, {} frames: median {:.1} ms, {:.0} ns a frame; load at most {:.1} %",
            stats.frames,
            seconds[4] * 1e3,
            seconds[4] * 1e9 / stats.frames as f64,
            stats.load_max * 100.0
        );
    }
}
