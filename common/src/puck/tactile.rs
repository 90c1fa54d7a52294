//! Images of the tactile pads: whole pads in five frames, or their ten strongest cells in one.

use crate::limits::PAD_CELLS;

/// What to set the property TACT to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i16)]
pub enum Request {
    /// Sends nothing.
    Off = 0,
    /// Selects [`Top10`] and sends one image.
    Top10 = 1,
    /// Selects [`FullFrame`]s and sends one image.
    Full = 2,
    /// Takes the present values for zero; sends nothing.
    Tare = 3,
}

/// Largest value of a cell of a whole image: 12 bits.
pub const CELL_MAX: u16 = 0xfff;
/// Value of a cell per N/cm^2.
pub const UNITS_PER_N_CM2: f32 = 256.0;
/// Cells in one frame of a whole image.
pub const FRAME_CELLS: usize = 5;
/// Frames of a whole image: 24 cells; the last place of the last frame stays empty.
pub const FULL_FRAMES: usize = 5;

const _: () = assert!(FULL_FRAMES * FRAME_CELLS >= PAD_CELLS && (FULL_FRAMES - 1) * FRAME_CELLS < PAD_CELLS);

/// One of the five frames of a whole image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FullFrame {
    index: u8,
    cells: [u16; FRAME_CELLS],
}

impl FullFrame {
    /// Frame `index` (0..=4) with cells `5 index` to `5 index + 4`, each in 1/256 N/cm^2; `None` if the index or a cell
    /// ([`CELL_MAX`]) is out of range.
    pub fn new(index: u8, cells: [u16; FRAME_CELLS]) -> Option<Self> {
        let fits = usize::from(index) < FULL_FRAMES && cells.iter().all(|cell| *cell <= CELL_MAX);
        fits.then_some(Self { index, cells })
    }

    /// The five frames of an image; cells beyond [`CELL_MAX`] are cut to it.
    pub fn of_image(image: &[u16; PAD_CELLS]) -> [Self; FULL_FRAMES] {
        core::array::from_fn(|index| {
            let cell = |n: usize| image.get(FRAME_CELLS * index + n).copied().unwrap_or(0).min(CELL_MAX);
            Self { index: index as u8, cells: core::array::from_fn(cell) }
        })
    }

    /// Which frame, 0..=4.
    pub const fn index(&self) -> u8 {
        self.index
    }

    /// Its cells, 1/256 N/cm^2.
    pub const fn cells(&self) -> &[u16; FRAME_CELLS] {
        &self.cells
    }

    /// The frame's data: 4 bits of index and five times 12 bits, the highest first.
    pub fn pack(&self) -> [u8; 8] {
        let cells = self.cells.iter();
        cells.fold(u64::from(self.index), |bits, cell| bits << 12 | u64::from(*cell & CELL_MAX)).to_be_bytes()
    }

    /// Reads a frame's data.
    ///
    /// # Errors
    /// The index, if it is above 4.
    pub fn unpack(raw: [u8; 8]) -> Result<Self, u8> {
        let bits = u64::from_be_bytes(raw);
        let index = (bits >> 60) as u8;
        if usize::from(index) >= FULL_FRAMES {
            return Err(index);
        }
        Ok(Self { index, cells: [48, 36, 24, 12, 0].map(|shift| (bits >> shift) as u16 & CELL_MAX) })
    }
}

/// Puts whole images together, whatever the order of their frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FullImage {
    cells: [u16; PAD_CELLS],
    seen: u8,
}

impl FullImage {
    /// Takes a frame; the whole image, 1/256 N/cm^2, if it was the last one that was missing. The next frame then begins
    /// a new image.
    pub fn add(&mut self, frame: &FullFrame) -> Option<[u16; PAD_CELLS]> {
        let from = usize::from(frame.index) * FRAME_CELLS;
        for (cell, value) in self.cells.iter_mut().skip(from).zip(frame.cells) {
            *cell = value;
        }
        self.seen |= 1 << frame.index;
        if self.seen != (1 << FULL_FRAMES) - 1 {
            return None;
        }
        self.seen = 0;
        Some(self.cells)
    }

    /// Forgets the frames of an image that is not whole; `true` if there were any.
    pub fn restart(&mut self) -> bool {
        core::mem::take(&mut self.seen) != 0
    }
}

/// At which end of the map cell 0 is: the public drivers disagree, and nobody has said which is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapOrder {
    /// Cell 0 is the highest bit (OWD).
    HighestFirst,
    /// Cell 0 is the lowest bit (pyHand).
    LowestFirst,
}

/// The ten strongest cells of a pad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Top10 {
    map: u32,
    values: [u8; 10],
}

impl Top10 {
    /// `map`: 24 bits of which ten are set; `values`: the ten cells in order, N/cm^2, 0..=15. `None` for anything else.
    pub fn new(map: u32, values: [u8; 10]) -> Option<Self> {
        let fits = map >> PAD_CELLS == 0 && map.count_ones() == 10 && values.iter().all(|value| *value < 16);
        fits.then_some(Self { map, values })
    }

    /// The frame's data: the map, high byte first, and ten half bytes.
    pub fn pack(&self) -> [u8; 8] {
        let values = self.values.iter();
        values.fold(u64::from(self.map), |bits, value| bits << 4 | u64::from(*value & 0xf)).to_be_bytes()
    }

    /// Reads a frame's data.
    ///
    /// # Errors
    /// The map, if not ten of its bits are set.
    pub fn unpack(raw: [u8; 8]) -> Result<Self, u32> {
        let bits = u64::from_be_bytes(raw);
        let map = (bits >> 40) as u32;
        let values = core::array::from_fn(|n| (bits >> (36 - 4 * n)) as u8 & 0xf);
        Self::new(map, values).ok_or(map)
    }

    /// Pressure of every cell, N/cm^2; 0 for those that are not among the ten.
    pub fn cells_n_cm2(&self, order: MapOrder) -> [u8; PAD_CELLS] {
        let mut values = self.values.iter().copied();
        core::array::from_fn(|cell| {
            let bit = if order == MapOrder::LowestFirst { cell } else { PAD_CELLS - 1 - cell };
            let listed = self.map >> bit & 1 == 1;
            if listed { values.next().unwrap_or(0) } else { 0 }
        })
    }
}
