//! Properties by number: what a puck can be asked and what can be set.
//!
//! Numbers differ between firmware versions. Those here hold from [`VERSION_MIN`] on, for the properties that exist
//! then. 32-bit properties occupy two numbers.

/// Firmware version of a motor puck from which on the numbers of [`motor`] hold (108 means something else before 175).
pub const VERSION_MIN: i32 = 145;

/// Number of a property, 0..127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Property(u8);

impl Property {
    /// `None` above 127.
    pub const fn new(number: u8) -> Option<Self> {
        if number < 128 { Some(Self(number)) } else { None }
    }

    /// The number.
    pub const fn number(self) -> u8 {
        self.0
    }

    /// Does a motor puck answer it with 32 bits? These are the properties whose next number means nothing.
    pub fn is_long_on_motor(self) -> bool {
        motor::LONG.contains(&self)
    }
}

macro_rules! table {
    ($($name:ident = $number:literal $doc:literal)*) => {
        $(#[doc = $doc] pub const $name: Property = Property($number);)*
        /// Every property of this table by name.
        pub const ALL: &[(&str, Property)] = &[$((stringify!($name), $name)),*];
    };
}

/// Motor pucks of arm and hand. VERS to VALUE exist in every state and on every kind of node.
pub mod motor {
    use super::Property;

    /// Properties of 32 bits.
    pub const LONG: [Property; 13] = [P, DP, E, OT, CT, M, MECH, CTS, IOFF, HALLH, EN, JP, JOFST];

    table! {
        VERS = 0 "Firmware version."
        ROLE = 1 "What the puck is: [`super::super::state::Role`]."
        SN = 2 "Serial number."
        ID = 3 "Node number."
        ERROR = 4 "Error."
        STAT = 5 "[`super::super::state::Status`]."
        ADDR = 6 "Address for VALUE."
        VALUE = 7 "Memory at ADDR."
        MODE = 8 "[`super::super::state::Mode`]."
        TEMP = 9 "Temperature of the puck, degrees Celsius."
        PTEMP = 10 "Highest temperature so far."
        OTEMP = 11 "Temperature limit."
        BAUD = 12 "Bit rate."
        LOCK = 13 "Guards ID and ROLE."
        DIG0 = 14 "Digital input or output 0."
        DIG1 = 15 "Digital input or output 1."
        FET0 = 16 "Switched output 0 (brake)."
        FET1 = 17 "Switched output 1 (cable tensioner)."
        ANA0 = 18 "Analogue input 0, 0..4095."
        ANA1 = 19 "Analogue input 1, 0..4095."
        THERM = 20 "Temperature of the motor, degrees Celsius."
        VBUS = 21 "Bus voltage, raw."
        IMOTOR = 22 "Motor current, raw."
        VLOGIC = 23 "Logic voltage, raw."
        ILOGIC = 24 "Logic current, raw."
        SG = 25 "Strain gauge, raw 12 bits: the fingertip torque."
        GRPA = 26 "First group that the puck listens to."
        GRPB = 27 "Second group."
        GRPC = 28 "Third group."
        CMD = 29 "[`super::super::state::HandOrder`]."
        SAVE = 30 "Number of a property to store."
        LOAD = 31 "Number of a property to restore."
        DEF = 32 "Number of a property to set to its default."
        FIND = 33 "Number of a property to calibrate."
        X0 = 34 "Scratch value 0."
        X1 = 35 "Scratch value 1."
        X2 = 36 "Scratch value 2."
        X3 = 37 "Scratch value 3."
        X4 = 38 "Scratch value 4."
        X5 = 39 "Scratch value 5."
        X6 = 40 "Scratch value 6."
        X7 = 41 "Scratch value 7."
        T = 42 "Torque, puck units; packed for groups: [`super::super::packed::Torques`]."
        MT = 43 "Largest torque, puck units."
        V = 44 "Velocity set-point, counts per millisecond."
        MV = 45 "Largest velocity of moves, counts per millisecond."
        MCV = 46 "Largest closing velocity, counts per millisecond."
        MOV = 47 "Largest opening velocity, counts per millisecond."
        P = 48 "Position, counts; packed when answered. Set: the set-point in position mode, else the origin."
        DP = 50 "Default position, counts."
        E = 52 "End point of a trapezoidal move, counts."
        OT = 54 "Where opening ends, counts."
        CT = 56 "Where closing ends, counts."
        M = 58 "Move to this position, counts."
        DS = 60 "Step of incremental moves, counts."
        MOFST = 61 "Commutation offset."
        IOFST = 62 "Offset of the current sensor."
        UPSECS = 63 "Seconds since start."
        OD = 64 "Odometer."
        MDS = 65 "Unit unknown."
        MECH = 66 "Position within a motor turn, counts."
        CTS = 68 "Encoder counts per motor turn."
        PIDX = 70 "Slot 1..4 in packed torques."
        HSG = 71 "Upper strain limit."
        LSG = 72 "Lower strain limit."
        IVEL = 73 "Velocity while the hand initialises."
        IOFF = 74 "Offset while the hand initialises, counts."
        MPE = 76 "Largest position error."
        HOLD = 77 "1: hold the position after a move, 0: idle."
        TSTOP = 78 "Give up after this long at the torque limit."
        KP = 79 "Proportional gain of the position loop."
        KD = 80 "Derivative gain."
        KI = 81 "Integral gain."
        ACCEL = 82 "Acceleration of moves, unit unknown."
        TENST = 83 "Cable tensioner."
        TENSO = 84 "Cable tensioner."
        JIDX = 85 "Number of the joint."
        IPNM = 86 "Torque units per newton-metre at the motor."
        HALLS = 87 "State of the Hall sensors."
        HALLH = 88 "History of the Hall sensors."
        POLES = 90 "Motor poles; on M7 6 = wrist, 8 = gimbals."
        IKP = 91 "Proportional gain of the current loop."
        IKI = 92 "Integral gain of the current loop."
        IKCOR = 93 "Correction of the current loop."
        EN = 94 "Encoder, raw."
        JP = 96 "Position of the second encoder, counts; packed when answered."
        JOFST = 98 "Offset of the second encoder."
        TIE = 100 "Ties inner and outer link."
        ECMAX = 101 "Upper index mark of the joint encoder."
        ECMIN = 102 "Lower index mark of the joint encoder."
        LFLAGS = 103 "Unit unknown."
        LCTC = 104 "Unit unknown."
        LCVC = 105 "Unit unknown."
        TACT = 106 "[`super::super::tactile::Request`]."
        TACTID = 107 "Number of the tactile board; -2: it failed."
        IHIT = 108 "Torque while the hand initialises: sets the breakaway force."
    }
}

/// The safety module, besides the first 42 of [`motor`].
pub mod safety {
    use super::Property;

    table! {
        ZERO = 42 "1: the arm's position has been set since power-up."
        PEN = 43 "[`super::super::state::Pendant`]; answered with 32 bits."
        SAFE = 44 "Calibration of the module."
        VL1 = 45 "Velocity warning, 1/4096 m/s."
        VL2 = 46 "Velocity fault, 1/4096 m/s."
        TL1 = 47 "Torque warning, puck units."
        TL2 = 48 "Torque fault, puck units."
        VOLTL1 = 49 "Low voltage warning, V."
        VOLTL2 = 50 "Low voltage fault, V."
        VOLTH1 = 51 "High voltage warning, V."
        VOLTH2 = 52 "High voltage fault, V."
        PWR = 53 "Power."
        MAXPWR = 54 "Largest power."
        IFAULT = 55 "Velocity faults to pass over."
        VNOM = 56 "Nominal voltage."
    }
}

/// The force/torque sensor at the wrist, besides the first 42 of [`motor`].
pub mod force {
    use super::Property;

    table! {
        SG1 = 42 "Gauge 1, raw."
        SG2 = 43 "Gauge 2, raw."
        SG3 = 44 "Gauge 3, raw."
        SG4 = 45 "Gauge 4, raw."
        SG5 = 46 "Gauge 5, raw."
        SG6 = 47 "Gauge 6, raw."
        FX = 48 "Force along x."
        FY = 49 "Force along y."
        FZ = 50 "Force along z."
        TX = 51 "Torque about x."
        TY = 52 "Torque about y."
        TZ = 53 "Torque about z."
        FT = 54 "Get: force and torque, a frame each; set to 0: tare."
        AX = 55 "Acceleration along x."
        AY = 56 "Acceleration along y."
        AZ = 57 "Acceleration along z."
        GM = 58 "Gain matrix."
        OV = 59 "Offsets."
        LED = 60 "Lamp."
        T1 = 61 "Temperature 1."
        T2 = 62 "Temperature 2."
        T3 = 63 "Temperature 3."
        A = 64 "Get: acceleration, a frame."
    }
}
