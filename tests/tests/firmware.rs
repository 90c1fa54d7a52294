//! Promise: the controller as a Cortex-M4F image does exactly what it does in the process of the world.

use std::time::{Duration, Instant};
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, Sender, Session};
use tactus_common::limits::PAYLOAD_BYTES_MAX;
use tactus_common::link::{self, CONTROLLER, SMALL_BYTES, WORLD, priority, subject};
use tactus_common::message::{
    Command, DigestReport, Message, PlanAnswer, RolloutResult, SensorFrame, Setup, TactileSlice,
};
use tactus_common::reading::JointCommands;
use tactus_hil::bus::{Bus, LiveBus};
use tactus_hil::slcan_bus::SlcanBus;
use tactus_tests::emulator::{Emulator, image};
use tactus_tests::recording::Recording;
use tactus_tests::rig::{Rig, Told};

/// For anything that the image has to do.
const PATIENCE: Duration = Duration::from_secs(60);

/// The world's end of a serial line with the image at the other end: tells it what a recording holds.
struct Player {
    bus: SlcanBus,
    sender: Sender<5>,
    command: Session<SMALL_BYTES>,
    digest: Session<SMALL_BYTES>,
    reported: Option<DigestReport>,
}

impl Player {
    fn new(bus: SlcanBus) -> Self {
        let subjects = [
            subject::<Setup>(),
            subject::<SensorFrame>(),
            subject::<TactileSlice>(),
            subject::<PlanAnswer>(),
            subject::<RolloutResult>(),
        ];
        Self {
            bus,
            sender: Sender::new(WORLD, subjects),
            command: Session::new(subject::<Command>(), CONTROLLER, 0),
            digest: Session::new(subject::<DigestReport>(), CONTROLLER, 0),
            reported: None,
        }
    }

    fn send<M: Message>(&mut self, message: &M) {
        let mut buffer = [0; PAYLOAD_BYTES_MAX];
        let bytes = link::encode(message, &mut buffer).expect("the largest message fits");
        let frames = self.sender.send(subject::<M>(), priority::<M>(), bytes, Mtu::Classic).expect("a subject");
        for frame in frames {
            self.bus.send(frame).expect("the line takes a tick's frames");
        }
    }

    /// One tick, up to the command that ends it.
    fn tell(&mut self, told: &Told) -> JointCommands {
        told.setup.iter().for_each(|m| self.send(m));
        told.plan.iter().for_each(|m| self.send(m));
        told.rollout.iter().for_each(|m| self.send(m));
        told.image.iter().for_each(|m| self.send(m));
        let sensors = told.sensors.expect("a tick has readings");
        self.send(&sensors);
        let tick = sensors.unpack().tick;
        let begun = Instant::now();
        loop {
            // What the image says of itself once a second is no answer.
            assert!(begun.elapsed() < PATIENCE, "tick {tick}: no command from the image");
            self.bus.wait(PATIENCE);
            while let Some(received) = self.bus.receive() {
                if let Some(command) = self.hear(&received.frame).filter(|command| command.tick == tick) {
                    return command;
                }
            }
        }
    }

    /// The command that this frame completes.
    fn hear(&mut self, frame: &CanFrame) -> Option<JointCommands> {
        let header = Header::of(frame).expect("the image sends messages");
        if let Ok(Some(t)) = self.digest.accept(&header, frame.data(), 0) {
            self.reported = Some(link::decode(t.payload).expect("a digest"));
        }
        let whole = self.command.accept(&header, frame.data(), 0).ok().flatten()?;
        let command: Command = link::decode(whole.payload).expect("a command");
        command.unpack()
    }
}

#[test]
#[ignore = "needs the image and qemu: cargo xtask test runs it"]
fn a_recorded_mission_gives_the_same_commands_and_digest_in_the_image_as_on_the_host() {
    let recording = Recording::shared();
    let emulator = Emulator::start(&image(), "replay");
    let mut player = Player::new(SlcanBus::open(emulator.socket()).expect("the emulator listens"));
    let mut host = Rig::new();
    let begun = Instant::now();
    for (n, told) in recording.told.iter().enumerate() {
        if n % 500 == 0 {
            eprintln!("{n} {:?}", begun.elapsed());
        }
        assert_eq!(player.tell(told), host.tell(told).commands(), "first difference");
    }
    assert_eq!(player.reported, recording.report.digest, "ticks and digest");
    assert!(player.reported.is_some());
    let told = emulator.told("mission", PATIENCE);
    println!("{told:?}");
    assert_eq!(told.number("lost"), 0, "bytes lost on the serial line");
}
