//! A controller that is broken on purpose: one constant, the zero of the first joint's encoder, is a microradian off. For
//! the test that such a thing is found out. The one argument is the bus.

use std::process::ExitCode;
use std::time::Duration;
use tactus_common::can::CanFrame;
use tactus_common::cyphal::Header;
use tactus_common::link::{CONTROLLER, WORLD, subject};
use tactus_common::message::SensorFrame;
use tactus_hil::bus::{Bus, LiveBus, LiveStats, Received, Rejected, SendOnly};
use tactus_hil::bus_name::BusName;
use tactus_hil::shell::{Shell, ShellOptions};

/// Where a frame of readings holds the first joint's angle, in counts of a microradian: after the tick.
const FIRST_JOINT: usize = 4;

/// A bus on which the readings arrive a little wrong.
struct Wrong(Box<dyn LiveBus>);

impl Bus for Wrong {
    fn mtu(&self) -> tactus_common::can::Mtu {
        self.0.mtu()
    }

    fn send(&mut self, frame: CanFrame) -> Result<(), Rejected> {
        self.0.send(frame)
    }

    fn receive(&mut self) -> Option<Received> {
        let mut received = self.0.receive()?;
        let header = Header::of(&received.frame);
        if header.is_ok_and(|h| h.subject == subject::<SensorFrame>() && h.source == WORLD) {
            let mut data = received.frame.data().to_vec();
            data[FIRST_JOINT] = data[FIRST_JOINT].wrapping_add(1);
            if let Ok(frame) = CanFrame::new(received.frame.id(), &data, received.frame.mtu()) {
                received.frame = frame;
            }
        }
        Some(received)
    }
}

impl LiveBus for Wrong {
    fn wait(&mut self, timeout: Duration) -> bool {
        self.0.wait(timeout)
    }

    fn sender(&self) -> std::io::Result<Box<dyn SendOnly>> {
        self.0.sender()
    }

    fn stats(&self) -> LiveStats {
        self.0.stats()
    }
}

fn main() -> ExitCode {
    let name = std::env::args().nth(1).and_then(|name| name.parse::<BusName>().ok());
    let Some(Ok(bus)) = name.map(|name| name.open(None, &[WORLD, CONTROLLER])) else {
        eprintln!("expected: a bus");
        return ExitCode::from(2);
    };
    let mut bus = Wrong(bus);
    Shell::new(&mut bus, ShellOptions { once: true, ..ShellOptions::default() }).run(&mut |said| eprintln!("{said}"));
    ExitCode::SUCCESS
}
