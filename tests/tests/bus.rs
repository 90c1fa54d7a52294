//! Promise: whatever the wire does, no wrong value is taken, nothing that was lost goes unnoticed, and the mission ends
//! with the object at its goal or with a reason.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use std::cell::Cell;
use std::rc::Rc;
use tactus_common::can::{CanFrame, ID_MAX, Mtu};
use tactus_common::cyphal::{Header, NodeId, Priority, Sender, SubjectId, TailByte};
use tactus_common::limits::SILENCE_TICKS_MAX;
use tactus_common::link::{CONTROLLER, WORLD, subject};
use tactus_common::message::{
    Command, EventKind, FaultReason, Message, Outcome, Phase, PlanAnswer, RolloutResult, SensorFrame, Setup,
    TactileSlice, node,
};
use tactus_hil::virtual_bus::Faults;
use tactus_sim_host::hooks::{Hooks, To};
use tactus_sim_host::mission::MissionReport;
use tactus_tests::recording::{Recording, options, run_hooked, run_tampered};
use tactus_tests::rig::{Rig, Told, header, is_limp};

/// What a mission may come to when the wire loses or changes things.
fn ended_with_a_reason(report: &MissionReport) {
    let end = report.outcome;
    println!("  {}: {} missed", report.outcome_text(), report.deadline_misses);
    assert!(end.is_some(), "no end that the world heard of");
}

fn subject_of(frame: &CanFrame) -> Option<u16> {
    Header::parse(frame.id()).ok().map(|header| header.subject.get())
}

/// The frame with one bit flipped.
fn flip(frame: &CanFrame, bit: usize) -> CanFrame {
    let mut data = frame.data().to_vec();
    let bit = bit % (data.len() * 8);
    data[bit / 8] ^= 1 << (bit % 8);
    CanFrame::new(frame.id(), &data, frame.mtu()).expect("the same length")
}

#[test]
fn on_a_sound_bus_everything_is_in_time_and_a_replay_gives_the_same_digest() {
    let recording = Recording::shared();
    let rig = recording.play(|_, _| true);
    assert_eq!(rig.node.stats(), Default::default(), "nothing foreign, bad, late or missed");
    assert_eq!(
        rig.node.end().map(|(_, digest)| digest),
        recording.report.digest,
        "the controller is a function of what it is told"
    );
}

#[test]
fn frames_that_are_damaged_and_sent_again_or_arrive_twice_change_nothing() {
    let clean = &Recording::shared().report;
    let faults = Faults { damage_ppm: 20_000, double_ppm: 20_000, loss_ppm: 0, seed: 3 };
    let report = run_hooked(&options(1), Hooks { faults, ..Hooks::NONE });
    assert_eq!(report.outcome, Some(Outcome::Transported));
    assert!(report.wire.frames > clean.wire.frames + clean.wire.frames / 50, "faults did happen");
    assert_eq!(report.digest, clean.digest);
}

#[test]
fn frames_of_strangers_change_nothing() {
    let clean = &Recording::shared().report;
    let mut random = Pcg32::seed_from_u64(5);
    let seen = Rc::new(Cell::new(0));
    let count = Rc::clone(&seen);
    let report = run_tampered(&options(1), move |passing, arrives| {
        let frame = passing.frame;
        let mut id = random.next_u32() & ID_MAX;
        if let Some(header) = Header::parse(frame.id()).ok().filter(|_| random.next_u32() % 2 == 0) {
            // Our subject from a node that is none of ours.
            id = Header { source: NodeId::new(99).unwrap(), ..header }.id();
        }
        let ours = Header::parse(id).is_ok_and(|h| [node::WORLD, node::CONTROLLER].contains(&h.source.get()));
        if !ours {
            arrives.push(CanFrame::new(id, frame.data(), frame.mtu()).unwrap());
            count.set(count.get() + 1);
        }
        arrives.push(frame);
    });
    println!("{} frames of strangers", seen.get());
    assert!(seen.get() > 30_000);
    assert_eq!((report.outcome, report.digest), (clean.outcome, clean.digest));
}

#[test]
fn a_wire_that_loses_frames_ends_the_mission_with_a_reason() {
    for (loss_ppm, seed) in [(300, 1), (1_000, 2), (20_000, 3), (200_000, 4)] {
        let faults = Faults { loss_ppm, seed, ..Faults::NONE };
        println!("{loss_ppm} ppm lost:");
        let report = run_hooked(&options(1), Hooks { faults, ..Hooks::NONE });
        assert!(report.wire.lost > 0, "losses are counted");
        ended_with_a_reason(&report);
    }
}

#[test]
fn a_wire_that_changes_bits_ends_the_mission_with_a_reason() {
    // A real bus drops such frames (its own CRC); a bad gateway behind it would not.
    for (one_in, seed) in [(3_000, 1), (100, 2)] {
        let mut random = Pcg32::seed_from_u64(seed);
        println!("one frame in {one_in} changed:");
        let report = run_tampered(&options(1), move |passing, arrives| {
            let hit = random.next_u32() % one_in == 0;
            let bit = random.next_u32() as usize;
            // The set-up decides what the mission is; it is spoilt in another test.
            let spared = subject_of(&passing.frame) == Some(Setup::SUBJECT);
            arrives.push(if hit && !spared { flip(&passing.frame, bit) } else { passing.frame });
        });
        ended_with_a_reason(&report);
    }
}

#[test]
fn a_lost_sensor_frame_is_noticed() {
    for lost in [1, 5, SILENCE_TICKS_MAX - 1] {
        for mut rig in Recording::shared().stops(997) {
            let clean = rig.clone();
            let missed = rig.node.stats().missed;
            for _ in 0..lost {
                // It was sent and took up its number.
                rig.frames(&SensorFrame::pack(&rig.readings()));
                rig.silence();
            }
            let said = rig.sense(|_| ());
            assert_eq!(said.command.map(|c| c.tick), Some(rig.tick()), "the next one is taken at once");
            assert_eq!(rig.node.stats().missed, missed + lost, "{lost} lost at tick {}", rig.tick());
            assert_ne!(rig.node.digest(), clean.node.digest());
        }
    }
}

#[test]
fn a_lost_sensor_frame_shows_in_the_digest_of_the_run() {
    let clean = &Recording::shared().report;
    let mut done = false;
    let report = run_tampered(&options(1), move |passing, arrives| {
        let hit = passing.tick == 5_000 && subject_of(&passing.frame) == Some(SensorFrame::SUBJECT) && !done;
        done |= hit;
        if !hit {
            arrives.push(passing.frame);
        }
    });
    assert_ne!(report.digest, clean.digest);
    assert_eq!(report.outcome, Some(Outcome::Transported), "one is bridged");
}

#[test]
fn lost_images_answers_and_rollouts_are_noticed() {
    let recording = Recording::shared();
    let mut start = None;
    recording.play(|rig, said| {
        start = said.plan.is_some().then(|| rig.clone());
        start.is_none()
    });
    let start = start.unwrap();
    let answer = recording.told.iter().find_map(|t| t.plan.clone()).unwrap();
    let image = recording.told.iter().find_map(|t| t.image).unwrap();
    let mut rig = start.clone();
    rig.send(&image);
    rig.frames(&image);
    rig.send(&image);
    assert_eq!(rig.node.stats().missed, start.node.stats().missed + 1);
    // Every frame of an answer is needed.
    let frames = start.clone().frames(&answer);
    assert!(frames.len() > 3, "{}", frames.len());
    for lost in 0..frames.len() {
        let mut rig = start.clone();
        rig.frames(&answer);
        rig.deliver(&[&frames[..lost], &frames[lost + 1..]].concat());
        let said = rig.sense(|_| ());
        assert_eq!(said.events, [], "frame {lost} of {} lost", frames.len());
        // Asked again, it gets through.
        rig.send(&answer);
        assert_ne!(rig.sense(|_| ()).events, [], "after frame {lost}");
    }
}

#[test]
fn an_answer_with_any_bit_changed_is_not_taken() {
    let recording = Recording::shared();
    let mut start = None;
    recording.play(|rig, said| {
        start = said.plan.is_some().then(|| rig.clone());
        start.is_none()
    });
    let mut start = start.unwrap();
    let answer = recording.told.iter().find_map(|t| t.plan.clone()).unwrap();
    let frames = start.frames(&answer);
    let mut random = Pcg32::seed_from_u64(8);
    for n in 0..2_000 {
        let mut rig = start.clone();
        let mut spoilt = frames.clone();
        let at = random.next_u32() as usize % spoilt.len();
        let bits = spoilt[at].data().len() * 8;
        // All but the bits of the last frame's tail byte that number the transfer are covered.
        let bit = random.next_u32() as usize % (bits - 8);
        spoilt[at] = flip(&spoilt[at], bit);
        rig.deliver(&spoilt);
        let said = rig.sense(|_| ());
        assert_eq!(said.events, [], "{n}: bit {bit} of frame {at}");
        assert!(rig.node.stats().bad_frames > start.node.stats().bad_frames, "it is counted");
    }
    let mut rig = start.clone();
    rig.deliver(&frames);
    assert!(rig.sense(|_| ()).events.iter().any(|e| matches!(e.kind, EventKind::Touch { .. })), "whole, it is taken");
}

#[test]
fn an_old_sensor_frame_is_not_taken_for_new() {
    const OLDEST: usize = 70;
    let told = &Recording::shared().told;
    for begin in [1_000_usize, 6_000, 14_500] {
        let start = Recording::shared().play(|rig, _| rig.tick() as usize + 1 < begin - OLDEST);
        for age in 1..=OLDEST {
            let mut rig = start.clone();
            let mut kept = Vec::new();
            for (tick, told) in told.iter().enumerate().take(begin).skip(begin - OLDEST) {
                let frames = rig.frames_of(told);
                if tick + age == begin {
                    kept = vec![*frames.last().unwrap()];
                }
                rig.deliver(&frames);
            }
            assert_eq!((kept.len(), rig.node.stats()), (1, start.node.stats()));
            let digest = rig.node.digest();
            let said = rig.deliver(&kept);
            assert_eq!(said, Default::default(), "{age} ticks old: the controller must not tick");
            assert_eq!(rig.node.digest(), digest);
            // What follows must get through before silence makes the robot limp.
            let mut deaf = 0;
            for told in &told[begin..begin + 40] {
                let said = rig.tell(told);
                if said.command.is_none() {
                    deaf += 1;
                    rig.silence();
                }
                assert_eq!(said.fault(), None);
            }
            assert!(deaf < SILENCE_TICKS_MAX, "{age} ticks old: deaf for {deaf} ticks");
            assert_ne!(rig.phase(), Phase::Fault);
        }
    }
}

#[test]
fn a_command_that_answers_another_tick_is_not_taken_by_the_world() {
    // Every command of a while is replaced by the one of ten ticks before, its transfer number made new.
    let command = header::<Command>(CONTROLLER);
    let mut old = std::collections::VecDeque::new();
    let mut count = 0;
    let report = run_tampered(&options(1), move |passing, arrives| {
        if passing.to != To::World || subject_of(&passing.frame) != Some(command.subject.get()) {
            arrives.push(passing.frame);
            return;
        }
        old.push_back(passing.frame);
        let before = if old.len() > 10 { old.pop_front() } else { None };
        if (6_000..6_010).contains(&passing.tick) {
            count += 1;
            let mut data = before.unwrap().data().to_vec();
            *data.last_mut().unwrap() = *passing.frame.data().last().unwrap();
            arrives.push(CanFrame::new(passing.frame.id(), &data, Mtu::Fd).unwrap());
        } else {
            arrives.push(passing.frame);
        }
        assert!(count <= 10);
    });
    assert_eq!(report.deadline_misses, 10, "an old command counts as none");
    assert_eq!(report.outcome, Some(Outcome::Transported));
}

#[test]
fn another_schema_version_is_refused() {
    let recording = Recording::shared();
    let first = recording.told.iter().find(|told| told.setup.is_some()).unwrap();
    let mut setup = first.setup.unwrap();
    setup.schema_version[3] ^= 1;
    let mut rig = Rig::new();
    let said = rig.tell(&Told { setup: Some(setup), sensors: first.sensors, ..Told::default() });
    assert_eq!(said.fault(), Some(FaultReason::SchemaMismatch));
    assert_eq!(rig.phase(), Phase::Fault);
    for _ in 0..1_000 {
        let said = rig.sense(|_| ());
        assert_eq!((said.plan, said.events), (None, vec![]), "it does nothing");
    }
    // Once told properly, it begins; the ticks of a mission count from 0.
    let said = rig.tell(&Told {
        setup: first.setup,
        sensors: Some(SensorFrame::pack(&{
            let mut readings = rig.readings();
            readings.tick = 0;
            readings
        })),
        ..Told::default()
    });
    assert_eq!((said.fault(), rig.phase()), (None, Phase::Plan));
}

#[test]
fn set_ups_that_make_no_sense_are_refused() {
    let recording = Recording::shared();
    let first = recording.told.iter().find(|told| told.setup.is_some()).unwrap();
    let ways: [fn(&mut Setup); 7] = [
        |s| s.guess.x_m = f32::NAN,
        |s| s.interval.phi_rad = -0.1,
        |s| s.interval.x_m = f32::INFINITY,
        |s| s.displacement_m[1] = f32::NAN,
        |s| s.mass_kg = -1.0,
        |s| s.mass_kg = f32::NAN,
        |s| s.trials_max = 0,
    ];
    for (n, spoil) in ways.iter().enumerate() {
        let mut setup = first.setup.unwrap();
        spoil(&mut setup);
        let mut rig = Rig::new();
        let said = rig.tell(&Told { setup: Some(setup), sensors: first.sensors, ..Told::default() });
        assert_eq!(said.fault(), Some(FaultReason::BadSetup), "way {n}");
    }
}

#[test]
fn random_bytes_under_our_ids_never_panic_and_never_exceed_a_limit() {
    // The rig looks at every command; a flood of nonsense may make the robot safe, but must not make it unsafe.
    let subjects = [
        (Setup::SUBJECT, Setup::PRIORITY),
        (SensorFrame::SUBJECT, SensorFrame::PRIORITY),
        (TactileSlice::SUBJECT, TactileSlice::PRIORITY),
        (PlanAnswer::SUBJECT, PlanAnswer::PRIORITY),
        (RolloutResult::SUBJECT, RolloutResult::PRIORITY),
    ];
    let mut random = Pcg32::seed_from_u64(17);
    let mut senders = Sender::new(WORLD, subjects.map(|(s, _)| SubjectId::new(s).unwrap()));
    for mut rig in Recording::shared().stops(499) {
        for n in 0..1_000 {
            let (number, priority) = subjects[random.next_u32() as usize % subjects.len()];
            let number = SubjectId::new(number).unwrap();
            let mut payload = vec![0; random.next_u32() as usize % 300];
            random.fill_bytes(&mut payload);
            match n % 3 {
                // A whole transfer with sound CRC, holding nonsense of about the right length.
                0 => {
                    let priority = Priority::ALL[usize::from(priority)];
                    let frames: Vec<CanFrame> = senders.send(number, priority, &payload, Mtu::Fd).unwrap().collect();
                    rig.deliver(&frames);
                }
                // A single frame of nonsense.
                1 => {
                    payload.resize(63, 0);
                    let tail = TailByte { start: true, end: true, toggle: true, transfer_id: n as u8 % 32 };
                    payload.push(tail.emit());
                    let id = Header { priority: Priority::High, subject: number, source: WORLD };
                    rig.deliver(&[CanFrame::new(id.id(), &payload, Mtu::Fd).unwrap()]);
                }
                // Anything at all.
                _ => {
                    let length = Mtu::Fd.frame_bytes(payload.len() % 65).unwrap();
                    payload.resize(length, 0);
                    let id = header::<SensorFrame>(WORLD).id();
                    rig.deliver(&[CanFrame::new(id, &payload, Mtu::Fd).unwrap()]);
                }
            }
        }
        // Silence afterwards ends in safety wherever the nonsense left it.
        let mut last = None;
        for _ in 0..2 * SILENCE_TICKS_MAX {
            last = rig.silence().command.or(last);
        }
        assert!(is_limp(&last.unwrap()), "{last:?}");
        assert_eq!(rig.phase(), Phase::Fault);
    }
}

#[test]
fn frames_cut_short_or_without_data_are_counted_and_ignored() {
    let recording = Recording::shared();
    let start = recording.play(|rig, _| rig.phase() != Phase::Trial);
    for keep in [0_usize, 1, 5, 8, 32, 48] {
        let mut rig = start.clone();
        let mut readings = rig.readings();
        readings.tick = rig.tick() + 1;
        let frame = rig.frames(&SensorFrame::pack(&readings))[0];
        let tail = *frame.data().last().unwrap();
        let mut data = frame.data()[..keep].to_vec();
        if let Some(last) = data.last_mut() {
            *last = tail;
        }
        let said = rig.deliver(&[CanFrame::new(frame.id(), &data, Mtu::Fd).unwrap()]);
        assert_eq!(said, Default::default(), "{keep} bytes");
        let stats = rig.node.stats();
        assert_eq!(stats.bad_frames + stats.bad_payloads, 1, "{keep} bytes: {stats:?}");
    }
}

#[test]
fn every_subject_has_its_own_number() {
    let mut numbers = [
        subject::<Setup>(),
        subject::<SensorFrame>(),
        subject::<TactileSlice>(),
        subject::<PlanAnswer>(),
        subject::<RolloutResult>(),
        subject::<Command>(),
        subject::<tactus_common::message::PlanRequest>(),
        subject::<tactus_common::message::RolloutRequest>(),
        subject::<tactus_common::message::Status>(),
        subject::<tactus_common::message::Event>(),
        subject::<tactus_common::message::DigestReport>(),
        subject::<tactus_common::message::Heartbeat>(),
    ]
    .map(SubjectId::get);
    numbers.sort_unstable();
    assert!(numbers.windows(2).all(|pair| pair[0] < pair[1]), "{numbers:?}");
}
