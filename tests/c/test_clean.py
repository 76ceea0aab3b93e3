"""The C is clean: compilers with all warnings, sanitizers, cppcheck; and its own test tells right from wrong."""

import re
import subprocess

import pytest

from lgmd2jax._c.memory import memory
from tests.c.programs import EYE, MODELS, files, run, tool, written

STRICT = "-std=c99 -Wall -Wextra -Wconversion -Werror -pedantic -Wshadow -Wdouble-promotion"
PASSED = "test vector: 24 frames of 8 x 10 came out"
EVERY, PLAIN = "all mechanisms", "the paper's circuit"


def made(folder, compiler, flags):
    return run(tool("make"), "-B", "test", f"CC={tool(compiler)}", f"CFLAGS={flags}", folder=folder)


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("name", MODELS)
def test_compilers_have_no_warning_and_the_test_vector_comes_out(name, compiler, tmp_path):
    printed = made(written(tmp_path, files(name)), compiler, f"-O2 {STRICT}")
    assert printed.endswith(f"{PASSED}\n")
    assert "warning" not in printed
    run(tool(compiler), *STRICT.split(), "-O3", "-c", "lgmd2.c", "-o", "full_size.o", folder=tmp_path)


@pytest.mark.parametrize("name", [EVERY, "persistence, exact low-pass"])
def test_sanitizers_find_nothing(name, tmp_path):
    flags = "-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all"
    assert PASSED in made(written(tmp_path, files(name)), "gcc", flags)


@pytest.mark.parametrize("name", MODELS)
def test_cppcheck_finds_nothing(name, tmp_path):
    checks = ("--std=c99", "--enable=warning,style,performance,portability", "--error-exitcode=1", "--quiet")
    folder = written(tmp_path, files(name))
    assert run(tool("cppcheck"), *checks, "lgmd2.c", "test_lgmd2.c", folder=folder) == ""


def test_the_delays_may_lie_in_a_section_of_their_own(tmp_path):
    flags = "'-DLGMD2_DELAYS_SECTION=\".ccmram\"'"
    assert PASSED in made(written(tmp_path, files(EVERY)), "gcc", flags)


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("positive(-p[c])", "positive(p[c])"),
        (".w_bias = 0.3f", ".w_bias = 0.4f"),
        ("0.125f *", "0.25f *"),
        ("d_off[LGMD2_COLS + 1] = d_off[LGMD2_COLS];", "d_off[LGMD2_COLS + 1] = 0.0f;"),
        ("row < LGMD2_ROWS - 1 ? row + 1 : row", "row"),
        ("s >= v.T_s ? s : 0.0f", "s"),
        ("left * held[c]", "0.0f"),
        ("older.mp = newer.mp + share * (older.mp - newer.mp);", ""),
        ("- powf(1e-3f, v.gamma)", ""),
        ("state->excitation += ", "state->excitation = "),
        ("rise <= v.T_sfa ?", "true ?"),
        ("smp_adapted > 0.5f ? smp_adapted : 0.5f", "smp_adapted"),
        ("(state->smp_adapted > v.T_sp + v.sigma_sp)", "0"),
        ("count += state->spikes[i]", "count += 0"),
    ],
)
def test_a_wrong_equation_does_not_pass(right, wrong, tmp_path):
    texts = files(EVERY)
    assert texts["lgmd2.c"].count(right) == 1
    written(tmp_path, texts | {"lgmd2.c": texts["lgmd2.c"].replace(right, wrong)})
    command = (tool("make"), "-s", "test", f"CC={tool('gcc')}", "CFLAGS=-O0")
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2, done.stderr
    assert re.search(r"test vector: \w+ of frame \d+ is \S+, not \S+", done.stdout)


@pytest.mark.parametrize("name", MODELS)
def test_the_size_of_the_state_is_known_beforehand(name, tmp_path):
    program = '#include <stdio.h>\n#include "lgmd2.h"\nint main(void) { printf("%d", (int)sizeof(lgmd2_state)); }\n'
    folder = written(tmp_path, files(name) | {"size.c": program})
    for rows, cols in ((EYE.rows, EYE.cols), (7, 11)):
        size = (f"-DLGMD2_ROWS={rows}", f"-DLGMD2_COLS={cols}")
        run(tool("gcc"), "-std=c99", *size, "size.c", "-o", "size", folder=folder)
        assert memory(MODELS[name], rows, cols) == (int(run("./size", folder=folder)), rows * cols)


def test_a_robot_in_cpp_can_include_it(tmp_path):
    program = '#include "lgmd2.h"\nstatic lgmd2_state state;\nint main() { lgmd2_init(&state); return 0; }\n'
    folder = written(tmp_path, files(PLAIN) | {"robot.cpp": program})
    run(tool("gcc"), "-std=c99", "-c", "lgmd2.c", folder=folder)
    run(tool("g++"), "-Wall", "-Wextra", "-Werror", "robot.cpp", "lgmd2.o", "-lm", "-o", "robot", folder=folder)


def test_a_tool_that_must_be_there_is_no_skip(monkeypatch):
    monkeypatch.delenv("LGMD2JAX_REQUIRE_TOOLS", raising=False)
    with pytest.raises(pytest.skip.Exception, match="no-such-tool is not installed"):
        tool("no-such-tool")
    monkeypatch.setenv("LGMD2JAX_REQUIRE_TOOLS", "1")
    with pytest.raises(pytest.fail.Exception, match="no-such-tool is not installed"):
        tool("no-such-tool")


def test_a_frame_below_three_rows_does_not_compile(tmp_path):
    command = (tool("gcc"), "-std=c99", "-DLGMD2_ROWS=2", "-c", "lgmd2.c")
    done = subprocess.run(command, cwd=written(tmp_path, files(PLAIN)), capture_output=True, text=True)
    assert "a frame has at least 3 x 3 pixels" in done.stderr
