//! The CAN peripheral: bit times, and frames of ours to frames of the driver and back.

use crate::clock::CLOCK_HZ;
use core::num::{NonZeroU8, NonZeroU16};
use embassy_stm32::can::config::{
    DataBitTiming, FrameTransmissionConfig, GlobalFilter, NominalBitTiming, NonMatchingFilter, TxBufferMode,
};
use embassy_stm32::can::frame::{FdEnvelope, FdFrame, Header};
use embassy_stm32::can::{
    BufferedCanFd, BufferedFdCanReceiver, BufferedFdCanSender, CanConfigurator, IT0InterruptHandler,
    IT1InterruptHandler, RxFdBuf, TxFdBuf,
};
use embassy_stm32::peripherals::{FDCAN1, PA11, PA12};
use embassy_stm32::{Peri, bind_interrupts, pac};
use embedded_can::{ExtendedId, Id, StandardId};
use tactus_common::can::{CanFrame, IdBits, Mtu};

/// Frames that wait while the controller computes: 2 ms hold 15 frames of CAN 2.0 at 1 Mbit/s, and fewer of CAN FD.
const RECEIVED_MAX: usize = 32;
/// Frames of one tick that wait to be sent: a request, status and events on CAN 2.0 are about 40.
const SENT_MAX: usize = 64;

/// Quanta of a bit before and after its sample point, beside the first one: 1 Mbit/s, sampled at 80 %.
const NOMINAL: (u8, u8) = (135, 34);
/// The same for the data of CAN FD: 5 Mbit/s, sampled at 73.5 %.
const DATA: (u8, u8) = (24, 9);

const _: () = {
    assert!(CLOCK_HZ / (1 + NOMINAL.0 as u32 + NOMINAL.1 as u32) == 1_000_000);
    assert!(CLOCK_HZ / (1 + DATA.0 as u32 + DATA.1 as u32) == 5_000_000);
};

bind_interrupts!(struct Interrupts {
    FDCAN1_IT0 => IT0InterruptHandler<FDCAN1>;
    FDCAN1_IT1 => IT1InterruptHandler<FDCAN1>;
});

/// The bus, running.
pub struct Bus {
    _driver: BufferedCanFd<'static, SENT_MAX, RECEIVED_MAX>,
    receiver: BufferedFdCanReceiver,
    sender: BufferedFdCanSender,
}

/// Joins the bus.
pub fn start(can: Peri<'static, FDCAN1>, rx: Peri<'static, PA11>, tx: Peri<'static, PA12>) -> Bus {
    let mut configurator = CanConfigurator::new(can, rx, tx, Interrupts);
    let one = NonZeroU16::MIN;
    let quanta = |count: u8| NonZeroU8::new(count).expect("no part of a bit is empty");
    let nominal = NominalBitTiming {
        prescaler: one,
        seg1: quanta(NOMINAL.0),
        seg2: quanta(NOMINAL.1),
        sync_jump_width: quanta(NOMINAL.1),
    };
    let data = DataBitTiming {
        transceiver_delay_compensation: true,
        prescaler: one,
        seg1: quanta(DATA.0),
        seg2: quanta(DATA.1),
        sync_jump_width: quanta(DATA.1 - 1),
    };
    // Extended data frames are ours; the rest of the bus is no business of the controller.
    let filter = GlobalFilter {
        handle_standard_frames: NonMatchingFilter::Reject,
        handle_extended_frames: NonMatchingFilter::IntoRxFifo0,
        reject_remote_standard_frames: true,
        reject_remote_extended_frames: true,
    };
    configurator.set_config(
        configurator
            .config()
            .set_nominal_bit_timing(nominal)
            .set_data_bit_timing(data)
            .set_frame_transmit(FrameTransmissionConfig::AllowFdCanAndBRS)
            .set_global_filter(filter)
            // In the order of writing: a queue by priority may swap frames of one transfer.
            .set_tx_buffer_mode(TxBufferMode::Fifo),
    );
    let running = configurator.into_normal_mode();
    compensate_delay();
    let sent = cortex_m::singleton!(: TxFdBuf<SENT_MAX> = TxFdBuf::new()).expect("made once, here");
    let received = cortex_m::singleton!(: RxFdBuf<RECEIVED_MAX> = RxFdBuf::new()).expect("made once, here");
    let driver = running.buffered_fd(sent, received);
    Bus { receiver: driver.reader(), sender: driver.writer(), _driver: driver }
}

/// At 5 Mbit/s a transceiver answers later than a bit lasts, so the sender looks at its own bits that much later. The
/// driver takes the wish for this but does not carry it out.
fn compensate_delay() {
    let can = pac::FDCAN1;
    can.cccr().modify(|w| w.set_init(true));
    while !can.cccr().read().init() {}
    can.cccr().modify(|w| w.set_cce(true));
    can.tdcr().modify(|w| w.set_tdco(1 + DATA.0));
    can.dbtp().modify(|w| w.set_tdc(true));
    can.cccr().modify(|w| w.set_cce(false));
    can.cccr().modify(|w| w.set_init(false));
}

impl Bus {
    /// The next frame that came in.
    pub fn receive(&mut self) -> Option<CanFrame> {
        // What the driver calls errors are states of the bus, which the peripheral deals with by itself.
        while let Ok(event) = self.receiver.try_receive() {
            if let Some(frame) = event.ok().as_ref().and_then(ours) {
                return Some(frame);
            }
        }
        None
    }

    /// Puts a frame into the queue. One that finds no room is lost, as on any bus that cannot be reached: the drives
    /// let go after 20 ticks without a command.
    pub fn send(&mut self, frame: &CanFrame) {
        if let Some(frame) = theirs(frame) {
            let _ = self.sender.try_write(frame);
        }
    }
}

/// A frame as the controller knows it.
fn ours(envelope: &FdEnvelope) -> Option<CanFrame> {
    let (frame, header) = (&envelope.frame, envelope.frame.header());
    let mtu = if header.fdcan() { Mtu::Fd } else { Mtu::Classic };
    match header.id() {
        Id::Extended(id) => CanFrame::new(id.as_raw(), frame.data(), mtu).ok(),
        Id::Standard(id) => CanFrame::new_base(id.as_raw(), frame.data(), mtu).ok(),
    }
}

/// A frame as the driver knows it.
fn theirs(frame: &CanFrame) -> Option<FdFrame> {
    let id = match frame.id_bits() {
        IdBits::Extended => Id::from(ExtendedId::new(frame.id())?),
        IdBits::Base => Id::from(StandardId::new(u16::try_from(frame.id()).ok()?)?),
    };
    let length = frame.data().len() as u8;
    let header = match frame.mtu() {
        Mtu::Fd => Header::new_fd(id, length, false, true),
        Mtu::Classic => Header::new(id, length, false),
    };
    FdFrame::new(header, frame.data()).ok()
}
