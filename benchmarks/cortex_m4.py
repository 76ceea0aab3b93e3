"""How much flash and RAM the exported C takes on a Cortex-M4F, and an estimate of its time for a frame.

python -m benchmarks.cortex_m4             Table I and the fitted LGMD2
python -m benchmarks.cortex_m4 my-fit      another model

The exported robot.c is compiled for the STM32F407, which gives flash and RAM. cortex_m4.c runs under QEMU, whose log
names each block of instructions that is executed; the last frame counts, with texture and noise in each pixel. Each
instruction costs what ARM states for it (Cortex-M4 Technical Reference Manual, tables 3-1 and 7-1), where that is a
range the upper end. It is an estimate: QEMU knows no pipeline, and flash is taken never to let the core wait.
"""

import argparse
import dataclasses
import json
import re
import subprocess
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import jax

import lgmd2jax as lgmd
from lgmd2jax._c.source import sources
from lgmd2jax._handover.model_file import as_lgmd2, document
from lgmd2jax._handover.named import model_named

CLOCK_HZ = 168e6
EYE = lgmd.Eye(72, 99, 0.7, 30.0)
TOOLS = ("arm-none-eabi-gcc", "qemu-system-arm", "make")
_HERE = Path(__file__).parent
_CORTEX_M4F = "-std=c99 -O3 -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -ffunction-sections -I."
_LINK = "-nostartfiles -Wl,--gc-sections -T emulated.ld -specs=rdimon.specs"
# Cycles by the beginning of a mnemonic, the first that fits; r is the number of registers in a list. A result of the
# floating-point unit that the next instruction needs costs one more, which is charged always.
_CYCLES = (
    (r"vdiv|vsqrt", lambda r: 14),
    (r"vfn?m[as]|vn?ml[as]", lambda r: 3),
    (r"vldm|vstm|vpush|vpop", lambda r: 1 + r),
    (r"vldr|vstr", lambda r: 2),
    (r"vcvt|vadd|vsub|vmul|vnmul|vcmp|vabs|vneg", lambda r: 2),
    (r"v", lambda r: 1),
    (r"ldm|stm|push", lambda r: 1 + r),
    (r"pop", lambda r: 4 + r),
    (r"ldrd|strd", lambda r: 3),
    (r"ldr|str", lambda r: 2),
    (r"sdiv|udiv", lambda r: 12),
    (r"mla|mls", lambda r: 2),
    (r"bic|bfi|bfc", lambda r: 1),
    (r"b|cb", lambda r: 4),
)


@dataclasses.dataclass(frozen=True)
class Footprint:
    """What the C takes: bytes of flash and of RAM with the frame and the stack; instructions and cycles of a frame."""

    flash: int
    ram: int
    instructions: int
    cycles: int

    @property
    def milliseconds(self) -> float:
        """At 168 MHz."""
        return 1e3 * self.cycles / CLOCK_HZ


def measure(model: lgmd.LGMD2) -> Footprint:
    """Compile and emulate the C of a model.

    **Raises:** `subprocess.CalledProcessError` where a tool fails, `FileNotFoundError` where one is missing.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for path, text in sources(model, json.loads(json.dumps(document(model)))["test_vector"]).items():
            (folder / path).parent.mkdir(exist_ok=True)
            (folder / path).write_text(text)
        sizes = _run(folder, "make --no-print-directory robot")
        text, data, bss = map(int, sizes.splitlines()[-1].split()[:3])
        return Footprint(text + data, data + bss, *_emulated(folder))


def _emulated(folder: Path) -> tuple[int, int]:
    """Instructions and cycles of the last frame.

    The machine is one with more RAM than the chip, since not every QEMU has the chip's second block.
    """
    script = (folder / "stm32f407/stm32f407.ld").read_text()
    script = script.replace("ORIGIN = 0x08000000", "ORIGIN = 0").replace("LENGTH = 128K", "LENGTH = 4M")
    (folder / "emulated.ld").write_text(script)
    program = f"stm32f407/startup.c lgmd2.c {_HERE / 'cortex_m4.c'}"
    _run(folder, f"arm-none-eabi-gcc {_CORTEX_M4F} {_LINK} {program} -lm -o emulated.elf")
    symbols = {}
    for line in _run(folder, "arm-none-eabi-nm -S emulated.elf").splitlines():
        address, *size, _, symbol = line.split()
        symbols[symbol] = int(address, 16), int(size[0], 16) if size else 0
    start, length = symbols["main"]
    elsewhere = f"0..{start - 1:#x},{start + length:#x}..0xfffff"  # main only draws
    _run(
        folder,
        "qemu-system-arm -machine mps2-an386 -nographic -semihosting -d in_asm,exec,nochain "
        f"-dfilter {elsewhere} -D log -kernel emulated.elf",
    )
    step, _ = symbols["lgmd2_step"]
    blocks, executed = _blocks(folder / "log"), _executed(folder / "log")
    last_frame: Counter[int] = Counter()
    for address in executed:
        if address == step & ~1:
            last_frame.clear()
        last_frame[address] += 1
    instructions = sum(count * len(blocks[address]) for address, count in last_frame.items())
    return instructions, sum(count * sum(map(_cycles, blocks[address])) for address, count in last_frame.items())


def _blocks(log: Path) -> dict[int, list[str]]:
    """The instructions of each block, by the address of its first."""
    blocks, lines = {}, None
    with open(log) as file:
        for line in file:
            if line.startswith("IN:"):
                lines = []
            elif lines is not None and (code := re.match(r"0x([0-9a-f]+):  (?:[0-9a-f]{4} ?)+ +(.*)", line)):
                if not lines:
                    blocks[int(code[1], 16)] = lines
                lines.append(code[2])
    return blocks


def _executed(log: Path) -> Iterator[int]:
    """The address of each block that was executed, in order."""
    with open(log) as file:
        for line in file:
            if line.startswith("Trace"):
                yield int(line.split("/")[1], 16)


def _cycles(instruction: str) -> int:
    mnemonic, _, operands = instruction.partition(" ")
    registers = operands.count(",") + 1
    return next((cycles(registers) for start, cycles in _CYCLES if re.match(start, mnemonic)), 1)


def _run(folder: Path, command: str) -> str:
    return subprocess.run(
        command.split(), cwd=folder, check=True, stdin=subprocess.DEVNULL, capture_output=True, text=True
    ).stdout


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", nargs="*", default=["lgmd2", "preset:lgmd2"], help="as for lgmd2jax export")
    options = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    for name in options.model:
        model = as_lgmd2(model_named(name))
        model = dataclasses.replace(model, eye=EYE) if model.eye is None else lgmd.at_eye(model, EYE)
        footprint = measure(model)
        print(f"{name}, {EYE.rows} x {EYE.cols}, STM32F407:")
        print(f"  flash {footprint.flash:,} bytes; RAM {footprint.ram:,} of 196,608, with the frame and 4,096 of stack")
        print(f"  a frame: {footprint.instructions:,} instructions, {footprint.cycles:,} cycles by ARM's tables")
        print(f"  estimate: {footprint.milliseconds:.1f} ms a frame at {CLOCK_HZ / 1e6:g} MHz, 33.3 between two frames")


if __name__ == "__main__":
    main()
