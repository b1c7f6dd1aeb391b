//! Start, output and end on an emulated processor, by calls that QEMU answers (semihosting).

use core::arch::{asm, global_asm};
use core::fmt::{self, Write};

// A fault finds no vector, which ends QEMU. The FPU is switched on, where there is one.
#[cfg(all(target_arch = "arm", target_os = "none"))]
global_asm!(
    ".section .start, \"ax\"; .word STACK, begin, 0, 0; .thumb_func; begin: ldr r0, =0xe000ed88",
    "ldr r1, =0x00f00000; str r1, [r0]; dsb; isb; bl run; .pool"
);
#[cfg(target_os = "linux")]
global_asm!(".global begin; begin: bl run");
#[cfg(target_arch = "riscv32")]
global_asm!(".section .start, \"ax\"; .global begin; begin: la sp, STACK; call run");

/// Asks for an operation: 3 prints a character, 0x18 ends the program.
fn ask(operation: usize, argument: usize) {
    // SAFETY: of memory, QEMU reads the one character.
    unsafe {
        #[cfg(all(target_arch = "arm", target_os = "none"))]
        asm!("bkpt 0xab", inout("r0") operation => _, in("r1") argument);
        #[cfg(target_os = "linux")]
        asm!("svc 0x123456", inout("r0") operation => _, in("r1") argument);
        #[cfg(target_arch = "riscv32")]
        asm!(
            ".option push; .option norvc; .balign 16; slli x0, x0, 0x1f; ebreak; srai x0, x0, 7; .option pop",
            inout("a0") operation => _, in("a1") argument
        );
    }
}

struct Console;

impl Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes()
            .for_each(|byte| ask(3, &raw const byte as usize));
        Ok(())
    }
}

#[unsafe(no_mangle)]
extern "C" fn run() -> ! {
    let (single, double) = (super::checksum::<f32>(), super::checksum::<f64>());
    writeln!(Console, "{single:016x} {double:016x}").unwrap();
    end(0x20026)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    end(0)
}

/// Ends the program: 0x20026 is success.
fn end(reason: usize) -> ! {
    loop {
        ask(0x18, reason);
    }
}
