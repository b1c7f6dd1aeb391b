//! The boards' flash: calls of its cells.

use embedded_storage::nor_flash::{NorFlash, NorFlashErrorKind, ReadNorFlash};
use spindle_firmware::flash;

/// Cells that write down what is asked of them.
#[derive(Default)]
struct Asked {
    said: Vec<String>,
    /// Calls that go well.
    good: usize,
}

impl Asked {
    fn say(&mut self, what: String) -> bool {
        self.said.push(what);
        self.said.len() <= self.good
    }
}

impl flash::Cells for Asked {
    const UNIT: usize = 32;

    fn read(&mut self, at: u32, unit: &mut [u8]) -> bool {
        unit.fill(at.to_le_bytes()[0]);
        self.say(format!("read {at} {}", unit.len()))
    }

    fn program(&mut self, at: u32, unit: &[u8]) -> bool {
        self.say(format!("program {at} {} of {}", unit.len(), unit[0]))
    }

    fn erase(&mut self, sector: u32) -> bool {
        self.say(format!("erase {sector}"))
    }
}

#[test]
fn the_boards_flash_goes_unit_by_unit_and_stays_within_its_sectors() {
    use NorFlashErrorKind::{NotAligned, Other, OutOfBounds};
    const END: u32 = flash::SECTORS * flash::SECTOR;
    let asked = |good| {
        flash::Flash(Asked {
            good,
            ..Asked::default()
        })
    };
    let mut flash = asked(9);
    let mut bytes = [0; 64];
    assert_eq!(flash.read(END - 64, &mut bytes), Ok(()));
    assert_eq!((bytes[0], bytes[63]), (192, 224));
    assert_eq!(flash.write(32, &bytes), Ok(()));
    assert_eq!(flash.erase(flash::SECTOR, END), Ok(()));
    assert_eq!(flash.erase(0, END), Ok(()));
    // Nothing of these gets through.
    assert_eq!(flash.read(END - 32, &mut bytes), Err(OutOfBounds));
    assert_eq!(flash.write(END, &bytes), Err(OutOfBounds));
    assert_eq!(flash.erase(0, END + flash::SECTOR), Err(OutOfBounds));
    assert_eq!(flash.read(4, &mut bytes), Err(NotAligned));
    assert_eq!(flash.write(32, &bytes[1..]), Err(NotAligned));
    assert_eq!(flash.erase(0, 4096), Err(NotAligned));
    let expected = [
        "read 262080 32",
        "read 262112 32",
        "program 32 32 of 192",
        "program 64 32 of 224",
        "erase 1",
        "erase 0",
        "erase 1",
    ];
    assert_eq!(flash.0.said, expected);
    // What fails ends it.
    let mut flash = asked(1);
    assert_eq!(flash.write(0, &bytes), Err(Other));
    assert_eq!(flash.erase(0, END), Err(Other));
    assert_eq!(flash.read(0, &mut bytes), Err(Other));
    assert_eq!(flash.0.said.len(), 4);
}
