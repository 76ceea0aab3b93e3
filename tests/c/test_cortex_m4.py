"""The C on an emulated Cortex-M4F, the core of the paper's robot: its own test, its memory, and the time of a frame."""

import re
import subprocess

import pytest

import lgmd2jax as lgmd
from benchmarks import cortex_m4
from lgmd2jax._c.memory import memory
from tests.c.programs import ROBOT, files, robot_files, run, shipped, tool, written

RAM, CCM, FRAME_MS = 128 * 1024, 64 * 1024, 30.0
STACK, C_LIBRARY = 4096, 2048
WARNINGS = "STRICT=-std=c99 -Wall -Wextra -Wconversion -Werror"


@pytest.fixture(autouse=True)
def tools():
    for name in cortex_m4.TOOLS:
        tool(name)


@pytest.mark.parametrize("name", ["the paper's circuit", "persistence, exact low-pass", "all mechanisms"])
def test_the_test_vector_comes_out_under_emulation(name, tmp_path):
    printed = run("make", WARNINGS, "emulation", folder=written(tmp_path, files(name)))
    assert printed.endswith("test vector: 24 frames of 8 x 10 came out\n")


def test_a_wrong_number_does_not_pass_under_emulation(tmp_path):
    texts = files("all mechanisms")
    written(tmp_path, texts | {"lgmd2.c": texts["lgmd2.c"].replace(".gamma = 0.65f", ".gamma = 0.66f")})
    done = subprocess.run(["make", "emulation"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 2
    assert re.search(r"test vector: smp of frame \d+ is", done.stdout)


def test_the_shipped_fit_fits_into_both_blocks_of_ram(tmp_path):
    model = shipped("lgmd2")
    folder = written(tmp_path, robot_files(model))
    run("make", WARNINGS, "robot", folder=folder)
    symbols = run("arm-none-eabi-nm", "-S", "build/robot.elf", folder=folder)
    places = {name: (int(at, 16), int(size, 16)) for at, size, name in re.findall(r"(\w+) (\w+) b (\w+)\n", symbols)}
    delays, state = places["placed"], places["state"]
    assert delays[0] >= 0x10000000
    assert delays[1] <= CCM
    assert state[0] >= 0x20000000
    assert state[1] + places["grey"][1] <= RAM
    needs = memory(model, ROBOT.rows, ROBOT.cols)
    assert delays[1] + state[1] == needs.state + 4  # the pointer to the delays
    assert places["grey"][1] == needs.frame


@pytest.mark.parametrize("name", ["lgmd2", "preset:lgmd2"])
def test_a_frame_takes_less_than_the_paper_allows(name, record_property):
    model = lgmd.LGMD2(eye=ROBOT) if name.startswith("preset") else shipped(name)
    footprint = cortex_m4.measure(model)
    needs = memory(model, ROBOT.rows, ROBOT.cols)
    record_property(
        "table",
        f"{name}: flash {footprint.flash:,}, RAM {footprint.ram:,} bytes; {footprint.instructions:,} instructions a "
        f"frame; estimate {footprint.milliseconds:.1f} ms at 168 MHz",
    )
    assert 0 < footprint.ram - needs.state - needs.frame <= STACK + C_LIBRARY
    assert footprint.ram < RAM + CCM
    pixels = ROBOT.rows * ROBOT.cols
    assert 40 * pixels < footprint.instructions < footprint.cycles < 400 * pixels
    assert footprint.milliseconds < FRAME_MS


def test_instructions_cost_what_arm_states():
    costs = {
        "vldr     s0, [r0]": 2,
        "vmul.f32 s0, s1, s2": 2,
        "vdiv.f32 s0, s1, s2": 14,
        "vpush    {d8, d9}": 3,
        "push.w   {r4, r5, r6, lr}": 5,
        "pop.w    {r4, pc}": 6,
        "bne      #0x10": 4,
        "bic      r0, r1": 1,
        "ldrb.w   r3, [r4]": 2,
        "adds     r1, #1": 1,
        "cbz      r0, #0x20": 4,
    }
    assert {instruction: cortex_m4._cycles(instruction) for instruction in costs} == costs
